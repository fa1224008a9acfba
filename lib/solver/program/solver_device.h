// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a solver asks of a device.

#include <memory>

#include "pbdsurg/base/export.h"

#include "lib/solver/program/backend.h"

namespace pbdsurg {

class PBDSURG_API SolverDevice {
 public:
  virtual ~SolverDevice() = default;

  /// @param data  with all that a solver has, but a backend
  /// @throws BackendUnavailable  if this scene, or a solver with these options, cannot run on the
  ///                             device
  [[nodiscard]] virtual std::unique_ptr<Backend> make_backend(const SolverData& data) = 0;
};

}  // namespace pbdsurg
