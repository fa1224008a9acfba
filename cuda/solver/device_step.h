// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A whole step as work for a stream.

#include "solver/device_arrays.h"
#include "solver/step_kernels.h"
#include "solver/sweeps.h"

namespace pbdsurg::cuda {

/// All that decides what is enqueued. While it is the same, so is a recording of it.
struct DeviceStep {
  const StepKernels* kernels = nullptr;
  SweepArrays arrays;
  StepOutput output{};
  int substeps = 0;

  bool operator==(const DeviceStep&) const = default;
};

/// Enqueues predictions, contacts, sweeps, velocities, forces on tools and the report.
void enqueue_step(const DeviceStep& step, Sweeps& sweeps, const Launch& launch);

}  // namespace pbdsurg::cuda
