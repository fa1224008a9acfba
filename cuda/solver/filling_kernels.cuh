// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What fills closed surfaces: a block of threads for each copy; and what vertex blocks need for
/// it.

#include <cub/block/block_scan.cuh>

#include "cuda/solver/coarse_kernels.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/momentum_kernels.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
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
  [[nodiscard]] __device__ FixedPoint load(const FixedPoint* point) const {
    return load_point(point);
  }
  [[nodiscard]] __device__ Index load(const Index* number) const {
    return __ldcg(number);
  }
  [[nodiscard]] __device__ float load(const float* number) const {
    return __ldcg(number);
  }
  __device__ void store(FixedPoint* to, const FixedPoint& point) const {
    store_point(to, point);
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

/// By projections.
__global__ void __launch_bounds__(kFillingThreads)
    sweep_filling(FillingArrays filling, DeviceState state, const StepInput* input, bool is_first) {
  wait_for_previous();
  state = of_copy(state);
  const float square_of_dt = 1 / input[copy_index()].substep.inverse_dt_squared;
  project_filling(FillingTeam{}, of_copy(filling, copy_index()),
                  FreeVertices{state.particles, state.displacements, square_of_dt}, is_first);
}

/// By vertex blocks.
template <bool kForecast>
__global__ void __launch_bounds__(kFillingThreads)
    sweep_filling_of_blocks(FillingArrays filling, DeviceState state, VertexArrays vertices,
                            FreePieceArrays pieces, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  const float inverse_dt_squared = input[copy_index()].substep.inverse_dt_squared;
  project_filling(
      FillingTeam{}, of_copy(filling, copy_index()),
      HeldVertices<kForecast>{{state.particles, state.displacements, 1 / inverse_dt_squared},
                              state.ends,
                              state.flights,
                              state.fixed_points,
                              vertices.lane_of_place,
                              vertices.guards,
                              of_copy(pieces).groups,
                              pieces.count,
                              inverse_dt_squared},
      kForecast);
}

void project_filling(const FillingArrays& filling, const DeviceState& state,
                     const VertexArrays& vertices, const FreePieceArrays& pieces,
                     const StepInput* input, bool is_first, const Launch& how) {
  constexpr const char* kName = "launching what fills a surface";
  if (state.flights == nullptr) {
    launch(how, kName, 1, kFillingThreads, sweep_filling, filling, state, input, is_first);
  } else {
    launch(how, kName, 1, kFillingThreads,
           is_first ? sweep_filling_of_blocks<true> : sweep_filling_of_blocks<false>, filling,
           state, vertices, pieces, input);
  }
}

/// kVertexParts threads a vertex of the wall.
/// @tparam kRowsChange  see DeviceLane
template <bool kRowsChange>
__global__ void __launch_bounds__(kBlockThreads)
    find_wall_ends(FillingArrays filling, DeviceState state, VertexArrays vertices,
                   ToolArrays tools, StepInput* input, Index substep, bool has_tools) {
  wait_for_previous();
  const Index vertex = thread_index() / kVertexParts, part = thread_index() % kVertexParts;
  if (vertex >= filling.vertex_count) {
    return;
  }
  const Index place = __ldg(filling.places + vertex);
  state = of_copy(state);
  vertices = of_copy(vertices);
  input += copy_index();
  if (has_tools) {
    tools = of_copy(tools, state.capacity);
  }
  const LooseEnd<float> end =
      find_loose_end<kRowsChange>(state, vertices, tools, input, substep, has_tools, place, part);
  if (part > 0) {
    return;
  }
  store_end(state.ends, place, end);
  Particle* const flight = state.flights + place;
  store_particle(flight, position_of(load_particle(flight)), kToLeastEnergy);
}

void find_wall_ends(const FillingArrays& filling, Index substep, bool has_tools,
                    const DeviceState& state, const VertexArrays& vertices, const ToolArrays& tools,
                    StepInput* input, const Launch& how) {
  launch(how, "launching the search for how walls give way",
         blocks_for(filling.vertex_count * kVertexParts, kBlockThreads), kBlockThreads,
         vertices.is_damped ? find_wall_ends<true> : find_wall_ends<false>, filling, state,
         vertices, tools, input, substep, has_tools);
}

/// Of a surface that a coarse correction knows nothing of: its vertices stay.
__global__ void __launch_bounds__(kBlockThreads)
    leave_out_vertices(FillingArrays filling, VertexArrays vertices, CoarseArrays coarse) {
  wait_for_previous();
  if (thread_index() < filling.vertex_count) {
    const Index place = __ldg(filling.places + thread_index());
    if (__ldg(vertices.lane_of_place + place) != kInvalidIndex) {
      store_particle(of_copy(coarse).residuals + place, {}, kHeld);
    }
  }
}

void leave_out_wall(const FillingArrays& filling, const VertexArrays& vertices,
                    const CoarseArrays& coarse, const Launch& how) {
  launch(how, "launching what leaves out a wall", blocks_for(filling.vertex_count, kBlockThreads),
         kBlockThreads, leave_out_vertices, filling, vertices, coarse);
}

/// What a volume's gradients do to a node, a block each: see find_wide_row().
__global__ void __launch_bounds__(kFillingThreads)
    sum_gradients(FillingArrays filling, CoarseArrays coarse, Index wide) {
  struct Load {
    float shares[4];
    Vec3<float> gradient;
  };
  using Scan = cub::BlockScan<Index, kFillingThreads>;
  __shared__ typename Scan::TempStorage storage;
  __shared__ SharedRoom<Load[kFillingThreads]> room_of_loads;
  Load(&loads)[kFillingThreads] = room_of_loads.get();
  wait_for_previous();
  coarse = of_copy(coarse);
  filling = of_copy(filling, copy_index());
  const auto node = static_cast<Index>(blockIdx.x), thread = static_cast<Index>(threadIdx.x);
  float4 sum{};
  for (Index first = 0; first < filling.vertex_count; first += kFillingThreads) {
    const Index i = first + thread;
    Load own{};
    bool is_near = false;
    if (i < filling.vertex_count) {
      const Index place = __ldg(filling.places + i);
      const CoarseVertex vertex = load_constant(coarse.vertices + place);
#pragma unroll
      for (int n = 0; n < kCoarseNodes; ++n) {
        if (vertex.nodes[n] == node && vertex.weights[n] > 0) {
          is_near = true;
#pragma unroll
          for (int k = 0; k < 4; ++k) {
            own.shares[k] = vertex.weights[n] * (k == 0 ? 1.0F : vertex.place[k - 1]);
          }
        }
      }
      is_near = is_near && vertex.takes_part() && __ldcg(&coarse.residuals[place].w) > 0;
      const float* const gradient = &filling.gradients[i].x;
      own.gradient = {__ldcg(gradient), __ldcg(gradient + 1), __ldcg(gradient + 2)};
    }
    Index rank = 0, count = 0;
    Scan(storage).ExclusiveSum(is_near ? 1 : 0, rank, count);
    if (is_near) {
      loads[rank] = own;
    }
    __syncthreads();
    for (Index l = 0; l < count && thread < 4; ++l) {
      const Vec3<float> load = loads[l].shares[thread] * loads[l].gradient;
      add({load.x, load.y, load.z, 0}, sum);
    }
    __syncthreads();  // the list
  }
  if (thread < 4) {
    AffineNumbers& to = coarse.wide_sums[wide * coarse.node_count + node];
    *reinterpret_cast<float4*>(to.of[thread]) = sum;
  }
  if (thread == 0 && node == 0) {
    coarse.wide_compliances[wide] = FillingTeam{}.load(filling.copies).compliance;
  }
}

void sum_wall(const FillingArrays& filling, Index wide, const CoarseArrays& coarse,
              const Launch& how) {
  launch(how, "launching sums of a volume's gradients", coarse.node_count, kFillingThreads,
         sum_gradients, filling, coarse, wide);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
