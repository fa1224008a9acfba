// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How many threads tests ask each backend for.

#include "pbdsurg/solver/solver.h"

namespace pbdsurg::testing {

/// More than one where a backend takes more.
[[nodiscard]] inline int threads_of(BackendKind backend) {
  return backend == BackendKind::threaded ? 2 : 1;
}

}  // namespace pbdsurg::testing
