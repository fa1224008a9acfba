// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How threads share a sweep.

#include <vector>

#include "pbdsurg/solver/step_plan.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// Whose work a stage is, if it is not one thread's.
inline constexpr int kEverybody = -1;

/// Part of a sweep: what one thread does, or all together.
struct ThreadStage {
  Phase phase;
  Index group;         ///< of the constraints that it projects
  int owner;           ///< a thread, or kEverybody, who share it
  bool is_met_before;  ///< whether the threads meet before it
};

/// The sweeps of a number of threads, as they meet between stages.
class ThreadStages {
 public:
  /// Phases that take less time than a meeting of the threads are left to thread 0, one after
  /// another without meetings between them. Of a nested plan, a domain is one thread's.
  void plan(const SolverData& data, int threads);

  [[nodiscard]] auto begin() const noexcept { return stages_.begin(); }
  [[nodiscard]] auto end() const noexcept { return stages_.end(); }

 private:
  template <class Constraint>
  void add(const SolverData& data, const Phase& phase, const ConstraintSlots<Constraint>& slots,
           Index group);
  void add(const Phase& phase, Index group, int owner);

  std::vector<ThreadStage> stages_;
  int threads_ = 1;
};

}  // namespace pbdsurg
