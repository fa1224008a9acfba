// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What executes a step plan.

#include <memory>

#include "pbdsurg/solver/step_report.h"

namespace pbdsurg {

class SolverData;
struct SolverOptions;

/// One coarse call a step: nothing virtual happens per constraint.
class Backend {
 public:
  virtual ~Backend() = default;
  [[nodiscard]] virtual const char* name() const noexcept = 0;

  /// @param dt  s, positive and finite
  virtual StepReport step(SolverData& data, float dt) = 0;
};

/// One thread, every operation in IEEE single precision and in the order of the plan: the
/// definition of correct.
std::unique_ptr<Backend> make_serial_backend();

/// A team of threads, each with vector registers, over the same plan; see MathMode for its bits.
/// Null on a processor for whose vector registers nothing was compiled.
std::unique_ptr<Backend> make_threaded_backend(const SolverOptions& options);

}  // namespace pbdsurg
