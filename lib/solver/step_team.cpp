// SPDX-License-Identifier: Apache-2.0
#include "solver/step_team.h"

#include "core/processors.h"

namespace pbdsurg {
namespace {

// In pauses of some 20 to 50 ns each. Yielding costs more than a barrier takes when all are
// running; a sleeper takes tens of microseconds to wake.
constexpr int kSpinsBeforeYield = 64;
constexpr int kSpinsBeforeSleep = 1000;
// Who waits longer than this waits for a thread that another program keeps from its processor.
constexpr int kMostSpins = 20'000;
constexpr int kMostYields = 32;

void pause() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace

StepTeam::StepTeam(int threads, ThreadWait wait)
    : wait_(wait), seats_(static_cast<std::size_t>(threads)) {
  // who shares a processor with those it waits for must leave it
  if (wait == ThreadWait::spin && threads > processor_count()) {
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
  for (int thread = 1; thread < size(); ++thread) {
    seats_[thread].jobs.fetch_add(1, std::memory_order_release);
    seats_[thread].jobs.notify_all();
  }
}

void StepTeam::start(Call call, const void* object, int threads) {
  call_ = call;
  object_ = object;
  threads_ = threads;
  seats_[0].threads = threads;
  const std::uint32_t meeting = seats_[0].meetings.load(std::memory_order_relaxed);
  last_meeting_.store(meeting, std::memory_order_relaxed);  // which is over
  for (int thread = 1; thread < threads; ++thread) {
    Seat& seat = seats_[thread];
    seat.meetings.store(meeting, std::memory_order_relaxed);  // it may have missed some jobs
    seat.jobs.fetch_add(1, std::memory_order_release);
    seat.jobs.notify_all();
  }
  call(object, 0);
  seats_[0].threads = threads;
  meet(0);
}

void StepTeam::work(int thread) {
  Seat& seat = seats_[thread];
  for (std::uint32_t done = 0;; ++done) {
    wait_until(
        seat.jobs, [done](std::uint32_t jobs) { return jobs != done; }, ThreadWait::block,
        wait_ == ThreadWait::block ? kSpinsBeforeYield : kSpinsBeforeSleep);
    if (stop_) {
      return;
    }
    seat.threads = threads_;
    call_(object_, thread);
    meet(thread);
  }
}

bool StepTeam::barrier(int thread) noexcept {
  Seat& seat = seats_[thread];
  meet(thread);
  if (seat.threads > 1 && last_meeting_.load(std::memory_order_relaxed) ==
                              seat.meetings.load(std::memory_order_relaxed)) {
    if (thread > 0) {
      return false;
    }
    seat.threads = 1;
  }
  return true;
}

void StepTeam::dissolve() noexcept {
  last_meeting_.store(seats_[0].meetings.load(std::memory_order_relaxed) + 1,
                      std::memory_order_relaxed);
}

void StepTeam::meet(int thread) noexcept {
  Seat& seat = seats_[thread];  // the next job may begin before the last of this one has left
  if (seat.threads == 1) {
    return;
  }
  std::atomic<std::uint32_t>& mine = seat.meetings;
  const std::uint32_t meeting = mine.load(std::memory_order_relaxed) + 1;
  mine.store(meeting, std::memory_order_release);
  mine.notify_all();
  for (int other = 0; other < seat.threads; ++other) {
    // the counts wrap around
    const auto has_arrived = [meeting](std::uint32_t count) {
      return static_cast<std::int32_t>(count - meeting) >= 0;
    };
    if (other != thread) {
      wait_until(seats_[other].meetings, has_arrived, wait_, kSpinsBeforeYield);
    }
  }
}

template <class IsOver>
void StepTeam::wait_until(const std::atomic<std::uint32_t>& value, IsOver is_over, ThreadWait how,
                          int spins) const noexcept {
  for (int spin = 0;; ++spin) {
    const std::uint32_t seen = value.load(std::memory_order_acquire);
    if (is_over(seen)) {
      return;
    }
    if (spin < spins || (how == ThreadWait::spin && spin < kMostSpins)) {
      pause();
    } else if (how == ThreadWait::yield && spin < spins + kMostYields) {
      std::this_thread::yield();
    } else {
      value.wait(seen, std::memory_order_acquire);
    }
  }
}

}  // namespace pbdsurg
