// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How far a solver is from a static solution.

#include <algorithm>
#include <vector>

#include "bench/support/static_energy.h"

namespace pbdsurg::testing {

/// m, of a vertex where a solver has it from where a static solution does.
inline double largest_distance(const bench::Positions& a, const std::vector<Eigen::Vector3f>& b) {
  double largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    largest = std::max(largest, (a[v] - b[v].cast<double>()).norm());
  }
  return largest;
}

}  // namespace pbdsurg::testing
