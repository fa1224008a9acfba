// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How often pictures are drawn.

#include <algorithm>

namespace cholecystectomy {

/// Sheds pictures when steps are late, before time has to stretch: each picture at which they are
/// makes the pause to the next longer, each at which they are not a little shorter.
class PicturePace {
 public:
  static constexpr double kShortest = 1.0 / 60, kLongest = 0.2;  ///< s between pictures
  static constexpr double kLate = 0.015;  ///< s owed that count: more than one step

  /// @param owed  s by which steps are late @param now  s of the clock
  void drew(double owed, double now) {
    interval_ = std::clamp(interval_ * (owed > kLate ? 1.25 : 0.95), kShortest, kLongest);
    next_ = now + interval_ - kShortest;
  }
  [[nodiscard]] bool is_due(double now) const { return now >= next_; }
  [[nodiscard]] double next() const { return next_; }

 private:
  double interval_ = kShortest;
  double next_ = 0;
};

}  // namespace cholecystectomy
