// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many threads a step takes: as many as are measured to pay.

#include <array>
#include <limits>

namespace pbdsurg {

/// Chooses between 1, 2, 4 and so on up to all threads by the times that steps took. Threads that
/// meet often are slow as soon as one of them shares its processor with another program, and where
/// there is too little work. So it begins with one, tries half and double now and then, seldom
/// where that kept failing, and goes back to one where steps keep being much slower.
class ThreadChoice {
 public:
  /// @param most  >= 1
  explicit ThreadChoice(int most);

  /// For the next step.
  [[nodiscard]] int threads() const noexcept { return threads_of(is_trying_ ? tried_ : chosen_); }

  /// s from which threads of the next step had better leave the rest to one of them; infinite
  /// before anything is known.
  [[nodiscard]] double limit() const noexcept {
    return usual_ > 0 ? kMuchSlower * usual_ : std::numeric_limits<double>::infinity();
  }

  /// @param seconds  of a step on threads(); the first step, which is cold, does not count
  void took(double seconds) noexcept;

 private:
  static constexpr int kLevels = 32;          // of powers of two
  static constexpr double kMuchSlower = 2.0;  // times the usual

  [[nodiscard]] int threads_of(int level) const noexcept;
  [[nodiscard]] bool has_come(int level) const noexcept;
  void begin_trial(int level) noexcept;
  void try_on(double seconds) noexcept;
  void end_trial(bool is_better) noexcept;

  int most_;
  int last_level_ = 0;
  bool has_begun_ = false;
  int chosen_ = 0;    // a level: 2^level threads, or most_
  double usual_ = 0;  // s, a running mean at the chosen level without what is slow; 0: none yet
  double mean_ = 0;   // s, the same with it, but for how very slow it is
  int slowness_ = 0;  // rises with slow steps, falls with others
  std::array<int, kLevels> patience_{};  // [level] steps before it is tried
  std::array<int, kLevels> waited_{};    // [level] steps since it was
  bool is_trying_ = false;
  int tried_ = 0;
  int trial_steps_ = 0;
  double trial_time_ = 0;  // s, sum
};

}  // namespace pbdsurg
