// SPDX-License-Identifier: Apache-2.0
#include "solver/thread_choice.h"

#include <algorithm>

namespace pbdsurg {
namespace {

constexpr int kFirstPatience = 8;    // steps
constexpr int kMostPatience = 1024;  // steps: one bad step in so many shows in no percentile
constexpr int kGrowth = 4;           // of patience
constexpr int kTrialSteps = 8;       // some slices of a processor that others share
constexpr double kGain = 0.95;       // of the time, for which more threads are taken
constexpr int kSlowSteps = 2;        // one may have its own reason
constexpr double kMemory = 1.0 / 8;  // of the running mean

}  // namespace

ThreadChoice::ThreadChoice(int most) : most_(most) {
  while (threads_of(last_level_) < most_) {
    ++last_level_;
  }
  patience_.fill(kFirstPatience);
}

int ThreadChoice::threads_of(int level) const noexcept {
  return level >= kLevels - 2 ? most_ : std::min(most_, 1 << level);
}

void ThreadChoice::begin_trial(int level) noexcept {
  is_trying_ = true;
  tried_ = level;
  trial_steps_ = 0;
  trial_time_ = 0;
}

void ThreadChoice::end_trial(bool is_better) noexcept {
  is_trying_ = false;
  steps_ = 0;
  slow_steps_ = 0;
  int& patience = patience_[tried_];
  if (is_better) {
    patience_[chosen_] = std::min(kGrowth * patience_[chosen_], kMostPatience);
    patience = kFirstPatience;
    chosen_ = tried_;
    usual_ = trial_time_ / trial_steps_;
  } else {
    patience = std::min(kGrowth * patience, kMostPatience);
  }
}

void ThreadChoice::took(double seconds) noexcept {
  if (last_level_ == 0) {
    return;
  }
  if (is_trying_) {
    ++trial_steps_;
    trial_time_ += seconds;
    const double enough = kTrialSteps * usual_ * (tried_ > chosen_ ? kGain : 1.0);
    if (trial_time_ > enough || seconds > limit()) {
      end_trial(false);
    } else if (trial_steps_ == kTrialSteps) {
      end_trial(true);
    }
    return;
  }
  slow_steps_ = seconds > limit() ? slow_steps_ + 1 : 0;
  usual_ = usual_ > 0 ? usual_ + kMemory * (seconds - usual_) : seconds;
  ++steps_;
  if (chosen_ > 0 && slow_steps_ >= kSlowSteps) {
    begin_trial(0);
    return;
  }
  for (const int level : {chosen_ + 1, chosen_ - 1}) {
    if (level >= 0 && level <= last_level_ && steps_ >= patience_[level]) {
      begin_trial(level);
      return;
    }
  }
}

}  // namespace pbdsurg
