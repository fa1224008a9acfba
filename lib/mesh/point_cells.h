// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Points in cubic cells, to find those near a place without looking at all.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Points sorted by the cubic cell they lie in.
class PointCells {
 public:
  PointCells() = default;

  /// @param points  [n] m; only read here
  /// @param chosen  ids of those to sort in
  /// @param size    m, positive: the edge of a cell
  /// @note Cost: O(m log m) for m chosen points.
  PointCells(std::span<const Eigen::Vector3d> points, std::span<const Index> chosen, double size)
      : size_(size) {
    sorted_.reserve(chosen.size());
    for (const Index id : chosen) {
      sorted_.push_back({cell_of(points[id]), id});
    }
    std::sort(sorted_.begin(), sorted_.end());
  }

  /// Calls visit(id) for every point within one cell's size of a place, and for some further away;
  /// always in the same order.
  template <class Visit>
  void visit_near(const Eigen::Vector3d& place, Visit visit) const {
    const Cell middle = cell_of(place);
    for (int dx = -1; dx <= 1; ++dx) {
      for (int dy = -1; dy <= 1; ++dy) {
        // the three cells along z are neighbours in the order too
        const Cell first{middle[0] + dx, middle[1] + dy, middle[2] - 1};
        const Cell last{middle[0] + dx, middle[1] + dy, middle[2] + 1};
        auto entry = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(first, Index{0}));
        for (; entry != sorted_.end() && entry->first <= last; ++entry) {
          visit(entry->second);
        }
      }
    }
  }

 private:
  using Cell = std::array<std::int64_t, 3>;

  [[nodiscard]] Cell cell_of(const Eigen::Vector3d& point) const {
    Cell cell;
    for (int axis = 0; axis < 3; ++axis) {
      // far beyond any organ, where a conversion would overflow, all cells are one
      const double index = std::clamp(std::floor(point[axis] / size_), -1e15, 1e15);
      cell[axis] = static_cast<std::int64_t>(index);
    }
    return cell;
  }

  double size_ = 1;
  std::vector<std::pair<Cell, Index>> sorted_;
};

}  // namespace pbdsurg
