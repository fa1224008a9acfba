// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Small meshes for tests and benchmarks.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg::testing {

/// m, of the edges of soft bodies.
inline constexpr double kSoftEdge = 4e-3;

/// A box of cubes, each split into six tetrahedra around its main diagonal (Kuhn), so that
/// neighbouring cubes agree on their face diagonals.
/// @param cells   cubes along x, y and z
/// @param edge    m
/// @param jitter  largest displacement of a vertex as a share of the edge; 0.1 keeps all tets valid
inline TetMesh make_box(std::array<Index, 3> cells, double edge, double jitter = 0,
                        std::uint64_t seed = 1) {
  const auto id = [&](Index i, Index j, Index k) {
    return i + (cells[0] + 1) * (j + (cells[1] + 1) * k);
  };
  std::vector<Eigen::Vector3d> points;
  for (Index k = 0; k <= cells[2]; ++k) {
    for (Index j = 0; j <= cells[1]; ++j) {
      for (Index i = 0; i <= cells[0]; ++i) {
        Eigen::Vector3d p(i, j, k);
        for (int axis = 0; axis < 3; ++axis) {
          p[axis] += jitter * (2 * random_unit(seed, points.size(), axis) - 1);
        }
        points.push_back(edge * p);
      }
    }
  }
  // the six orders of the axes are the six paths from one corner to the opposite one
  constexpr std::array<std::array<int, 3>, 6> kPaths{
      {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}}};
  std::vector<Tet> tets;
  for (Index k = 0; k < cells[2]; ++k) {
    for (Index j = 0; j < cells[1]; ++j) {
      for (Index i = 0; i < cells[0]; ++i) {
        for (const auto& path : kPaths) {
          std::array<Index, 3> corner{i, j, k};
          Tet tet{id(i, j, k), 0, 0, 0};
          for (int s = 0; s < 3; ++s) {
            ++corner[path[s]];
            tet[s + 1] = id(corner[0], corner[1], corner[2]);
          }
          tets.push_back(tet);
        }
      }
    }
  }
  orient_tets(points, tets);
  return TetMesh(std::move(points), std::move(tets));
}

/// One tetrahedron of a given size, positive, with corners at random near a regular one.
inline std::array<Eigen::Vector3d, 4> random_tet(double edge, std::uint64_t seed) {
  std::array<Eigen::Vector3d, 4> x{{{0, 0, 0}, {1, 0, 0}, {0.5, 0.87, 0}, {0.5, 0.29, 0.82}}};
  for (std::uint64_t i = 0; i < 4; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      x[i][axis] = edge * (x[i][axis] + 0.4 * (random_unit(seed, i, axis) - 0.5));
    }
  }
  return x;
}

}  // namespace pbdsurg::testing
