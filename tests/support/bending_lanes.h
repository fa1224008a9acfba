// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The bending constraint on registers of lanes, with either way of rounding.

#include <array>

#include "pbdsurg/constraints/bending.h"

namespace pbdsurg::testing {

/// One hinge and what its projection is given.
struct HingeSample {
  std::array<Vec3<float>, 4> x;  ///< m
  std::array<float, 4> w;        ///< 1/kg
  std::array<float, BendingConstraint::kParameterCount> parameters;
  float multiplier;  ///< kg m^2
};

inline constexpr int kHingeLanes = 4;
using HingeSamples = std::array<HingeSample, kHingeLanes>;

/// One damped projection in compliance mode, dt 1 ms, in which all vertices stood at `start`.
void project_lanes_strict(HingeSamples& samples, const HingeSamples& start);
void project_lanes_fast(HingeSamples& samples, const HingeSamples& start);

}  // namespace pbdsurg::testing
