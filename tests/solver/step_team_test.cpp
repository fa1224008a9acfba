// SPDX-License-Identifier: Apache-2.0
#include "solver/step_team.h"

#include <numeric>
#include <vector>

#include "support/catch.h"

namespace pbdsurg {

// Would catch a barrier that lets a thread pass early: then a sum misses what another adds.
TEST_CASE("step team: after a barrier everybody sees what everybody wrote", "[unit]") {
  const auto wait = GENERATE(ThreadWait::spin, ThreadWait::yield, ThreadWait::block);
  const int threads = GENERATE(1, 2, 3, 7);
  StepTeam team(threads, wait);
  REQUIRE(team.size() == threads);
  std::vector<long> counts(threads, 0), wrong(threads, 0);
  for (int job = 0; job < 3; ++job) {
    team.run([&](int thread) {
      for (int round = 1; round <= 300; ++round) {
        ++counts[thread];
        team.barrier(thread);
        const long sum = std::accumulate(counts.begin(), counts.end(), 0L);
        wrong[thread] += sum != long{threads} * (300 * job + round);
        team.barrier(thread);
      }
    });
  }
  CHECK(std::accumulate(wrong.begin(), wrong.end(), 0L) == 0);
}

}  // namespace pbdsurg
