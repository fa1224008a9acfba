// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// When a team of threads is worth waking.

#include <cstdint>

#include "lib/base/executor_state.h"
#include "lib/base/step_team.h"

namespace pbdsurg {

/// Visits to rows or tetrahedra, of some 20 ns each, from which threads share a piece of work. What
/// is less takes no longer alone than a sleeping thread may take to wake (tens of microseconds).
inline constexpr std::int64_t kVisitsWorthThreads = 20000;

/// Whose part of a shared piece of work it is.
struct Worker {
  StepTeam* team;  // null: alone
  int thread;
  int count;

  void barrier() const noexcept {
    if (team != nullptr) {
      team->barrier(thread);
    }
  }
};

/// Calls job(worker) on every thread of an executor where that pays, else on the caller's.
/// @param visits  that all of the work makes
template <class Job>
void share_work(const Executor& executor, std::int64_t visits, const Job& job) {
  ExecutorState* const state = executor.state();
  const bool is_worth = state != nullptr && visits >= kVisitsWorthThreads;
  const TeamLease lease(state, is_worth ? state->threads() : 1);
  if (StepTeam* const team = lease.team()) {
    team->run([&](int thread) { job(Worker{team, thread, team->size()}); });
  } else {
    job(Worker{nullptr, 0, 1});
  }
}

}  // namespace pbdsurg
