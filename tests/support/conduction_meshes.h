// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Meshes bounded by the coordinate surfaces of problems whose potential is known.

#include <cmath>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// A box of n x n x layers cells in [0, 1]^3, mapped; tetrahedra that become flat are left out.
inline TetMesh make_mapped_box(Index n, Index layers,
                               const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& map) {
  const TetMesh box = make_box({n, n, layers}, 1);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : box.positions()) {
    points.push_back(map({p.x() / n, p.y() / n, p.z() / layers}));
  }
  std::vector<Tet> tets;
  for (const Tet& tet : box.tets()) {
    if (!is_flat(points, tet)) {
      tets.push_back(tet);
    }
  }
  orient_tets(points, tets);
  return {std::move(points), std::move(tets)};
}

/// A sixth of the space between two spheres, n x n x 2n cells: a cube's face seen from its middle.
/// Its sides pass through the centre.
/// @param inner, outer  radii, m
inline TetMesh make_sphere_sector(Index n, double inner, double outer) {
  return make_mapped_box(n, 2 * n, [=](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const auto side = [](double t) { return std::tan((2 * t - 1) * std::numbers::pi / 4); };
    const Eigen::Vector3d direction(side(p.x()), side(p.y()), 1);
    return inner * std::pow(outer / inner, p.z()) * direction.normalized();
  });
}

/// A quarter of the half-space below a disk in the plane z = 0, n x n x 3n cells in oblate
/// spheroidal coordinates: the sheets k / 3n of the way out have sinh(mu) =
/// sinh(k / 3n asinh(outer / radius)). The disk is mu = 0, the plane around it and the two planes
/// of the cut are surfaces that no current crosses.
/// @param radius, outer  of the disk, and half the thickness of the outermost spheroid, m
inline TetMesh make_disk_quarter(Index n, double radius, double outer) {
  return make_mapped_box(n, 3 * n, [=](const Eigen::Vector3d& p) -> Eigen::Vector3d {
    const double s = std::max(p.x(), p.y());
    const double share = s > 0 ? std::min(p.x(), p.y()) / s : 0;
    const double turn = share * std::numbers::pi / 4;
    const double phi = p.x() >= p.y() ? turn : std::numbers::pi / 2 - turn;
    const double rho = s == 1 ? 1 : std::sin(s * std::numbers::pi / 2);
    const double depth = s == 1 ? 0 : std::cos(s * std::numbers::pi / 2);
    const double mu = p.z() * std::asinh(outer / radius);
    return radius * Eigen::Vector3d(std::cosh(mu) * rho * std::cos(phi),
                                    std::cosh(mu) * rho * std::sin(phi), std::sinh(mu) * depth);
  });
}

}  // namespace pbdsurg::testing
