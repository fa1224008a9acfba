// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who does the work of a program, in builds with CUDA and without.

#include <string>

#include "pbdsurg/base/executor.h"

namespace pbdsurg::programs {

/// A CUDA device.
/// @throws BackendUnavailable  if there is none, or this build has no CUDA, saying so
[[nodiscard]] Executor device(int ordinal = 0);

/// As cuda::best(), and without CUDA executor::threads().
[[nodiscard]] Executor best();

/// Of a command line: "best", "serial", "threads", "threads:4", "cuda", "cuda:1".
/// @throws InvalidArgument     for any other, naming these
/// @throws BackendUnavailable  as device()
[[nodiscard]] Executor executor_named(const std::string& name);

}  // namespace pbdsurg::programs
