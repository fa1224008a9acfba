// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which strategies of a device are of which method.

#include "pbdsurg/solver/solver_options.h"

namespace pbdsurg::testing {

/// @param method  not automatic
inline bool suits(DeviceStrategy strategy, SolverMethod method) {
  switch (strategy) {
    case DeviceStrategy::cluster:
      return method == SolverMethod::projection;
    case DeviceStrategy::cooperative:
      return method != SolverMethod::projection;
    case DeviceStrategy::automatic:
    case DeviceStrategy::stream:
    case DeviceStrategy::graph:
      break;
  }
  return true;
}

}  // namespace pbdsurg::testing
