// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where pbdsurg::cuda, if a program links it, leaves word of its backend. The core knows no more
/// of it.

#include <memory>
#include <string>

#include "pbdsurg/core/export.h"

#include "solver/backend.h"

namespace pbdsurg {

struct CudaHook {
  /// Whether there is a device that steps can run on.
  /// @param why_not  a sentence for the user, without a full stop, where there is none
  bool (*available)(std::string& why_not);

  /// @param data  with all that a solver has, but a backend
  /// @throws BackendUnavailable  if this scene, or a solver with these options, cannot run on the
  ///                             device
  std::unique_ptr<Backend> (*make)(const SolverData& data);
};

/// Called before main() by the static initialiser of pbdsurg::cuda, and by tests.
/// @param hook  valid for ever, or null
/// @return      the one before, or null
PBDSURG_API const CudaHook* set_cuda_hook(const CudaHook* hook) noexcept;

/// Null in a program without pbdsurg::cuda.
[[nodiscard]] const CudaHook* cuda_hook() noexcept;

}  // namespace pbdsurg
