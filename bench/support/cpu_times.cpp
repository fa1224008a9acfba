// SPDX-License-Identifier: Apache-2.0
#include "bench/support/cpu_times.h"

#include <algorithm>
#include <utility>

#include "pbdsurg/base/error.h"

#include "bench/support/plain_loop.h"
#include "bench/support/repeated_step.h"

namespace pbdsurg::bench {
namespace {

SolverOptions on_serial(SolverOptions plan) {
  plan.executor = executor::serial();
  return plan;
}

SolverOptions on_threads(SolverOptions plan, int threads, MathMode math = MathMode::fast) {
  plan.executor = executor::threads(threads);
  plan.math = math;
  return plan;
}

void check_ends(const Scene& scene, const SolverOptions& plan, const RepeatedStep& serial,
                const RepeatedStep& one_thread, const RepeatedStep& all_threads, int threads) {
  const std::string on_all = "on " + std::to_string(threads) + " threads";
  expect_same_end(all_threads, on_all, one_thread, "on one");
  for (const int count : {1, threads}) {
    RepeatedStep strict(scene, on_threads(plan, count, MathMode::strict));
    strict.run();
    strict.run();
    expect_same_end(strict, "in strict mode on " + std::to_string(count) + " threads", serial,
                    "on the serial backend");
  }
}

}  // namespace

// Fewer phases, even phases or fewer meetings of threads: what pays depends on the machine.
SolverOptions find_fastest_cpu_plan(const Scene& scene, int threads, const CpuEffort& effort) {
  std::vector<std::pair<SolverOptions, RepeatedStep>> candidates;
  for (const PlanComposition composition :
       {PlanComposition::separate, PlanComposition::joint, PlanComposition::nested}) {
    for (const bool balance : {false, true}) {
      SolverOptions plan = SolverOptions::paper();
      plan.coloring = {.repair = true, .balance = balance};
      plan.composition = composition;
      candidates.emplace_back(plan, RepeatedStep(scene, on_threads(plan, threads)));
    }
  }
  for (int round = 0; round < effort.pilot_rounds; ++round) {
    for (auto& [plan, step] : candidates) {
      step.run();
    }
  }
  return std::min_element(candidates.begin(), candidates.end(),
                          [](const auto& a, const auto& b) {
                            return median(a.second.times()) < median(b.second.times());
                          })
      ->first;
}

CpuTimes measure_on_cpu(const Scene& scene, const SolverOptions& plan, int threads,
                        const CpuEffort& effort) {
  RepeatedStep serial(scene, on_serial(plan));
  RepeatedStep one_thread(scene, on_threads(plan, 1));
  RepeatedStep all_threads(scene, on_threads(plan, threads));
  PlainLoop plain_loop(scene, PlainLoop::shuffled);
  std::vector<double> plain_loop_times;

  double seconds = 0;
  for (int round = 0; round < effort.least_rounds || seconds < effort.most_seconds; ++round) {
    seconds += 1e-3 * time_of([&] {
                 serial.run();
                 one_thread.run();
                 all_threads.run();
                 plain_loop.restart();
                 plain_loop_times.push_back(time_of([&] { plain_loop.step(); }));
               });
  }
  if (!plain_loop.is_finite()) {
    throw Error("the plain loop leaves vertices that are not finite");
  }
  check_ends(scene, plan, serial, one_thread, all_threads, threads);

  const Solver& solver = all_threads.solver();
  return {solver.plan().name,
          solver.backend_name(),
          static_cast<Index>(solver.tissue().edges().size() + solver.tissue().links().size()),
          static_cast<Index>(solver.plan().phases.size()),
          static_cast<int>(plain_loop_times.size()),
          threads,
          statistics(serial.times()),
          statistics(one_thread.times()),
          statistics(all_threads.times()),
          statistics(plain_loop_times),
          median_ratio(serial.times(), one_thread.times()),
          median_ratio(serial.times(), all_threads.times()),
          median_ratio(plain_loop_times, all_threads.times())};
}

}  // namespace pbdsurg::bench
