// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Scenes that come to rest, each with one number that says how stiff the tissue was.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::bench {

/// Vertices that a tool takes along.
struct Pull {
  std::vector<Index> vertices;
  Eigen::Vector3d way;  ///< m
};

/// Vertices that turn about the x axis, by a tool each, as a tool's force tells of no moment.
struct Twist {
  std::vector<Index> vertices;
  double angle;            ///< rad
  Eigen::Vector3d center;  ///< m
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
  double drag = 0;  ///< 1/s, near critical: what rests does not feel it
  std::vector<double> steps_ms{0.2, 1, 5, 16};
  std::vector<Index> tip;  ///< whose mean sag is measured where there is no tool
  std::optional<Pull> pull;
  std::optional<Twist> twist;
  std::optional<Ball> ball;
  std::optional<double> closed_form;  ///< of the body that the mesh stands for, in unit()

  [[nodiscard]] const char* unit() const noexcept {
    return twist ? "mN mm" : pull || ball ? "N" : "mm";
  }
};

/// @param quick  three small ones
[[nodiscard]] std::vector<Case> make_cases(bool quick);

}  // namespace pbdsurg::bench
