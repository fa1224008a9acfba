// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Time that loops run by: the real one, or one that a test moves.

#include <chrono>
#include <string>
#include <thread>

#include "pbdsurg/base/error.h"

namespace pbdsurg {

/// Seconds since some moment that stays the same. Never goes back.
class Clock {
 public:
  Clock() = default;
  Clock(const Clock&) = delete;             ///< loops keep references
  Clock& operator=(const Clock&) = delete;  ///< likewise
  virtual ~Clock() = default;

  /// s
  [[nodiscard]] virtual double now() const noexcept = 0;

  /// Returns at a time or later; at once if it has passed.
  /// @param time  s, as now()
  virtual void wait_until(double time) = 0;
};

/// The system's steady clock, from the construction on. Threads may share one.
class RealClock final : public Clock {
 public:
  [[nodiscard]] double now() const noexcept override {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }
  void wait_until(double time) override {
    std::this_thread::sleep_until(
        start_ + std::chrono::duration_cast<Ticks>(std::chrono::duration<double>(time)));
  }

 private:
  using Ticks = std::chrono::steady_clock::duration;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Stands still until someone waits or advances it: loops on it run as fast as they can, and the
/// same every time. Of one thread.
class VirtualClock final : public Clock {
 public:
  [[nodiscard]] double now() const noexcept override { return now_; }
  void wait_until(double time) override { now_ = time > now_ ? time : now_; }

  /// @param seconds  not negative
  /// @throws InvalidArgument  if it is negative or not a number
  void advance(double seconds) {
    if (!(seconds >= 0)) {
      throw InvalidArgument("a clock cannot advance by " + std::to_string(seconds) +
                            " s; it never goes back");
    }
    now_ += seconds;
  }

 private:
  double now_ = 0;
};

}  // namespace pbdsurg
