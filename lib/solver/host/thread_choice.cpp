// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/host/thread_choice.h"

#include <algorithm>
#include <utility>

namespace pbdsurg {
namespace {

constexpr int kFirstPatience = 8;    // steps
constexpr int kMostPatience = 1024;  // steps: two bad ones in so many show in no percentile
constexpr int kGrowth = 4;           // of patience
constexpr int kTrialSteps = 8;       // some slices of a processor that others share
constexpr double kGain = 0.95;       // of the time, for which more threads are taken
constexpr double kMemory = 1.0 / 8;  // of the running means
// One slow step may have its own reason; two in a row, or every other one for a while, have one.
constexpr int kSlowStep = 2;
constexpr int kTooSlow = 4;

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

bool ThreadChoice::has_come(int level) const noexcept {
  return level >= 0 && level <= last_level_ && waited_[level] >= patience_[level];
}

void ThreadChoice::begin_trial(int level) noexcept {
  is_trying_ = true;
  tried_ = level;
  slowness_ = 0;
  trial_steps_ = 0;
  trial_time_ = 0;
}

void ThreadChoice::try_on(double seconds) noexcept {
  if (seconds > limit()) {
    slowness_ += kSlowStep;
    if (slowness_ >= kTooSlow) {
      end_trial(false);
    }
    return;
  }
  ++trial_steps_;
  trial_time_ += seconds;
  if (trial_time_ > kTrialSteps * mean_ * (tried_ > chosen_ ? kGain : 1.0)) {
    end_trial(false);
  } else if (trial_steps_ == kTrialSteps) {
    end_trial(true);
  }
}

void ThreadChoice::end_trial(bool is_better) noexcept {
  is_trying_ = false;
  slowness_ = 0;
  waited_[tried_] = 0;
  const auto grow = [](int& patience) { patience = std::min(kGrowth * patience, kMostPatience); };
  if (!is_better) {
    grow(patience_[tried_]);
    return;
  }
  grow(patience_[chosen_]);
  patience_[tried_] = kFirstPatience;
  waited_.fill(0);
  chosen_ = tried_;
  usual_ = mean_ = trial_time_ / trial_steps_;
}

void ThreadChoice::took(double seconds) noexcept {
  if (last_level_ == 0 || !std::exchange(has_begun_, true)) {
    return;
  }
  if (is_trying_) {
    try_on(seconds);
    return;
  }
  if (usual_ == 0) {
    usual_ = mean_ = seconds;
  }
  const bool is_slow = seconds > limit();
  slowness_ = is_slow ? slowness_ + kSlowStep : std::max(0, slowness_ - 1);
  mean_ += kMemory * (std::min(seconds, 2 * limit()) - mean_);
  if (!is_slow) {
    usual_ += kMemory * (seconds - usual_);
  }
  if (slowness_ >= kTooSlow) {  // which is the usual now
    usual_ = mean_ = std::max(mean_, std::min(seconds, 2 * limit()));
    slowness_ = 0;
    if (chosen_ > 0) {
      begin_trial(0);
    }
    return;
  }
  const int more = chosen_ + 1, fewer = chosen_ - 1;
  for (const int level : {more, fewer}) {
    if (level >= 0 && level <= last_level_) {
      ++waited_[level];
    }
  }
  if (has_come(more) && !(has_come(fewer) && waited_[fewer] > waited_[more])) {
    begin_trial(more);
  } else if (has_come(fewer)) {
    begin_trial(fewer);
  }
}

}  // namespace pbdsurg
