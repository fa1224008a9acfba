// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What problems of conduction with a closed form have in common.

#include <numeric>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg::testing {

/// The whole mesh in every step, solved to rounding.
inline const HeatOptions kExact{.active_rise = 0, .tolerance = 1e-12};

/// Conduction alone.
inline ThermalModel dry_model(double theta = 1) {
  ThermalModel model;
  model.has_latent_heat = false;
  model.removal = RemovalRule::boiled_vertices;
  model.theta = theta;
  return model;
}

/// The face x = 0 of a box.
inline bool is_face(const Eigen::Vector3d& x) {
  return x.x() == 0;
}

/// The ids of all vertices.
inline std::vector<Index> all_of(const TetMesh& mesh) {
  std::vector<Index> all(mesh.positions().size());
  std::iota(all.begin(), all.end(), 0);
  return all;
}

/// To the steady state: each step leaves a share of 1e-3 or less of what is off it.
/// @return  whether all converged
inline bool settle(HeatField& field) {
  bool converged = true;
  for (int i = 0; i < 4; ++i) {
    converged = field.step(1e5, {}).converged && converged;
  }
  return converged;
}

}  // namespace pbdsurg::testing
