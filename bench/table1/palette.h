// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Many colours that are told apart as well as can be, on white.

#include <Eigen/Core>
#include <vector>

namespace pbdsurg::bench {

/// Each colour is the one of a grid that is farthest from white and from all before, so the first
/// few differ most. Distances are those of Oklab (Ottosson 2020), with lightness counting half,
/// because light and shade change it.
/// @return  [count] sRGB in [0, 1]
[[nodiscard]] std::vector<Eigen::Vector3f> distinct_colors(int count);

}  // namespace pbdsurg::bench
