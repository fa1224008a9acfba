// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A whole step as work for a stream.

#include "cuda/solver/step_kernels.h"
#include "cuda/solver/step_start.h"
#include "cuda/solver/sweeps.h"
#include "lib/device/device_arrays.h"
#include "lib/solver/program/step_program.h"

namespace pbdsurg::cuda {

/// All that decides what is enqueued. While it is the same, so is a recording of it.
struct DeviceStep {
  const StepKernels* kernels = nullptr;
  SweepArrays arrays;
  StepOutput output{};
  StepProgram program{};
  bool changes_lengths = false;  ///< after its first substep: then it overlaps nothing
  bool is_whole = false;         ///< sweeps take all substeps at once
  KeptState start{};             ///< where the state goes before, or null

  bool operator==(const DeviceStep&) const = default;
};

/// Enqueues the program and the report. The end of a substep and the prediction of the next are one
/// launch.
void enqueue_step(const DeviceStep& step, Sweeps& sweeps, const Launch& launch);

}  // namespace pbdsurg::cuda
