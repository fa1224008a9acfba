// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From the simulation to what the window draws.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/views/change_log.h"

#include "apps/cholecystectomy/burn_layers.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/scene_sheets.h"
#include "apps/cholecystectomy/simulation.h"
#include "apps/cholecystectomy/skin_record.h"

namespace cholecystectomy {

/// All organs at rest and the wall around them, as they are before there is a solver.
[[nodiscard]] std::vector<Surface> rest_surfaces(const SurgicalScene& scene,
                                                 const pbdsurg::MeshData& backdrop);

/// Fills states with what a window that has seen others lacks. Cost: O(vertices) for positions,
/// O(changed) for the rest.
class SceneFeed {
 public:
  /// @param simulation  of which nothing has burnt yet; kept by reference
  /// @param generation  of its states, above zero
  SceneFeed(const Simulation& simulation, const pbdsurg::MeshData& backdrop,
            std::uint32_t generation);

  /// Of the states to come.
  [[nodiscard]] std::uint32_t generation() const { return generation_; }

  /// Which triangles are skin now. A copy follows nothing.
  [[nodiscard]] const SkinRecord& skin() const { return skin_; }

  /// Goes on with another simulation of the same scene, kept by reference: surfaces come whole, in
  /// a new generation.
  /// @param skin  of a feed when its simulation was as this one is now
  void begin_anew(const Simulation& simulation, const SkinRecord& skin);

  /// Surfaces and sheets of the state. @param state  may hold an older one
  void fill(SceneState& state, const Seen& seen);

 private:
  [[nodiscard]] bool is_inner(const pbdsurg::Surface& surface,
                              const pbdsurg::Triangle& triangle) const;
  [[nodiscard]] Surface whole_surface(Organ organ) const;
  void fill(Organ organ, SurfaceChange& change, std::size_t seen_vertices,
            std::uint64_t seen_triangles, std::uint64_t seen_burns);

  const Simulation* simulation_;
  const pbdsurg::MeshData& backdrop_;
  std::uint32_t generation_;
  std::optional<BurnLayers> burns_;
  SceneSheets sheets_;
  SkinRecord skin_;
  std::vector<pbdsurg::SlotRange> ranges_;  // scratch
};

}  // namespace cholecystectomy
