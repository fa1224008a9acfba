// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How often pictures are drawn.

#include <algorithm>

namespace cholecystectomy {

/// Sheds pictures when steps are late, before time has to stretch: each picture at which they are
/// makes the way to the next longer, each at which they are not a little shorter.
class PicturePace {
 public:
  static constexpr double kShortest = 0.01, kLongest = 0.2;  ///< s from one picture to the next
  static constexpr double kLate = 0.015;  ///< s owed that count: more than one step

  /// @param owed   s by which steps are late
  /// @param start  s of the clock, when the picture was begun
  void drew(double owed, double start) {
    interval_ = std::clamp(interval_ * (owed > kLate ? 1.25 : 0.95), kShortest, kLongest);
    next_ = start + interval_;
  }
  [[nodiscard]] bool is_due(double now) const { return now >= next_; }
  [[nodiscard]] double next() const { return next_; }

 private:
  double interval_ = kShortest;
  double next_ = 0;
};

}  // namespace cholecystectomy
