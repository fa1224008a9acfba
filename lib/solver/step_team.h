// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Threads that live as long as a solver and meet thousands of times a step.

#include <atomic>
#include <cstdint>
#include <thread>
#include <vector>

#include "pbdsurg/core/thread_wait.h"

namespace pbdsurg {

/// The caller of run() is thread 0 of the team.
class StepTeam {
 public:
  /// Starts threads - 1 threads, or as many as the system has.
  StepTeam(int threads, ThreadWait wait);
  ~StepTeam();
  StepTeam(const StepTeam&) = delete;
  StepTeam& operator=(const StepTeam&) = delete;

  [[nodiscard]] int size() const noexcept { return static_cast<int>(workers_.size()) + 1; }

  /// Calls job(thread) on every thread of the team; returns when all have returned.
  template <class Job>
  void run(const Job& job) {
    start([](const void* object, int thread) { (*static_cast<const Job*>(object))(thread); }, &job);
  }

  /// All threads of a running job meet: what was written before is seen after.
  void barrier(int thread) noexcept;

 private:
  using Call = void (*)(const void* object, int thread);

  // One line of cache for each thread, so that arriving costs the others one transfer.
  struct alignas(128) Arrival {
    std::atomic<std::uint32_t> count{0};
  };

  void start(Call call, const void* object);
  void work(int thread);
  void wait_while(const std::atomic<std::uint32_t>& value, std::uint32_t old, ThreadWait how,
                  int spins) const noexcept;

  ThreadWait wait_;
  std::vector<Arrival> arrivals_;  // [size()]
  std::atomic<std::uint32_t> jobs_{0};
  Call call_ = nullptr;
  const void* object_ = nullptr;
  bool stop_ = false;
  std::vector<std::jthread> workers_;
};

}  // namespace pbdsurg
