// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/point_check.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <tuple>
#include <unordered_map>

namespace pbdsurg {
namespace {

/// Cells are this many distances wide: few enough points lie near a cell's border, and a cell holds
/// a bounded number of points that are farther apart than the distance.
constexpr double kCellWidth = 8;

}  // namespace

RepeatedPoints find_repeated_points(std::span<const Eigen::Vector3d> points,
                                    std::span<const Index> ids, double distance) {
  RepeatedPoints repeated;
  std::vector<Index> order(ids.begin(), ids.end());
  const auto key = [&](Index i) { return std::tuple(points[i].x(), points[i].y(), points[i].z()); };
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<Index> distinct;
  for (const Index i : order) {
    if (!distinct.empty() && key(distinct.back()) == key(i)) {
      repeated.exact.emplace_back(i, distinct.back());
    } else {
      distinct.push_back(i);
    }
  }
  std::sort(repeated.exact.begin(), repeated.exact.end());
  if (!(distance > 0) || distinct.empty()) {
    return repeated;
  }

  std::sort(distinct.begin(), distinct.end());
  Eigen::Vector3d low = points[distinct.front()];
  for (const Index i : distinct) {
    low = low.cwiseMin(points[i]);
  }
  // looked up, never iterated, so that its order does not show
  std::unordered_map<std::uint64_t, std::vector<Index>> cells;
  cells.reserve(distinct.size());
  constexpr int kBits = 21;
  const auto cell_range = [&](const Eigen::Vector3d& p, int axis) {
    const double at = (p[axis] - low[axis]) / distance;
    const auto cell = [](double x) {
      return static_cast<std::uint64_t>(std::max(0.0, std::floor(x / kCellWidth)));
    };
    return std::array<std::uint64_t, 3>{cell(at - 1), cell(at), cell(at + 1)};
  };
  for (const Index i : distinct) {
    const Eigen::Vector3d& p = points[i];
    const auto x = cell_range(p, 0), y = cell_range(p, 1), z = cell_range(p, 2);
    Index earlier = kInvalidIndex;
    for (std::uint64_t cx = x[0]; cx <= x[2]; ++cx) {
      for (std::uint64_t cy = y[0]; cy <= y[2]; ++cy) {
        for (std::uint64_t cz = z[0]; cz <= z[2]; ++cz) {
          const auto found = cells.find(cx << 2 * kBits | cy << kBits | cz);
          if (found == cells.end()) {
            continue;
          }
          for (const Index other : found->second) {
            if ((points[other] - p).norm() <= distance &&
                (earlier == kInvalidIndex || other < earlier)) {
              earlier = other;
            }
          }
        }
      }
    }
    if (earlier != kInvalidIndex) {
      repeated.near.emplace_back(i, earlier);
    } else {
      cells[x[1] << 2 * kBits | y[1] << kBits | z[1]].push_back(i);
    }
  }
  return repeated;
}

}  // namespace pbdsurg
