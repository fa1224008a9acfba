// SPDX-License-Identifier: Apache-2.0
#include "lib/base/step_team.h"

#include <chrono>

namespace pbdsurg {
namespace {

using Clock = std::chrono::steady_clock;

// In pauses of some 20 to 50 ns each. Yielding costs more than a barrier takes when all are
// running; a sleeper takes microseconds to tens of them to wake.
constexpr int kSpinsBeforeYield = 64;
// Who waits for longer lets others work: a thread's own part of a step, or another program. Jobs
// follow each other at longer intervals than meetings.
constexpr std::chrono::microseconds kLongestYield{50};
constexpr std::chrono::microseconds kLongestYieldForJob{200};

void pause() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

// Spins, then yields, until something is so or patience ends.
template <class Condition>
bool wait_until(const Condition& is_so, std::chrono::microseconds patience) noexcept {
  for (int spin = 0; spin < kSpinsBeforeYield; ++spin) {
    if (is_so()) {
      return true;
    }
    pause();
  }
  const Clock::time_point end = Clock::now() + patience;
  while (Clock::now() < end) {
    if (is_so()) {
      return true;
    }
    std::this_thread::yield();
  }
  return false;
}

}  // namespace

StepTeam::StepTeam(int threads) : seats_(static_cast<std::size_t>(threads)) {
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
    seats_[thread].jobs.fetch_add(1, std::memory_order_seq_cst);
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
    seat.jobs.fetch_add(1, std::memory_order_seq_cst);
    seat.jobs.notify_all();
  }
  call(object, 0);
  seats_[0].threads = threads;
  meet(0, kLongestYieldForJob);
}

void StepTeam::work(int thread) {
  Seat& seat = seats_[thread];
  for (std::uint32_t done = 0;; ++done) {
    wait_for_job(seat, done);
    if (stop_) {
      return;
    }
    seat.threads = threads_;
    call_(object_, thread);
    arrive(seat);  // thread 0 waits for all; nobody else has to
  }
}

bool StepTeam::barrier(int thread) noexcept {
  Seat& seat = seats_[thread];
  meet(thread, kLongestYield);
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
  if (is_alone()) {  // others may still have to see at which meeting they left
    return;
  }
  last_meeting_.store(seats_[0].meetings.load(std::memory_order_relaxed) + 1,
                      std::memory_order_relaxed);
}

std::uint32_t StepTeam::arrive(Seat& seat) noexcept {
  const std::uint32_t meeting = seat.meetings.load(std::memory_order_relaxed) + 1;
  // Either this sees who falls asleep, or who falls asleep sees this, as all is sequentially
  // consistent. Without a sleeper nobody is called: idle threads of the team would make that slow.
  seat.meetings.store(meeting, std::memory_order_seq_cst);
  if (seat.sleepers.load(std::memory_order_seq_cst) > 0) {
    seat.meetings.notify_all();
  }
  return meeting;
}

void StepTeam::meet(int thread, std::chrono::microseconds patience) noexcept {
  Seat& seat = seats_[thread];  // the next job may begin before the last of this one has left
  if (seat.threads == 1) {
    return;
  }
  const std::uint32_t meeting = arrive(seat);
  // Thread 0 first: once it has arrived, all seats have counts of this job.
  for (int other = 0; other < seat.threads; ++other) {
    if (other != thread) {
      wait_for(seats_[other], meeting, patience);
    }
  }
}

void StepTeam::wait_for_job(const Seat& seat, std::uint32_t done) noexcept {
  const auto is_given = [&] { return seat.jobs.load(std::memory_order_acquire) != done; };
  while (!wait_until(is_given, kLongestYieldForJob)) {
    seat.jobs.wait(done, std::memory_order_acquire);
  }
}

void StepTeam::wait_for(Seat& seat, std::uint32_t meeting,
                        std::chrono::microseconds patience) noexcept {
  const auto has_arrived = [meeting](std::uint32_t count) {
    return static_cast<std::int32_t>(count - meeting) >= 0;  // counts wrap around
  };
  if (wait_until([&] { return has_arrived(seat.meetings.load(std::memory_order_acquire)); },
                 patience)) {
    return;
  }
  seat.sleepers.fetch_add(1, std::memory_order_seq_cst);
  for (;;) {
    const std::uint32_t seen = seat.meetings.load(std::memory_order_seq_cst);
    if (has_arrived(seen)) {
      break;
    }
    seat.meetings.wait(seen, std::memory_order_seq_cst);
  }
  seat.sleepers.fetch_sub(1, std::memory_order_relaxed);
}

}  // namespace pbdsurg
