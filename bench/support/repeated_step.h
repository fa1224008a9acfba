// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One solver, stepped again and again from the same start.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/solver/solver.h"

#include "support/paper_step.h"
#include "support/timing.h"

namespace pbdsurg::bench {

class RepeatedStep {
 public:
  RepeatedStep(const Scene& scene, const SolverOptions& options) : solver_(scene, options) {
    solver_.write_positions(stretched_positions(scene));
    start_ = solver_.snapshot();
  }

  /// @throws Error  if the step leaves a vertex that is not finite, or another state than the
  ///                first run did
  void run() {
    solver_.restore(start_);
    StepReport report;
    times_.push_back(time_of([&] { report = solver_.step(kPaperTimeStep); }));
    const std::uint64_t hash = solver_.state_hash();
    if (report.non_finite_vertices > 0) {
      throw Error("a step of plan " + solver_.plan().name +
                  " leaves vertices that are not finite, the first " +
                  std::to_string(report.first_non_finite));
    }
    if (hash != end_hash_.value_or(hash)) {
      throw Error("a step of plan " + solver_.plan().name + " on backend " +
                  solver_.backend_name() + " ends otherwise when it is repeated");
    }
    end_hash_ = hash;
  }

  /// ms, of each run
  [[nodiscard]] const std::vector<double>& times() const { return times_; }

  /// Of the state that a run ends in; there must have been one.
  [[nodiscard]] std::uint64_t end_hash() const { return end_hash_.value(); }

  [[nodiscard]] const Solver& solver() const { return solver_; }

 private:
  Solver solver_;
  Snapshot start_;
  std::vector<double> times_;
  std::optional<std::uint64_t> end_hash_;
};

}  // namespace pbdsurg::bench
