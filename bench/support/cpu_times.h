// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long a step takes on the CPU.

#include <string>

#include "pbdsurg/solver/solver.h"

#include "bench/support/timing.h"

namespace pbdsurg::bench {

/// How much is measured.
struct CpuEffort {
  int least_rounds;     ///< each of which runs every backend once
  double most_seconds;  ///< no further round begins after these, once there are enough
  int pilot_rounds;     ///< of the search for the fastest plan
};

/// One scene under one plan.
struct CpuTimes {
  std::string plan;
  std::string backend;  ///< of the columns with threads
  Index links;
  Index colors;  ///< phases in one sweep
  int steps;     ///< timed with each backend
  int threads;
  StepStatistics serial, one_thread, all_threads, plain_loop;
  // medians over rounds of the ratios within a round
  double serial_over_one_thread;
  double serial_over_all_threads;
  double plain_loop_over_all_threads;
};

/// Of greedy + repair, separate, joint or nested, balanced or not, on all threads.
[[nodiscard]] SolverOptions find_fastest_cpu_plan(const Scene& scene, int threads,
                                                  const CpuEffort& effort);

/// @throws Error  if a backend's steps end otherwise when they are repeated, or otherwise than they
///                must: fast steps on one thread as on all, strict ones as the serial backend's; or
///                with vertices that are not finite
[[nodiscard]] CpuTimes measure_on_cpu(const Scene& scene, const SolverOptions& plan, int threads,
                                      const CpuEffort& effort);

}  // namespace pbdsurg::bench
