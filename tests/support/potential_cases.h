// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tissue between electrodes, for tests of current.

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/scenes.h"

namespace pbdsurg::testing {

using Where = std::function<bool(const Eigen::Vector3d&)>;

inline std::vector<PatchVertex> patch_where(const ThermalMesh& mesh, const Where& where) {
  std::vector<PatchVertex> patch;
  for (Index v = 0; v < mesh.vertex_count(); ++v) {
    if (where(mesh.rest_positions()[v])) {
      patch.push_back({v, 1});
    }
  }
  return patch;
}

/// A field between an electrode and a ground that hold all vertices at two places.
struct Conductor {
  Conductor(const TetMesh& of, const Where& electrode, const Where& ground, double sigma,
            const PotentialOptions& options = {.tolerance = 1e-12, .most_iterations = 5000})
      : tissue(scene_of(of)),
        mesh(tissue, std::array{ThermalBody{0, tissues::liver().heat}}),
        conductivities(of.tets().size(), sigma),
        field(mesh, options),
        patch(patch_where(mesh, electrode)) {
    for (const PatchVertex& held : patch_where(mesh, ground)) {
      ground_vertices.push_back(held.vertex);
    }
    field.set_patch(patch, 1e-6);
    field.set_ground(ground_vertices);
  }

  const PotentialReport& solve() { return field.solve(conductivities); }

  Tissue tissue;
  ThermalMesh mesh;
  std::vector<double> conductivities;  // [tet_count] S/m
  PotentialField field;
  std::vector<PatchVertex> patch;
  std::vector<Index> ground_vertices;
};

/// [vertex_count of the mesh] what a field has at the vertices of its region, zero outside.
inline std::vector<double> spread(const PotentialField& field, std::span<const double> values,
                                  Index vertex_count) {
  std::vector<double> all(static_cast<std::size_t>(vertex_count), 0.0);
  for (std::size_t row = 0; row < values.size(); ++row) {
    all[field.vertices()[row]] = values[row];
  }
  return all;
}

/// [vertex_count of the mesh] A at one volt that vertices take up: what of K u is not zero.
inline std::vector<double> currents(const ThermalMesh& mesh, const PotentialField& field,
                                    const std::vector<double>& conductivities) {
  const std::vector<double> u = spread(field, field.potentials(), mesh.vertex_count());
  std::vector<double> sums(u.size(), 0.0);
  for (const Index t : field.elements()) {
    for (std::size_t k = 0; k < 6; ++k) {
      const Index a = mesh.tets()[t][kTetEdges[k][0]];
      const Index b = mesh.tets()[t][kTetEdges[k][1]];
      const double flow = conductivities[t] * mesh.edge_coefficients(t)[k] * (u[a] - u[b]);
      sums[a] += flow;
      sums[b] -= flow;
    }
  }
  return sums;
}

inline double sum(std::span<const double> values) {
  double total = 0;
  for (const double value : values) {
    total += value;
  }
  return total;
}

}  // namespace pbdsurg::testing
