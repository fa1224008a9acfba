// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How fast methods solve one step, and how fast their steps bring a block to rest.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bench/convergence/cantilever.h"

namespace pbdsurg::bench {

/// Something that steps the block.
class Stepper {
 public:
  virtual ~Stepper() = default;
  virtual void write_positions(const std::vector<Eigen::Vector3f>& positions) = 0;
  virtual void step(float dt) = 0;
  [[nodiscard]] virtual std::vector<Eigen::Vector3f> positions() const = 0;
};

struct Setting {
  int substeps;
  int iterations;  ///< of each
};

struct Method {
  std::string name;
  int threads;
  std::vector<Setting> settings;  ///< to bring the block to rest with
  bool is_by_substeps;            ///< more sweeps in a step are more substeps
  std::function<std::unique_ptr<Stepper>(const Setting&)> make;
};

/// How a method takes so many sweeps in one step.
[[nodiscard]] Setting with_sweeps(const Method& method, int sweeps);

/// What is common to all methods.
struct Problem {
  const Cantilever& bar;
  std::vector<Eigen::Vector3d> equilibrium;  ///< [vertex_count] m
  double damping;                            ///< 1/s, drag: see SolverOptions::damping
  float dt;                                  ///< s, of a step
  int steps;                                 ///< from rest shape to rest
  int repetitions;  ///< times are medians over these, in which methods take turns
};

/// One step from a stretch of 10 % along x, with more and more sweeps.
struct StepCurve {
  struct Point {
    int sweeps;
    double ms;
    double residual;  ///< of the last substep: what it leaves of implicit Euler's equation, over
                      ///< the weight
  };
  const Method* method;
  std::vector<Point> points;
};
[[nodiscard]] std::vector<StepCurve> measure_step(const Problem& problem,
                                                  const std::vector<Method>& methods,
                                                  const std::vector<int>& sweeps);

/// Steps from rest shape on.
struct RestCurve {
  struct Point {
    double time_s;     ///< simulated
    double ms;         ///< of compute, since the start
    double residual;   ///< sum of the magnitudes of the forces over the weight: one at rest shape
    double tip_error;  ///< of the free side's displacement, relative to that at equilibrium
  };
  const Method* method;
  Setting setting;
  std::vector<Point> points;  ///< [step]
  bool is_best = true;        ///< of the method's settings: first at the tolerance
};
inline constexpr double kTipTolerance = 0.01;

/// A curve for each setting of each method.
/// @throws Error  if a repetition ends otherwise than the first
[[nodiscard]] std::vector<RestCurve> measure_rest(const Problem& problem,
                                                  const std::vector<Method>& methods);

/// Compute after which a curve stays at or below a limit, ms; nothing if it never does.
template <class Curve>
[[nodiscard]] std::optional<double> ms_until(const Curve& curve, double Curve::Point::*value,
                                             double limit) {
  std::optional<double> ms;
  for (const auto& point : curve.points) {
    if (!(point.*value <= limit)) {
      ms.reset();
    } else if (!ms) {
      ms = point.ms;
    }
  }
  return ms;
}

}  // namespace pbdsurg::bench
