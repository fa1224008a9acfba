// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Backends that work on the arrays of a solver's data.

#include <memory>

#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/program/backend.h"

namespace pbdsurg {

/// One thread, every operation in IEEE single precision and in the order of the plan: the
/// definition of correct.
std::unique_ptr<Backend> make_serial_backend();

/// A team of threads, each with vector registers, over the same plan; see MathMode for its bits.
/// Null on a processor for whose vector registers nothing was compiled.
std::unique_ptr<Backend> make_threaded_backend(const SolverOptions& options);

/// The threaded one, unless the executor is serial or the processor has no vector registers for it.
[[nodiscard]] std::unique_ptr<Backend> make_host_backend(const SolverOptions& options);

}  // namespace pbdsurg
