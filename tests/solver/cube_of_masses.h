// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A cube of eight masses, for tests of balances.

namespace pbdsurg::testing {

inline constexpr double kCubeMass = 0.008;     // kg
inline constexpr double kHalfCubeEdge = 0.01;  // m

}  // namespace pbdsurg::testing
