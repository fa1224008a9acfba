// SPDX-License-Identifier: Apache-2.0
#include "solver/step_team.h"

namespace pbdsurg {
namespace {

// In pauses of some 20 to 50 ns each. Yielding costs more than a barrier takes when all are
// running; a sleeper takes tens of microseconds to wake.
constexpr int kSpinsBeforeYield = 64;
constexpr int kSpinsBeforeSleep = 1000;

void pause() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

StepTeam::StepTeam(int threads, ThreadWait wait)
    : wait_(wait), arrivals_(static_cast<std::size_t>(threads)) {
  // who shares a processor with those it waits for must leave it
  if (wait == ThreadWait::spin && threads > static_cast<int>(std::thread::hardware_concurrency())) {
    wait_ = ThreadWait::yield;
  }
  workers_.reserve(static_cast<std::size_t>(threads) - 1);
  try {
    for (int thread = 1; thread < threads; ++thread) {
      workers_.emplace_back([this, thread] { work(thread); });
    }
  } catch (...) {
    // no more threads, or no memory for them: fewer change nothing but the time
  }
}

StepTeam::~StepTeam() {
  stop_ = true;
  jobs_.fetch_add(1, std::memory_order_release);
  jobs_.notify_all();
}

void StepTeam::start(Call call, const void* object) {
  call_ = call;
  object_ = object;
  jobs_.fetch_add(1, std::memory_order_release);
  jobs_.notify_all();
  call(object, 0);
  barrier(0);
}

void StepTeam::work(int thread) {
  for (std::uint32_t done = 0;; ++done) {
    wait_while(jobs_, done, ThreadWait::block,
               wait_ == ThreadWait::block ? kSpinsBeforeYield : kSpinsBeforeSleep);
    if (stop_) {
      return;
    }
    call_(object_, thread);
    barrier(thread);
  }
}

void StepTeam::barrier(int thread) noexcept {
  std::atomic<std::uint32_t>& mine = arrivals_[thread].count;
  const std::uint32_t meeting = mine.load(std::memory_order_relaxed) + 1;
  mine.store(meeting, std::memory_order_release);
  if (wait_ == ThreadWait::block) {
    mine.notify_all();
  }
  for (int other = 0; other < size(); ++other) {
    // nobody is more than one meeting ahead or behind
    if (other != thread) {
      wait_while(arrivals_[other].count, meeting - 1, wait_, kSpinsBeforeYield);
    }
  }
}

void StepTeam::wait_while(const std::atomic<std::uint32_t>& value, std::uint32_t old,
                          ThreadWait how, int spins) const noexcept {
  for (int spin = 0; value.load(std::memory_order_acquire) == old; ++spin) {
    if (how == ThreadWait::spin || spin < spins) {
      pause();
    } else if (how == ThreadWait::yield) {
      std::this_thread::yield();
    } else {
      value.wait(old, std::memory_order_acquire);
    }
  }
}

}  // namespace pbdsurg
