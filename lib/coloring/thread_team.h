// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Teams (team.h) of CPU threads.

#include <atomic>
#include <type_traits>

#include "pbdsurg/base/types.h"

#include "lib/base/executor_state.h"
#include "lib/base/step_team.h"
#include "lib/coloring/team.h"

namespace pbdsurg {

/// One thread: no atomics, no barriers.
class SerialTeam {
 public:
  [[nodiscard]] Index group() const noexcept { return 0; }
  [[nodiscard]] Index group_count() const noexcept { return 1; }
  [[nodiscard]] Index lane() const noexcept { return 0; }
  [[nodiscard]] Index lane_count() const noexcept { return 1; }
  [[nodiscard]] Index worker() const noexcept { return 0; }
  [[nodiscard]] Index worker_count() const noexcept { return 1; }
  void barrier() noexcept {}

  template <class F>
  SplitCounts split(Index count, F f, Index* one, Index* two = nullptr) {
    SplitCounts counts{0, 0};
    for (Index i = 0; i < count; ++i) {
      const Sorted sorted = f(i);
      if (sorted.place == Place::one) {
        one[counts.one++] = sorted.index;
      } else if (sorted.place == Place::two) {
        two[counts.two++] = sorted.index;
      }
    }
    return counts;
  }

  static void raise(Index& flag) noexcept { flag = 1; }

  template <class T>
  static T peek(const T& value) noexcept {
    return value;
  }

  template <class T>
  static T fetch_max(T& target, std::type_identity_t<T> value) noexcept {
    const T old = target;
    target = old < value ? value : old;
    return old;
  }
  template <class T>
  static T fetch_or(T& target, std::type_identity_t<T> value) noexcept {
    const T old = target;
    target = old | value;
    return old;
  }
  template <class T>
  static T fetch_and(T& target, std::type_identity_t<T> value) noexcept {
    const T old = target;
    target = old & value;
    return old;
  }
  template <class T>
  static T fetch_add(T& target, std::type_identity_t<T> value) noexcept {
    const T old = target;
    target = static_cast<T>(old + value);
    return old;
  }
};

/// One of several threads. A group is one thread.
class ThreadTeam {
 public:
  ThreadTeam(Index thread, StepTeam& team) : thread_(thread), team_(&team) {}

  [[nodiscard]] Index group() const noexcept { return thread_; }
  [[nodiscard]] Index group_count() const noexcept { return team_->size(); }
  [[nodiscard]] Index lane() const noexcept { return 0; }
  [[nodiscard]] Index lane_count() const noexcept { return 1; }
  [[nodiscard]] Index worker() const noexcept { return thread_; }
  [[nodiscard]] Index worker_count() const noexcept { return team_->size(); }
  void barrier() noexcept { team_->barrier(thread_); }

  template <class F>
  SplitCounts split(Index count, F f, Index* one, Index* two = nullptr) {
    return SerialTeam().split(count, f, one, two);
  }

  static void raise(Index& flag) noexcept {
    std::atomic_ref<Index>(flag).store(1, std::memory_order_relaxed);
  }

  template <class T>
  static T peek(T& value) noexcept {
    return std::atomic_ref<T>(value).load(std::memory_order_relaxed);
  }

  template <class T>
  static T fetch_max(T& target, std::type_identity_t<T> value) noexcept {
    std::atomic_ref<T> shared(target);
    T old = shared.load(std::memory_order_relaxed);
    while (old < value && !shared.compare_exchange_weak(old, value, std::memory_order_relaxed)) {
    }
    return old;
  }
  template <class T>
  static T fetch_or(T& target, std::type_identity_t<T> value) noexcept {
    return std::atomic_ref<T>(target).fetch_or(value, std::memory_order_relaxed);
  }
  template <class T>
  static T fetch_and(T& target, std::type_identity_t<T> value) noexcept {
    return std::atomic_ref<T>(target).fetch_and(value, std::memory_order_relaxed);
  }
  template <class T>
  static T fetch_add(T& target, std::type_identity_t<T> value) noexcept {
    return std::atomic_ref<T>(target).fetch_add(value, std::memory_order_relaxed);
  }

 private:
  Index thread_;
  StepTeam* team_;
};

/// Runs program(team) on the threads of an executor that names how many, else on the caller's
/// alone.
template <class Program>
void run_team(const Executor& executor, const Program& program) {
  ExecutorState* const state = executor.state();
  const TeamLease lease(state, state != nullptr ? state->threads() : 1);
  if (StepTeam* const threads = lease.team()) {
    threads->run([&](int thread) {
      ThreadTeam team(thread, *threads);
      program(team);
    });
  } else {
    SerialTeam team;
    program(team);
  }
}

}  // namespace pbdsurg
