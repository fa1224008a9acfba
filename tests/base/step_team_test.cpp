// SPDX-License-Identifier: Apache-2.0
#include "lib/base/step_team.h"

#include <numeric>
#include <vector>

#include "tests/support/catch.h"

namespace pbdsurg {

// Would catch a barrier that lets a thread pass early: then a sum misses what another adds.
TEST_CASE("step team: after a barrier everybody sees what everybody wrote", "[unit]") {
  const int threads = GENERATE(1, 2, 3, 7);
  StepTeam team(threads);
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

// Would catch a thread that sleeps through a job, or one that comes back and takes its last meeting
// for the first of this job.
TEST_CASE("step team: a job may leave out the last threads, in any order of jobs", "[unit]") {
  StepTeam team(5);
  long wrong = 0;
  for (const int threads : {5, 1, 2, 5, 3, 3, 1, 4, 5, 2, 5}) {
    std::vector<long> counts(5, 0);
    std::vector<long> missed(5, 0);
    team.run(threads, [&](int thread) {
      for (int round = 1; round <= 50; ++round) {
        ++counts[thread];
        team.barrier(thread);
        missed[thread] +=
            std::accumulate(counts.begin(), counts.end(), 0L) != long{threads} * round;
        team.barrier(thread);
      }
    });
    for (int thread = 0; thread < 5; ++thread) {
      CHECK(counts[thread] == (thread < threads ? 50 : 0));
    }
    wrong += std::accumulate(missed.begin(), missed.end(), 0L);
  }
  CHECK(wrong == 0);
}

// Would catch a thread that goes on after the others left it, one that waits for them, or a job
// that comes after and finds the team in pieces.
TEST_CASE("step team: after a job is dissolved, the first thread does the rest alone", "[unit]") {
  StepTeam team(4);
  for (int job = 0; job < 20; ++job) {
    constexpr int kRounds = 30;
    std::vector<int> rounds(4, 0);
    team.run([&](int thread) {
      for (int round = 0; round < kRounds; ++round) {
        if (thread == 0 && round >= job) {
          team.dissolve();  // the second time it is alone
        }
        if (!team.barrier(thread)) {
          return;
        }
        ++rounds[thread];
      }
    });
    CHECK(rounds == std::vector<int>{kRounds, job, job, job});
    CHECK_FALSE(team.is_alone());
  }
}

}  // namespace pbdsurg
