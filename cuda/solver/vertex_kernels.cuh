// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Prediction and velocities: a thread a vertex.

#include "cuda/solver/kernel_support.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kVertexThreads = 128;

/// The end of one substep and the beginning of the next are one kernel: the velocity stays in a
/// register between them.
template <bool kEnds, bool kBegins>
__global__ void __launch_bounds__(kVertexThreads)
    advance_vertices(DeviceState state, const StepInput* input) {
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const Index i = thread_index();
  if (i >= count) {
    return;
  }
  const Particle p = load_particle(state.particles + i);
  const Vec3<float> x = position_of(p);
  Vec3<float> velocity;
  if constexpr (kEnds) {
    velocity = input->substep.inverse_dt * (x - position_of(load_particle(state.previous + i)));
  } else {
    const float4 v = __ldcg(reinterpret_cast<const float4*>(state.velocities + i));
    velocity = {v.x, v.y, v.z};
  }
  if constexpr (kBegins) {
    store_particle(state.previous + i, x, p.w);
    if (p.w > 0) {
      const Vec3<float> predicted = x + input->h * (input->keep * velocity + input->kick);
      store_particle(state.particles + i, predicted, p.w);
    }
  } else {
    *reinterpret_cast<float4*>(state.velocities + i) =
        make_float4(velocity.x, velocity.y, velocity.z, 0);
  }
}

/// What the code that runs on the current device was compiled for, 90 of compute capability 9.0:
/// less than the device's own where the driver made it of an older one.
int code_architecture() {
  cudaFuncAttributes attributes{};
  check(cudaFuncGetAttributes(&attributes,
                              reinterpret_cast<const void*>(&advance_vertices<true, true>)),
        "asking what kernels were compiled for");
  return attributes.ptxVersion;
}

void advance(const DeviceState& state, const StepInput* input, bool ends, bool begins,
             const Launch& how) {
  auto* const kernel = !begins ? advance_vertices<true, false>
                       : ends  ? advance_vertices<true, true>
                               : advance_vertices<false, true>;
  launch(how, "launching a prediction", blocks_for(state.capacity, kVertexThreads), kVertexThreads,
         kernel, state, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
