// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tests of worlds with sheets have in common.

namespace pbdsurg::testing {

inline constexpr float kSheetThickness = 0.5e-3F;  // m
inline constexpr double kSheetDt = 5e-3;           // s

}  // namespace pbdsurg::testing
