// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An edited scene as plainly as can be, to compare a solver with.

#include <string>
#include <vector>

#include "pbdsurg/edit/live_pieces.h"
#include "pbdsurg/edit/live_surface.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/thermal/heat_field.h"

namespace pbdsurg::testing {

/// Knows what is alive and its rest values, and finds all else afresh whenever it is asked: edges,
/// masses, constraints, surface. Nothing is kept up, so nothing can lag behind.
class LiveModel {
 public:
  /// @param solver  of the scene, not edited; the scene must outlive the model
  LiveModel(const Scene& scene, const Solver& solver);

  /// @param edit  that the solver accepted
  void apply(const TopologyEdit& edit);

  /// What of a solver is not as it must be, the first of it, in words; empty if all is. It sees
  /// topology, masses, every constraint with its vertices and parameters, colours and phases, who
  /// owns edges in a joint plan, and the surface.
  /// Cost: O(n log n) in the scene.
  [[nodiscard]] std::string difference(const Solver& solver) const;

  /// The same of a heat field that followed the edits of a body and has not been heated: heat must
  /// spread as in one that is made of what is left.
  [[nodiscard]] std::string difference(const HeatField& field, const ThermalBody& body) const;

  /// The same of the surface of a body, and of the pieces of all.
  [[nodiscard]] std::string difference(const LiveSurface& surface, const Solver& solver,
                                       Index body) const;
  [[nodiscard]] std::string difference(const LivePieces& pieces, const Solver& solver) const;

 private:
  const Scene* scene_;
  std::vector<bool> tet_alive_, link_alive_;
  std::vector<float> rest_lengths_;  // [edge_count] m
  std::vector<float> rest_volumes_;  // [tet_count] m^3
};

}  // namespace pbdsurg::testing
