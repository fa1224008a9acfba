// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Threads that live as long as an executor and meet thousands of times a step.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>
#include <vector>

namespace pbdsurg {

/// The caller of run() is thread 0 of the team.
class StepTeam {
 public:
  /// Starts threads - 1 threads, or as many as the system has.
  explicit StepTeam(int threads);
  ~StepTeam();
  StepTeam(const StepTeam&) = delete;
  StepTeam& operator=(const StepTeam&) = delete;

  [[nodiscard]] int size() const noexcept { return static_cast<int>(workers_.size()) + 1; }

  /// Calls job(thread) on the first threads of the team; returns when all have returned. The others
  /// sleep on.
  /// @param threads  1 to size()
  /// @param job      does not throw
  template <class Job>
  void run(int threads, const Job& job) {
    start([](const void* object, int thread) { (*static_cast<const Job*>(object))(thread); }, &job,
          threads);
  }

  /// The same on every thread.
  template <class Job>
  void run(const Job& job) {
    run(size(), job);
  }

  /// The threads of a running job meet: what was written before is seen after.
  /// @return  whether this thread goes on: else thread 0 does the rest of the job alone
  bool barrier(int thread) noexcept;

  /// By thread 0, in a job: from the next meeting on it is alone, and passes all others at once.
  void dissolve() noexcept;

  /// By thread 0: whether it is alone.
  [[nodiscard]] bool is_alone() const noexcept { return seats_[0].threads == 1; }

 private:
  using Call = void (*)(const void* object, int thread);

  // Lines of cache of each thread, so that arriving costs the others one transfer.
  struct Seat {
    alignas(128) std::atomic<std::uint32_t> meetings{0};  // at which it has arrived
    std::atomic<int> sleepers{0};                         // who wait for that asleep
    alignas(128) std::atomic<std::uint32_t> jobs{0};      // that it was given
    int threads = 1;                                      // that it meets in its job
  };

  void start(Call call, const void* object, int threads);
  void work(int thread);
  std::uint32_t arrive(Seat& seat) noexcept;
  void meet(int thread, std::chrono::microseconds patience) noexcept;
  static void wait_for_job(const Seat& seat, std::uint32_t done) noexcept;
  static void wait_for(Seat& seat, std::uint32_t meeting,
                       std::chrono::microseconds patience) noexcept;

  std::vector<Seat> seats_;  // [at least size()]
  Call call_ = nullptr;
  const void* object_ = nullptr;
  int threads_ = 1;                             // of the last job
  std::atomic<std::uint32_t> last_meeting_{0};  // of a job that was dissolved
  bool stop_ = false;
  std::vector<std::jthread> workers_;
};

}  // namespace pbdsurg
