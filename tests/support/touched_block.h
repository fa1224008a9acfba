// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A block that an electrode touches, for tests of current.

#include <array>
#include <numbers>
#include <vector>

#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"
#include "tests/support/scenes.h"

namespace pbdsurg::testing {

inline constexpr double kTouchedEdge = 1e-3;  // m
inline constexpr double kTouchedSigma = 0.3;  // S/m

/// A block whose upper face an electrode touches.
struct TouchedBlock {
  explicit TouchedBlock(std::array<Index, 3> cells, double jitter = 0,
                        const PotentialOptions& options = {})
      : shape(make_box(cells, kTouchedEdge, jitter)),
        tissue(scene_of(shape)),
        mesh(tissue, std::array{ThermalBody{0, tissues::liver().heat}}),
        conductivities(shape.tets().size(), kTouchedSigma),
        field(mesh, options),
        top(cells[2] * kTouchedEdge),
        centre(cells[0] / 2 * kTouchedEdge, cells[1] / 2 * kTouchedEdge, top) {}

  // Vertices of the upper face within a radius of a point of it.
  [[nodiscard]] std::vector<PatchVertex> disk(const Eigen::Vector3d& middle, double radius) const {
    return patch_where(mesh, [&](const Eigen::Vector3d& x) {
      return x.z() > top - 0.3 * kTouchedEdge && (x - middle).norm() < radius;
    });
  }

  void remove(const std::vector<Index>& tets) { tissue.apply({.remove_tets = tets}); }

  [[nodiscard]] std::vector<Index> tets_where(const Where& where) const {
    std::vector<Index> found;
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const Index v : mesh.tets()[t]) {
        middle += mesh.rest_positions()[v] / 4;
      }
      if (where(middle)) {
        found.push_back(t);
      }
    }
    return found;
  }

  const PotentialReport& solve() { return field.solve(conductivities); }

  TetMesh shape;
  Tissue tissue;
  ThermalMesh mesh;
  std::vector<double> conductivities;  // [tet_count] S/m
  PotentialField field;
  double top;              // m
  Eigen::Vector3d centre;  // m, of the upper face
};

/// Of a disk, m^2.
inline double area_of(double radius) {
  return std::numbers::pi * radius * radius;
}

}  // namespace pbdsurg::testing
