// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Points that lie at or near the place of others.

#include <Eigen/Core>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

struct RepeatedPoints {
  std::vector<std::pair<Index, Index>> exact;  ///< (point, earlier point at the same place)
  std::vector<std::pair<Index, Index>> near;   ///< (point, earlier point within the distance)
};

/// Compares the points named by `ids`, which are finite. Clusters are told from their first member.
/// Cost: O(n log n).
[[nodiscard]] RepeatedPoints find_repeated_points(std::span<const Eigen::Vector3d> points,
                                                  std::span<const Index> ids, double distance);

}  // namespace pbdsurg
