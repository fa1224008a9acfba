// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All connective tissue of a scene as sheets.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

#include "apps/cholecystectomy/membrane_sheets.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/surgical_scene.h"

namespace cholecystectomy {

/// Links of a joint that begin in one vertex are one to the sheets, to the middle of their ends: a
/// user's coarse mesh has bundles of them.
class SceneSheets {
 public:
  explicit SceneSheets(const SurgicalScene& scene);

  /// @param simulation  of that scene
  /// @param burns  [vertex_count of the tissue] burn_layers()
  void update(const Simulation& simulation, std::span<const Eigen::Vector4f> burns);

  /// As of the last update, one of each kind.
  [[nodiscard]] std::span<const Surface> surfaces() const noexcept { return sheets_.surfaces(); }

 private:
  struct Bundle {
    pbdsurg::Index first_link, link_count;
  };
  static std::vector<Bundle> bundles_of(const SurgicalScene& scene);
  static MembraneSheets make_sheets(const SurgicalScene& scene, const std::vector<Bundle>& bundles);

  std::vector<Bundle> bundles_;
  MembraneSheets sheets_;
  std::vector<SheetLinkState> states_;  // [bundle]
};

}  // namespace cholecystectomy
