// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One solver, stepped again and again from the same start.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "bench/support/paper_step.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {

/// What a step is timed with.
struct StepConditions {
  /// Steps from the start to the one that is timed, in which a device takes over the start.
  int steps_before = 0;
  /// Vertices that each step brings to the host: see Solver::watch().
  std::vector<Index> watched{};
  /// All positions are written before the step and read after it, within its time.
  bool copies = false;
};

/// @throws Error  if a step left vertices that are not finite
inline void check_finite(const StepReport& report, const Solver& solver) {
  if (report.non_finite_vertices > 0) {
    throw Error("a step of plan " + solver.plan().name + " on backend " + solver.backend_name() +
                " leaves vertices that are not finite, the first " +
                std::to_string(report.first_non_finite));
  }
}

class RepeatedStep {
 public:
  RepeatedStep(const Scene& scene, const SolverOptions& options, StepConditions conditions = {})
      : solver_(scene, options), conditions_(std::move(conditions)) {
    solver_.write_positions(stretched_positions(scene));
    solver_.watch(conditions_.watched);
    start_ = solver_.snapshot();
    read_.resize(start_.positions.size());
  }

  /// @throws Error  if the step leaves a vertex that is not finite, or another state than the
  ///                first run did
  void run() {
    solver_.restore(start_);
    for (int i = 0; i < conditions_.steps_before; ++i) {
      solver_.step(kPaperTimeStep);
    }
    StepReport report;
    times_.push_back(time_of([&] {
      if (conditions_.copies) {
        solver_.write_positions(start_.positions);
      }
      report = solver_.step(kPaperTimeStep);
      if (conditions_.copies) {
        solver_.read_positions(read_);
      }
    }));
    check_finite(report, solver_);
    const std::uint64_t hash = solver_.state_hash();
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
  StepConditions conditions_;
  Snapshot start_;
  std::vector<Eigen::Vector3f> read_;
  std::vector<double> times_;
  std::optional<std::uint64_t> end_hash_;
};

/// @param what  how `actual` was stepped, in words
/// @throws Error  if they end in different states
inline void expect_same_end(const RepeatedStep& actual, const std::string& what,
                            const RepeatedStep& expected, const std::string& expected_what) {
  if (actual.end_hash() != expected.end_hash()) {
    throw Error("a step of plan " + actual.solver().plan().name + " ends otherwise " + what +
                " than " + expected_what);
  }
}

}  // namespace pbdsurg::bench
