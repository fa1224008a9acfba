// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fills closed surfaces: a block of threads for each copy.

#include "cuda/solver/kernel_support.cuh"
#include "lib/device/filling_sweep.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr Index kFillingThreads = 256;

/// All threads of a block, as project_filling() wants them.
struct FillingTeam {
  template <class Visit>
  __device__ void for_each(Index count, const Visit& visit) const {
    for (auto i = static_cast<Index>(threadIdx.x); i < count; i += kFillingThreads) {
      visit(i);
    }
    meet();
  }

  /// One thread adds, so that the order is that of the values; all bring them near.
  template <class Number>
  __device__ Number sum(Number start, const Number* values, Index count) const {
    __shared__ Number near[kFillingThreads];
    __shared__ Number shared_sum;
    const auto thread = static_cast<Index>(threadIdx.x);
    Number own = start;  // of the first thread
    for (Index first = 0; first < count; first += kFillingThreads) {
      near[thread] = first + thread < count ? values[first + thread] : Number(0);
      meet();
      if (thread == 0) {
        const Index rest = count - first;
        const Index end = rest < kFillingThreads ? rest : kFillingThreads;
#pragma unroll 8
        for (Index i = 0; i < end; ++i) {
          own = own + near[i];
        }
      }
      meet();  // before the next values come
    }
    if (thread == 0) {
      shared_sum = own;
    }
    meet();
    const Number result = shared_sum;
    meet();  // before it is another
    return result;
  }

  [[nodiscard]] __device__ Particle load(const Particle* particle) const {
    return load_particle(particle);
  }
  __device__ void store(Particle* particle, const Vec3<float>& x, float w) const {
    store_particle(particle, x, w);
  }
  /// Past a cache that may be out of date.
  [[nodiscard]] __device__ FillingCopy load(const FillingCopy* copy) const {
    static_assert(sizeof(FillingCopy) % sizeof(int4) == 0 && alignof(FillingCopy) == alignof(int4));
    FillingCopy result;
    const int4* const from = reinterpret_cast<const int4*>(copy);
    int4* const to = reinterpret_cast<int4*>(&result);
#pragma unroll
    for (unsigned i = 0; i < sizeof(FillingCopy) / sizeof(int4); ++i) {
      to[i] = __ldcg(from + i);
    }
    return result;
  }
  __device__ void meet() const {
    __syncthreads();
  }
  [[nodiscard]] __device__ bool is_leader() const {
    return threadIdx.x == 0;
  }
};

__global__ void __launch_bounds__(kFillingThreads)
    sweep_filling(FillingArrays filling, DeviceState state, const StepInput* input, bool is_first) {
  wait_for_previous();
  state = of_copy(state);
  project_filling(FillingTeam{}, of_copy(filling, copy_index()),
                  {state.particles, state.displacements},
                  input[copy_index()].substep.inverse_dt_squared, is_first);
}

void project_filling(const FillingArrays& filling, const DeviceState& state, const StepInput* input,
                     bool is_first, const Launch& how) {
  launch(how, "launching what fills a surface", 1, kFillingThreads, sweep_filling, filling, state,
         input, is_first);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
