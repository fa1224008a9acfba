// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// When a team of threads is worth waking.

#include <cstdint>

#include "solver/step_team.h"

namespace pbdsurg {

/// Visits to rows or tetrahedra, of some 20 ns each, from which threads share a piece of work. What
/// is less takes no longer alone than a sleeping thread may take to wake (tens of microseconds).
inline constexpr std::int64_t kVisitsWorthThreads = 20000;

/// Calls job(thread, thread_count) on every thread of a team where that pays, else on the caller's.
/// @param team    may be null
/// @param visits  that all of the work makes
template <class Job>
void share_work(StepTeam* team, std::int64_t visits, const Job& job) {
  if (team == nullptr || team->size() == 1 || visits < kVisitsWorthThreads) {
    job(0, 1);
  } else {
    team->run([&](int thread) { job(thread, team->size()); });
  }
}

}  // namespace pbdsurg
