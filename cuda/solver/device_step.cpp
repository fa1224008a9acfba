// SPDX-License-Identifier: Apache-2.0
#include "solver/device_step.h"

namespace pbdsurg::cuda {

void enqueue_step(const DeviceStep& step, Sweeps& sweeps, const Launch& launch) {
  const auto& [state, constraints, tools, input, stages, has_pushers, has_attachments, vertices] =
      step.arrays;
  const StepKernels& kernels = *step.kernels;
  const bool has_tools = step.arrays.has_tools();
  const bool moves_vertices = state.falling != nullptr;
  const auto advance = moves_vertices ? kernels.advance_falling : kernels.advance;
  for (Index substep = 0; substep < step.substeps; ++substep) {
    const bool is_first = substep == 0;
    // the first follows what is no kernel
    advance(state, input, !is_first, true,
            {launch.stream, launch.overlaps && !is_first, launch.copies});
    if (has_pushers) {
      kernels.find_contacts(state, tools, input, substep, launch);
    }
    if (moves_vertices && (has_tools || vertices.is_damped)) {
      kernels.prepare_vertices(state, vertices, tools, input, has_tools, launch);
    }
    sweeps.enqueue(step.arrays, substep, launch);
    if (has_tools) {
      kernels.collect_forces(state, tools, input, launch);
    }
  }
  advance(state, input, true, false, launch);
  kernels.report(state, constraints, input, step.output, launch);
}

}  // namespace pbdsurg::cuda
