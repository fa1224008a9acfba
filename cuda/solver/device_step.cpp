// SPDX-License-Identifier: Apache-2.0
#include "solver/device_step.h"

namespace pbdsurg::cuda {

void enqueue_step(const DeviceStep& step, Sweeps& sweeps, const Launch& launch) {
  const auto& [state, constraints, tools, input, stages, has_pushers, has_attachments] =
      step.arrays;
  const StepKernels& kernels = *step.kernels;
  for (Index substep = 0; substep < step.substeps; ++substep) {
    const bool is_first = substep == 0;
    // the first follows what is no kernel
    kernels.advance(state, input, !is_first, true,
                    {launch.stream, launch.overlaps && !is_first, launch.copies});
    if (has_pushers) {
      kernels.find_contacts(state, tools, input, substep, launch);
    }
    sweeps.enqueue(step.arrays, substep, launch);
    if (has_pushers || has_attachments) {
      kernels.collect_forces(state, tools, input, launch);
    }
  }
  kernels.advance(state, input, true, false, launch);
  kernels.report(state, constraints, input, step.output, launch);
}

}  // namespace pbdsurg::cuda
