// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The backend that executes whole steps on a CUDA device.

#include <memory>

#include "lib/solver/program/backend.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// On the calling thread's current device.
/// @param data  with all that a solver has, but a backend
/// @throws BackendUnavailable  if a solver with these options cannot run on the device, or if that
///                             has no room for it
std::unique_ptr<Backend> make_backend(const SolverData& data);

}  // namespace pbdsurg::cuda
