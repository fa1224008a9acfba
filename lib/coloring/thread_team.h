// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Teams (team.h) of CPU threads.

#include <atomic>
#include <barrier>
#include <thread>
#include <type_traits>
#include <vector>

#include "pbdsurg/core/types.h"

#include "coloring/team.h"

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
  ThreadTeam(Index thread, Index thread_count, std::barrier<>& barrier)
      : thread_(thread), thread_count_(thread_count), barrier_(&barrier) {}

  [[nodiscard]] Index group() const noexcept { return thread_; }
  [[nodiscard]] Index group_count() const noexcept { return thread_count_; }
  [[nodiscard]] Index lane() const noexcept { return 0; }
  [[nodiscard]] Index lane_count() const noexcept { return 1; }
  [[nodiscard]] Index worker() const noexcept { return thread_; }
  [[nodiscard]] Index worker_count() const noexcept { return thread_count_; }
  void barrier() { barrier_->arrive_and_wait(); }

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
  Index thread_count_;
  std::barrier<>* barrier_;
};

/// Runs program(team) on `threads` threads, the caller's among them; on the caller's alone where
/// the system has no more, which changes nothing but the time.
/// @param threads  >= 1
template <class Program>
void run_team(int threads, const Program& program) {
  enum Signal { wait, run, give_up };
  if (threads > 1) {
    std::barrier<> barrier(threads);
    std::atomic<int> signal{wait};
    std::vector<std::jthread> workers;
    workers.reserve(static_cast<std::size_t>(threads) - 1);
    try {
      for (int thread = 1; thread < threads; ++thread) {
        workers.emplace_back([&program, &barrier, &signal, thread, threads] {
          signal.wait(wait);
          if (signal == run) {
            ThreadTeam team(thread, threads, barrier);
            program(team);
          }
        });
      }
      signal = run;
    } catch (...) {  // no more threads, or no memory for them
      signal = give_up;
    }
    signal.notify_all();
    if (signal == run) {
      ThreadTeam team(0, threads, barrier);
      program(team);
      return;
    }
  }
  SerialTeam team;
  program(team);
}

/// @return threads, at most eight a processor; for 0 one a processor
/// @throws InvalidArgument  if it is negative
[[nodiscard]] int resolve_threads(int threads);

}  // namespace pbdsurg
