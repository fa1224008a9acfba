// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Meshes of sheets for tests and benchmarks.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg::testing {

inline constexpr double kSheetEdge = 4e-3;  // m, of most sheets

struct SheetMesh {
  std::vector<Eigen::Vector3d> positions;  ///< m
  std::vector<Triangle> triangles;         ///< wound about z
};

/// A rectangle in the plane of x and y, of squares halved along diagonals that alternate.
/// @param cells   squares along x and y
/// @param edge    m
/// @param jitter  largest displacement of an inner vertex in the plane as a share of the edge
inline SheetMesh make_sheet(std::array<Index, 2> cells, double edge, double jitter = 0,
                            std::uint64_t seed = 1) {
  SheetMesh mesh;
  const auto id = [&](Index i, Index j) { return i + (cells[0] + 1) * j; };
  for (Index j = 0; j <= cells[1]; ++j) {
    for (Index i = 0; i <= cells[0]; ++i) {
      Eigen::Vector3d x(i, j, 0);
      const bool is_inner = i > 0 && i < cells[0] && j > 0 && j < cells[1];
      for (int axis = 0; axis < 2 && is_inner; ++axis) {
        x[axis] += jitter * (2 * random_unit(seed, mesh.positions.size(), axis) - 1);
      }
      mesh.positions.push_back(edge * x);
    }
  }
  for (Index j = 0; j < cells[1]; ++j) {
    for (Index i = 0; i < cells[0]; ++i) {
      const Index a = id(i, j), b = id(i + 1, j), c = id(i + 1, j + 1), d = id(i, j + 1);
      if ((i + j) % 2 == 0) {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      } else {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      }
    }
  }
  return mesh;
}

/// The vertices along the rim of make_sheet(), ascending.
inline std::vector<Index> rim_of_sheet(std::array<Index, 2> cells) {
  std::vector<Index> rim;
  for (Index j = 0; j <= cells[1]; ++j) {
    for (Index i = 0; i <= cells[0]; ++i) {
      if (i == 0 || j == 0 || i == cells[0] || j == cells[1]) {
        rim.push_back(i + (cells[0] + 1) * j);
      }
    }
  }
  return rim;
}

/// As make_sheet(), along diagonals that all go the same way, from the origin.
inline SheetMesh make_slanted_sheet(std::array<Index, 2> cells, double edge) {
  SheetMesh mesh = make_sheet(cells, edge);
  mesh.triangles.clear();
  for (Index j = 0; j < cells[1]; ++j) {
    for (Index i = 0; i < cells[0]; ++i) {
      const Index a = i + (cells[0] + 1) * j, d = a + cells[0] + 1;
      mesh.triangles.push_back({a, a + 1, d + 1});
      mesh.triangles.push_back({a, d + 1, d});
    }
  }
  return mesh;
}

/// A rectangle of equilateral triangles, as hinges bend like a plate along any axis: columns along
/// y, every other of which is half an edge further.
/// @param cells  between columns, and along each
/// @param edge   m
inline SheetMesh make_plate(std::array<Index, 2> cells, double edge) {
  SheetMesh mesh;
  const auto id = [&](Index i, Index j) { return i + (cells[0] + 1) * j; };
  for (Index j = 0; j <= cells[1]; ++j) {
    for (Index i = 0; i <= cells[0]; ++i) {
      mesh.positions.emplace_back(edge * std::numbers::sqrt3 / 2 * i,
                                  edge * (j + (i % 2 == 0 ? 0 : 0.5)), 0);
    }
  }
  for (Index j = 0; j < cells[1]; ++j) {
    for (Index i = 0; i < cells[0]; ++i) {
      const Index a = id(i, j), b = id(i + 1, j), c = id(i + 1, j + 1), d = id(i, j + 1);
      if (i % 2 == 0) {
        mesh.triangles.push_back({a, b, d});
        mesh.triangles.push_back({b, c, d});
      } else {
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
    }
  }
  return mesh;
}

/// A disc around the origin in the plane of x and y, of rings with six vertices more each.
/// @param rings   beside the vertex in the middle
/// @param radius  m
inline SheetMesh make_disc(Index rings, double radius) {
  SheetMesh mesh;
  mesh.positions.emplace_back(0, 0, 0);
  const auto first = [](Index ring) { return ring == 0 ? 0 : 1 + 3 * ring * (ring - 1); };
  const auto id = [&](Index ring, Index i) { return ring == 0 ? 0 : first(ring) + i % (6 * ring); };
  for (Index ring = 1; ring <= rings; ++ring) {
    for (Index i = 0; i < 6 * ring; ++i) {
      const double angle = 2 * std::numbers::pi * i / (6.0 * ring), r = radius * ring / rings;
      mesh.positions.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    for (Index sector = 0; sector < 6; ++sector) {
      for (Index i = 0; i < ring; ++i) {
        const Index outer = sector * ring + i, inner = sector * (ring - 1) + i;
        mesh.triangles.push_back({id(ring, outer), id(ring, outer + 1), id(ring - 1, inner)});
        if (i + 1 < ring) {
          mesh.triangles.push_back(
              {id(ring - 1, inner), id(ring, outer + 1), id(ring - 1, inner + 1)});
        }
      }
    }
  }
  return mesh;
}

/// A tube around z, open at both ends, of four flat walls of two triangles each.
/// @param width   m
/// @param length  m
inline SheetMesh make_square_tube(double width, double length) {
  constexpr Index kSides = 4;
  SheetMesh mesh;
  for (Index side = 0; side < kSides; ++side) {
    const double x = side == 1 || side == 2 ? width / 2 : -width / 2;
    const double y = side < 2 ? -width / 2 : width / 2;
    mesh.positions.emplace_back(x, y, -length / 2);
    mesh.positions.emplace_back(x, y, length / 2);
    const Index low = 2 * side, next = 2 * ((side + 1) % kSides);
    mesh.triangles.push_back({low, next, next + 1});
    mesh.triangles.push_back({low, next + 1, low + 1});
  }
  return mesh;
}

/// Whether such a tube, once moved, goes around a line along z at both of its ends.
/// @param corners  m, as of make_square_tube()
inline bool is_around(const std::vector<Eigen::Vector3f>& corners, const Eigen::Vector3f& line) {
  for (std::size_t end = 0; end < 2; ++end) {
    float turned = 0;
    for (std::size_t k = end; k < corners.size(); k += 2) {
      const Eigen::Vector3f a = corners[k] - line, b = corners[(k + 2) % corners.size()] - line;
      turned += std::atan2(a.x() * b.y() - a.y() * b.x(), a.head<2>().dot(b.head<2>()));
    }
    if (std::abs(turned) < std::numbers::pi_v<float>) {  // all around, or nothing
      return false;
    }
  }
  return true;
}

/// Where a rod along z is, step by step, that is thrust from the axis of such a tube through one of
/// its walls, the wall across and back, in a direction and at 0.1 to 1 m/s by chance.
/// @param step   s
/// @param visit  (place) m
template <class Visit>
void for_each_thrust(std::uint64_t seed, std::uint64_t shot, float step, const Visit& visit) {
  constexpr float kReach = 20e-3F;  // m
  const auto random = [&](std::uint64_t k) {
    return static_cast<float>(random_unit(seed, shot, k));
  };
  const float angle = 2 * std::numbers::pi_v<float> * random(0), speed = 0.1F + 0.9F * random(1);
  const Eigen::Vector3f way(std::cos(angle), std::sin(angle), 0);
  float gone = 0;
  for (const float end : {kReach, -kReach, 0.0F}) {
    while (gone != end) {
      gone += std::clamp(end - gone, -speed * step, speed * step);
      visit(Eigen::Vector3f(gone * way));
    }
  }
}

}  // namespace pbdsurg::testing
