// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes that come to rest, each with one number that says how stiff the tissue was.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/scene.h"

#include "bench/support/static_energy.h"

namespace pbdsurg::bench {

/// Vertices that a tool takes along.
struct Pull {
  std::vector<Index> vertices;
  Eigen::Vector3d way;  ///< m
};

/// A ball that a tool presses into tissue.
struct Ball {
  double radius;          ///< m
  Eigen::Vector3d start;  ///< m, its center
  Eigen::Vector3d way;    ///< m
};

struct Case {
  std::string name;
  Scene scene;
  std::vector<double> steps_ms;
  double drag;             ///< 1/s, near critical: what rests does not feel it
  std::vector<Index> tip;  ///< whose mean sag is measured where there is no tool
  std::optional<Pull> pull;
  std::optional<Ball> ball;

  [[nodiscard]] bool is_force() const noexcept { return pull || ball; }
  [[nodiscard]] const char* unit() const noexcept { return is_force() ? "N" : "mm"; }
};

/// @param quick  the first alone, small
[[nodiscard]] std::vector<Case> make_cases(bool quick);

/// What the number is in the static solution: a sag in mm, or the force on a tool along its way in
/// N.
[[nodiscard]] double expected_value(const Case& each);

/// What a solver comes to.
struct Outcome {
  double value;
  double change;  ///< of it from the ninth tenth of the time to the last, as a share
};
[[nodiscard]] Outcome measure(const Case& each, SolverOptions options, double dt, double seconds);

}  // namespace pbdsurg::bench
