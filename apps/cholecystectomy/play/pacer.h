// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Fixed steps of simulated time against a clock.

namespace cholecystectomy {

/// Says when steps are due. One that cannot keep up never owes more than kMostOwed: what goes
/// beyond is given up, so that time stretches where steps would pile up without end. Times are s.
class Pacer {
 public:
  static constexpr double kMostOwed = 0.05;  ///< s of the clock
  static constexpr double kWindow = 1;       ///< s of the clock, over which the factor is measured

  /// @param time_step  s of simulated time, positive
  Pacer(double time_step, double now) : time_step_(time_step), next_(now), window_start_(now) {}

  /// @param speed  of simulated time: 1 is real, 0 stands still. Takes effect from now on.
  void set_speed(double speed, double now);

  [[nodiscard]] bool is_due(double now) const { return speed_ > 0 && next_ <= now; }

  /// When the next step is due; meaningless while time stands still.
  [[nodiscard]] double next() const { return next_; }

  /// Call this after each step.
  void took_step(double now);

  /// Simulated time over the time asked for, in the last full window: 1 if all is in time. 1
  /// before.
  [[nodiscard]] double factor() const { return factor_; }

  /// s of the clock by which steps are late.
  [[nodiscard]] double owed(double now) const { return is_due(now) ? now - next_ : 0; }

 private:
  void begin_window(double now);

  double time_step_;
  double speed_ = 1;
  double next_;
  double window_start_;
  int window_steps_ = 0;
  double factor_ = 1;
};

}  // namespace cholecystectomy
