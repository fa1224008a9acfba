// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All connective tissue of a scene as sheets.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "apps/cholecystectomy/membrane_sheets.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/surgical_scene.h"

namespace cholecystectomy {

class SceneSheets {
 public:
  explicit SceneSheets(const SurgicalScene& scene);

  /// @param simulation  of that scene
  /// @param burns  [vertex_count of the tissue] burn_layers()
  void update(const Simulation& simulation, std::span<const Eigen::Vector4f> burns);

  /// As of the last update, one of each kind.
  [[nodiscard]] std::span<const Surface> surfaces() const noexcept { return sheets_.surfaces(); }

 private:
  MembraneSheets sheets_;
  std::vector<SheetLinkState> states_;  // [link]
};

}  // namespace cholecystectomy
