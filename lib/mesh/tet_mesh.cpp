// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/tet_mesh.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/mesh/vertex_ids.h"

namespace pbdsurg {
namespace {

std::string describe(Index t, const Tet& tet) {
  std::ostringstream text;
  text << "tet " << t << " (vertices " << tet[0] << ' ' << tet[1] << ' ' << tet[2] << ' ' << tet[3]
       << ")";
  return text.str();
}

std::string format(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

void check_positions(std::span<const Eigen::Vector3d> positions) {
  if (positions.size() > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
    throw InvalidMesh("a mesh may have at most 2147483647 vertices, got " +
                      std::to_string(positions.size()));
  }
  for (std::size_t v = 0; v < positions.size(); ++v) {
    if (!positions[v].allFinite()) {
      throw InvalidMesh("vertex " + std::to_string(v) + " is at (" + format(positions[v].x()) +
                        ", " + format(positions[v].y()) + ", " + format(positions[v].z()) +
                        "); positions must be finite");
    }
  }
}

void check_ids(std::span<const Tet> tets, Index vertex_count) {
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const Tet& tet = tets[t];
    for (int i = 0; i < 4; ++i) {
      if (tet[i] < 0 || tet[i] >= vertex_count) {
        throw InvalidMesh(describe(static_cast<Index>(t), tet) + " refers to vertex " +
                          std::to_string(tet[i]) + "; ids must be in [0, " +
                          std::to_string(vertex_count) + ")");
      }
      for (int j = 0; j < i; ++j) {
        if (tet[i] == tet[j]) {
          throw InvalidMesh(describe(static_cast<Index>(t), tet) +
                            " uses a vertex twice; the four must differ");
        }
      }
    }
  }
}

void check_volumes(std::span<const Eigen::Vector3d> positions, std::span<const Tet> tets) {
  for (std::size_t t = 0; t < tets.size(); ++t) {
    const double volume = tet_volume(positions, tets[t]);
    if (is_flat(positions, tets[t])) {
      throw InvalidMesh(describe(static_cast<Index>(t), tets[t]) + " is flat: rest volume " +
                        format(volume) + " m^3 is zero to rounding; it must be positive");
    }
    if (volume < 0) {
      throw InvalidMesh(describe(static_cast<Index>(t), tets[t]) + " is inverted: rest volume " +
                        format(volume) + " m^3; it must be positive");
    }
  }
}

void check_duplicates(std::span<const Tet> tets) {
  std::vector<std::pair<Tet, Index>> keys(tets.size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    keys[t] = {tets[t], static_cast<Index>(t)};
    std::sort(keys[t].first.begin(), keys[t].first.end());
  }
  std::sort(keys.begin(), keys.end());
  const auto same = std::adjacent_find(
      keys.begin(), keys.end(), [](const auto& a, const auto& b) { return a.first == b.first; });
  if (same != keys.end()) {
    throw InvalidMesh(describe(std::next(same)->second, tets[std::next(same)->second]) +
                      " repeats tet " + std::to_string(same->second) +
                      "; each may occur only once");
  }
}

}  // namespace

TetMesh::TetMesh(std::vector<Eigen::Vector3d> positions, std::vector<Tet> tets)
    : positions_(std::move(positions)), tets_(std::move(tets)) {
  check_positions(positions_);
  check_ids(tets_, vertex_count());
  check_volumes(positions_, tets_);
  check_duplicates(tets_);
}

double tet_volume(std::span<const Eigen::Vector3d> positions, const Tet& tet) {
  const Eigen::Vector3d& origin = positions[tet[0]];
  const Eigen::Vector3d a = positions[tet[1]] - origin;
  const Eigen::Vector3d b = positions[tet[2]] - origin;
  const Eigen::Vector3d c = positions[tet[3]] - origin;
  return a.cross(b).dot(c) / 6.0;
}

bool is_flat(std::span<const Eigen::Vector3d> positions, const Tet& tet) {
  double longest = 0;   // squared edge length
  double farthest = 0;  // largest coordinate, which sets the rounding of differences
  for (int i = 0; i < 4; ++i) {
    farthest = std::max(farthest, positions[tet[i]].cwiseAbs().maxCoeff());
    for (int j = 0; j < i; ++j) {
      longest = std::max(longest, (positions[tet[i]] - positions[tet[j]]).squaredNorm());
    }
  }
  // A volume is a sum of products of three differences, each exact to epsilon times its operands.
  constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
  const double rounding = 4 * kEpsilon * longest * (farthest + std::sqrt(longest));
  return !(std::abs(tet_volume(positions, tet)) > rounding);
}

Index orient_tets(std::span<const Eigen::Vector3d> positions, std::span<Tet> tets) {
  check_vertex_ids(static_cast<Index>(positions.size()), std::span<const Tet>(tets));
  Index swapped = 0;
  for (Tet& tet : tets) {
    if (tet_volume(positions, tet) < 0) {
      std::swap(tet[2], tet[3]);
      ++swapped;
    }
  }
  return swapped;
}

double total_volume(const TetMesh& mesh) {
  double sum = 0;
  for (const Tet& tet : mesh.tets()) {
    sum += tet_volume(mesh.positions(), tet);
  }
  return sum;
}

Eigen::AlignedBox3d bounding_box(const TetMesh& mesh) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& x : mesh.positions()) {
    box.extend(x);
  }
  return box;
}

std::vector<double> lumped_masses(const TetMesh& mesh, double density) {
  if (!(density > 0) || !std::isfinite(density)) {
    throw InvalidArgument("density is " + format(density) +
                          " kg/m^3; it must be positive and finite");
  }
  std::vector<double> masses(static_cast<std::size_t>(mesh.vertex_count()), 0.0);
  for (const Tet& tet : mesh.tets()) {
    const double quarter = density * tet_volume(mesh.positions(), tet) / 4;
    for (const Index v : tet) {
      masses[v] += quarter;
    }
  }
  return masses;
}

}  // namespace pbdsurg
