// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The figures of table 2.

#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "subject.h"

namespace pbdsurg::bench {

/// How much is measured.
struct Effort {
  int least_rounds;     ///< each of which runs every backend once
  double most_seconds;  ///< no further round begins after these, once there are enough
  int pilot_rounds;     ///< of the search for the fastest plan
};

/// Times of one backend's steps.
struct StepStatistics {
  double median_ms;
  double p99_ms;
};

/// One subject under one plan.
struct Row {
  const Subject* subject;
  std::string plan;
  std::string backend;  ///< of the threaded columns
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

/// A row for the paper's plan, and one for the plan that is fastest on all threads.
/// @throws Error  if a backend's steps end otherwise when they are repeated, or otherwise than they
///                must: fast steps on one thread as on all, strict ones as the serial backend's; or
///                with vertices that are not finite
[[nodiscard]] std::vector<Row> measure(const Subject& subject, int threads, const Effort& effort);

}  // namespace pbdsurg::bench
