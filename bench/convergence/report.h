// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What comes out of the comparison.

#include <string>
#include <vector>

#include "bench/convergence/measure.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {

/// What was measured with steps of one length; sweeps come first.
struct Comparison {
  float dt;  ///< s
  std::vector<StepCurve> steps;
  std::vector<RestCurve> rests;
};

/// How many sweeps leave the residual that others are timed to.
inline constexpr int kReferenceSweeps = 30;

/// A row for each setting of each method.
[[nodiscard]] Json to_json(const std::vector<Comparison>& comparisons);

/// The points of all curves, one a row; `best` as in to_json(), null for curves of one step.
[[nodiscard]] Json points_of(const std::vector<Comparison>& comparisons);

/// A table for each length of a step, after one line for each note.
[[nodiscard]] std::string to_markdown(const Json& rows, const std::vector<std::string>& notes);

}  // namespace pbdsurg::bench
