// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The coarse correction of a substep, see coarse_correction.h: a kernel a stage, some for
/// solve_coarse(). Sums have the order that they have on a host.

#include <cstddef>
#include <cstdint>

#include <cub/block/block_scan.cuh>

#include "cuda/solver/counted_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/residual_kernels.cuh"
#include "cuda/solver/side_stream.h"
#include "lib/solver/methods/coarse_kernel.h"
#include "lib/solver/methods/fixed_point.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kSumThreads = 4 * kNodeSums;   // a sum for each of 1, X, Y and Z
constexpr int kModesOfBlock = kModesOfPart;  // of threads that find amplitudes
constexpr int kModeThreads = kModesOfBlock * kCoarseSums;
constexpr int kNodesOfBlock = 4;  // of threads that find how they move
constexpr int kNumbersOfBlock = kAffineNumbers * kNodesOfBlock;
constexpr int kNumberThreads = kNumbersOfBlock * kCoarseSums;
constexpr int kHoldThreads = 768;
static_assert(kHoldThreads >= 4 * kMostNodes && kNumberThreads >= kMostNodes &&
              kModeThreads >= kMostNodes && kVertexThreads >= kMostNodes);

/// What a kernel of the step has written, past a cache that may be out of date.
__device__ inline float4 load_quad(const void* quad) {
  return __ldcg(static_cast<const float4*>(quad));
}

__device__ inline AffineNumbers load_numbers(const AffineNumbers& from) {
  AffineNumbers numbers;
#pragma unroll
  for (int k = 0; k < 4; ++k) {
    *reinterpret_cast<float4*>(numbers.of[k]) = load_quad(from.of[k]);
  }
  return numbers;
}

struct BlockOfWorkers {
  Index first, stride;
  [[nodiscard]] __device__ Index row() const { return first / kWarp; }
  [[nodiscard]] __device__ Index rows() const { return stride / kWarp; }
  [[nodiscard]] __device__ Index column() const { return first % kWarp; }
  [[nodiscard]] __device__ Index columns() const { return kWarp; }
  __device__ void meet() const { __syncthreads(); }
};

__device__ inline void add(const float4& more, float4& sum) {
  sum.x += more.x;
  sum.y += more.y;
  sum.z += more.z;
  sum.w += more.w;
}

/// sums[thread] becomes the sum over those that are a multiple of four apart, for the first four.
__device__ inline float4 add_halves(float4 sum, float4 (&sums)[kSumThreads]) {
  const unsigned thread = threadIdx.x;
  for (unsigned half = kSumThreads / 2; half >= kWarp; half /= 2) {
    if (thread >= half && thread < 2 * half) {
      sums[thread] = sum;
    }
    __syncthreads();
    if (thread < half) {
      add(sums[thread + half], sum);
    }
  }
  if (thread < kWarp) {
#pragma unroll
    for (int half = kWarp / 2; half >= 4; half /= 2) {
      add({__shfl_down_sync(~0U, sum.x, half), __shfl_down_sync(~0U, sum.y, half),
           __shfl_down_sync(~0U, sum.z, half), __shfl_down_sync(~0U, sum.w, half)},
          sum);
    }
  }
  return sum;
}

/// Of a list of a node, what a block has.
struct NodePart {
  Index node, part;
  const Index* places;  ///< of the whole list
  Index first, end;

  __device__ NodePart(const CoarseArrays& coarse, Index index, const Index* all_places,
                      const Index* counts)
      : node(index / coarse.part_room),
        part(index % coarse.part_room),
        places(all_places + static_cast<std::size_t>(node) * coarse.member_room),
        first(part * kNodePart) {
    const Index count = __ldg(counts + node);
    end = first + kNodePart < count ? first + kNodePart : count;
  }

  /// In arrays of all parts.
  [[nodiscard]] __device__ std::size_t place(const CoarseArrays& coarse) const {
    return static_cast<std::size_t>(node) * coarse.part_room + part;
  }
};

__device__ inline Index parts_of(Index count) {
  return (count + kNodePart - 1) / kNodePart;
}

/// What residuals do to a part of a node's members, a block each; or how a part of its own vertices
/// lies.
template <bool kShape>
__device__ inline void sum_part(const Particle* particles, const CoarseArrays& coarse,
                                const NodePart& part) {
  constexpr int kVertices = kNodePart / kNodeSums;  // of a thread, which asks for all at once
  __shared__ float4 sums[kSumThreads];
  const auto k = static_cast<Index>(threadIdx.x % 4);
  const CoarseShares* const shares =
      coarse.member_shares + static_cast<std::size_t>(part.node) * coarse.member_room;
  Vec3<float> origin{0, 0, 0};
  if constexpr (kShape) {
    origin = position_of(shape_origin(load_particle(particles + part.places[0])));
  }
  Index place[kVertices];
  float share[kVertices], w[kVertices];
  Particle vector[kVertices];
  const Index start = part.first + static_cast<Index>(threadIdx.x / 4);
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    const Index i = start + n * kNodeSums < part.end ? start + n * kNodeSums : part.first;
    place[n] = part.places[i];
    share[n] = kShape ? 1.0F : shares[i].of[k];
  }
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    vector[n] = load_particle(coarse.residuals + place[n]);
    w[n] = start + n * kNodeSums < part.end ? vector[n].w : 0.0F;
    if constexpr (kShape) {
      vector[n] = load_particle(particles + place[n]);
      share[n] = k == 0 ? 1.0F : __ldg(coarse.vertices[place[n]].place + (k - 1));
    }
  }
  float4 sum{};
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    if (w[n] > 0) {
      const Vec3<float> x =
          share[n] * (kShape ? position_of(vector[n]) - origin : position_of(vector[n]));
      add({x.x, x.y, x.z, share[n]}, sum);
    }
  }
  sum = add_halves(sum, sums);
  if (threadIdx.x < 4) {
    NodeSums& to = coarse.part_sums[part.place(coarse)];
    *reinterpret_cast<float4*>((kShape ? to.shape : to.load).of[k]) = sum;
  }
}

__global__ void __launch_bounds__(kSumThreads)
    sum_nodes(const Particle* particles, Index capacity, CoarseArrays coarse) {
  const Index parts = coarse.node_count * coarse.part_room;
  const auto index = static_cast<Index>(blockIdx.x);
  const bool is_of_shape = index >= parts;
  const NodePart part = is_of_shape
                            ? NodePart(coarse, index - parts, coarse.own_places, coarse.own_counts)
                            : NodePart(coarse, index, coarse.member_places, coarse.member_counts);
  wait_for_previous();
  if (part.first >= part.end) {
    return;
  }
  coarse = of_copy(coarse);
  particles += copy_index() * static_cast<std::size_t>(capacity);
  if (is_of_shape) {
    sum_part<true>(particles, coarse, part);
  } else {
    sum_part<false>(particles, coarse, part);
  }
}

/// What moves have gained at a part of a node's own vertices, a block each.
__global__ void __launch_bounds__(kNodeSums) weigh_nodes(CoarseArrays coarse) {
  static_assert(kNodeSums == 2 * kWarp);
  constexpr int kVertices = kNodePart / kNodeSums;
  __shared__ double upper[kWarp];
  const NodePart part(coarse, static_cast<Index>(blockIdx.x), coarse.own_places, coarse.own_counts);
  wait_for_previous();
  coarse = of_copy(coarse);
  const auto thread = static_cast<Index>(threadIdx.x);
  if (part.part == 0 && thread == kWarp) {
    coarse.gains_before[part.node] = power(load_numbers(coarse.sums[part.node].load),
                                           load_numbers(coarse.moves_of_nodes[part.node]));
  }
  if (part.first >= part.end) {
    return;
  }
  Index place[kVertices];
  Particle residual[kVertices], move[kVertices];
  const Index start = part.first + thread;
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    place[n] = part.places[start + n * kNodeSums < part.end ? start + n * kNodeSums : part.first];
  }
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    residual[n] = load_particle(coarse.residuals + place[n]);
    move[n] = load_particle(coarse.moves + place[n]);
  }
  double after = 0;
#pragma unroll
  for (int n = 0; n < kVertices; ++n) {
    if (start + n * kNodeSums < part.end) {
      after += power_after(residual[n], move[n]);
    }
  }
  if (thread >= kWarp) {
    upper[thread - kWarp] = after;
  }
  __syncthreads();
  if (thread >= kWarp) {
    return;
  }
  after += upper[thread];
#pragma unroll
  for (int half = kWarp / 2; half > 0; half /= 2) {
    after += __shfl_down_sync(~0U, after, half);
  }
  if (thread == 0) {
    coarse.part_gains[part.place(coarse)] = after;
  }
}

/// What tools hold of what a node moves, a block each: for each node that it is near to.
__global__ void __launch_bounds__(kHoldThreads) sum_holds(CoarseArrays coarse) {
  constexpr Index kWarps = kHoldThreads / kWarp;
  static_assert(kWarps <= kWarp);
  using Scan = cub::BlockScan<Index, kHoldThreads>;
  __shared__ typename Scan::TempStorage storage;
  __shared__ Index members[kHoldThreads];  // those that are held, one after another
  __shared__ float4 held[kHoldThreads];    // 1, X, Y and Z times a share of their stiffness
  // of what is held near a node: warps that have some, and their threads
  __shared__ unsigned warps_near[kMostNodes];
  __shared__ unsigned threads_near[kMostNodes][kWarps];
  wait_for_previous();
  coarse = of_copy(coarse);
  const auto node = static_cast<Index>(blockIdx.x);
  const auto thread = static_cast<Index>(threadIdx.x);
  const Index near = thread / 4, k = thread % 4;  // of the first threads, which sum up
  const std::size_t first = static_cast<std::size_t>(node) * coarse.member_room;
  const Index count = coarse.member_counts[node];
  float sum = 0;
  Index held_near = 0;

  const auto take = [&](Index member) {
    const CoarseVertex vertex =
        load_constant(coarse.vertices + coarse.member_places[first + member]);
    const float weight = vertex.stiffness * coarse.member_shares[first + member].of[0];
    held[thread] = {weight, weight * vertex.place[0], weight * vertex.place[1],
                    weight * vertex.place[2]};
    if (vertex.takes_part() && vertex.stiffness > 0) {
      atomicOr(&warps_near[vertex.nodes[0]], 1U << thread / kWarp);
      atomicOr(&threads_near[vertex.nodes[0]][thread / kWarp], 1U << thread % kWarp);
    }
  };
  const auto add_near = [&] {
    for (unsigned warps = warps_near[near]; warps != 0; warps &= warps - 1) {
      const Index warp = __ffs(static_cast<int>(warps)) - 1;
      unsigned threads = threads_near[near][warp];
      held_near += __popc(threads);
      while (threads != 0) {
        constexpr int kAtOnce = 4;
        float more[kAtOnce];
#pragma unroll
        for (float& each : more) {
          const Index other = warp * kWarp + __ffs(static_cast<int>(threads)) - 1;
          each = threads != 0 ? reinterpret_cast<const float*>(held + other)[k] : 0.0F;
          threads &= threads - 1;
        }
#pragma unroll
        for (const float each : more) {
          sum += each;
        }
      }
    }
  };

  constexpr Index kMembersOfThread = 64;  // a bit each
  for (Index span = 0; span < count; span += kMembersOfThread * kHoldThreads) {
    const Index left = count - span;
    const Index each = left < kMembersOfThread * kHoldThreads
                           ? (left + kHoldThreads - 1) / kHoldThreads
                           : kMembersOfThread;
    const Index own = span + thread * each;
    std::uint64_t are_held = 0;
#pragma unroll 8
    for (Index i = 0; i < each; ++i) {
      const Index place = coarse.member_places[first + (own + i < count ? own + i : 0)];
      const bool is_held = own + i < count && __ldcg(&coarse.residuals[place].w) < 0;
      are_held |= std::uint64_t{is_held} << i;
    }
    Index rank = 0, all = 0;
    Scan(storage).ExclusiveSum(__popcll(are_held), rank, all);
    __syncthreads();  // before the next one
    for (Index start = 0; start < all; start += kHoldThreads) {
      Index at = rank - start;
      for (std::uint64_t bits = are_held; bits != 0; bits &= bits - 1, ++at) {
        if (at >= 0 && at < kHoldThreads) {
          members[at] = own + __ffsll(static_cast<long long>(bits)) - 1;
        }
      }
      for (Index i = thread; i < kMostNodes * kWarps; i += kHoldThreads) {
        threads_near[i / kWarps][i % kWarps] = 0;
      }
      if (thread < kMostNodes) {
        warps_near[thread] = 0;
      }
      __syncthreads();
      if (start + thread < all) {
        take(members[thread]);
      }
      __syncthreads();
      if (near < coarse.node_count) {
        add_near();
      }
      __syncthreads();
    }
  }
  if (near < coarse.node_count) {
    coarse.hold_sums[near * coarse.node_count + node].of[k] = sum;
  }
  if (near == node && k == 0) {
    coarse.hold_counts[node] = held_near;
  }
}

/// The holds near the first nodes that have any, and how nodes move them. All threads of a block
/// call it, and meet in it.
struct ListedHolds {
  CoarseRows holds;
  Index nodes[kCoarseHolds];  // near which they are
  float4 sums[kCoarseHolds][kMostNodes];
  Index movers[kCoarseHolds][kMostNodes];  // nodes that move a hold, ascending
  Index mover_counts[kCoarseHolds];

  __device__ void find(const CoarseArrays& coarse) {
    const auto thread = static_cast<Index>(threadIdx.x);
    const Index most = CoarseRows::most_holds(coarse.wide_count);
    if (thread < kWarp) {
      const auto count_of = [&](Index node) {
        return node < coarse.node_count ? __ldcg(coarse.hold_counts + node) : 0;
      };
      static_assert(kMostNodes <= 2 * kWarp);
      const Index counts[2] = {count_of(thread), count_of(thread + kWarp)};
      const unsigned low = __ballot_sync(~0U, counts[0] > 0);
      const unsigned high = __ballot_sync(~0U, counts[1] > 0);
      const unsigned before = (1U << thread) - 1;
      const Index places[2] = {__popc(low & before), __popc(low) + __popc(high & before)};
      for (Index half = 0; half < 2; ++half) {
        if (counts[half] > 0 && places[half] < most) {
          nodes[places[half]] = thread + half * kWarp;
          holds.counts[places[half]] = counts[half];
        }
      }
      if (thread == 0) {
        const Index all = __popc(low) + __popc(high);
        holds.count = all < most ? all : most;
        holds.wides = coarse.wide_count;
      }
    }
    __syncthreads();
    for (Index i = thread; i < holds.count * coarse.node_count;
         i += static_cast<Index>(blockDim.x)) {
      const Index hold = i / coarse.node_count, node = i % coarse.node_count;
      sums[hold][node] = load_quad(coarse.hold_sums + nodes[hold] * coarse.node_count + node);
    }
    __syncthreads();
    const Index lane = thread % kWarp;
    for (Index hold = thread / kWarp; hold < holds.count;
         hold += static_cast<Index>(blockDim.x) / kWarp) {
      Index count = 0;
      for (Index first = 0; first < coarse.node_count; first += kWarp) {
        const Index node = first + lane;
        const bool moves = node < coarse.node_count && sums[hold][node].x > 0;
        const unsigned movers_here = __ballot_sync(~0U, moves);
        if (moves) {
          movers[hold][count + __popc(movers_here & ((1U << lane) - 1))] = node;
        }
        count += __popc(movers_here);
      }
      __syncwarp();
      if (lane == 0) {
        float sum = 0;
        for (Index i = 0; i < count; ++i) {
          sum += sums[hold][movers[hold][i]].x;
        }
        mover_counts[hold] = count;
        holds.sums[hold] = sum;
      }
    }
    __syncthreads();
  }
};

/// The sum of a number of some threads of a block, in the order of kCoarseSums: that of thread i
/// is with thread i, and the others a stride apart.
template <int kStride>
__device__ inline float add_sums(float sum, float (&sums)[kStride * kCoarseSums]) {
  const auto thread = static_cast<int>(threadIdx.x);
#pragma unroll
  for (int half = kStride * kCoarseSums / 2; half >= kStride; half /= 2) {
    if (thread >= half && thread < 2 * half) {
      sums[thread] = sum;
    }
    __syncthreads();
    if (thread < half) {
      sum += sums[thread + half];
    }
  }
  return sum;
}

/// How pieces are turned. All threads of a block call it, and meet in it.
struct TurnedPieces {
  NodeSums sums[kMostNodes];
  float origins[kMostNodes][3];
  Index pieces[kMostNodes];  // of nodes; none of those without own vertices
  double of_pieces[kMostNodes][4][4];
  Turn turns[kMostNodes];

  __device__ void find(const Particle* particles, const CoarseArrays& coarse) {
    const auto thread = static_cast<Index>(threadIdx.x);
    const auto threads = static_cast<Index>(blockDim.x);
    constexpr Index kQuads = sizeof(NodeSums) / sizeof(float4);
    for (Index i = thread; i < coarse.node_count * kQuads; i += threads) {
      const Index node = i / kQuads, quad = i % kQuads;
      const Index parts =
          parts_of(__ldg((quad < kQuads / 2 ? coarse.member_counts : coarse.own_counts) + node));
      const float4* const from = reinterpret_cast<const float4*>(
          coarse.part_sums + static_cast<std::size_t>(node) * coarse.part_room);
      float4 sum{};
#pragma unroll 4
      for (Index part = 0; part < parts; ++part) {
        add(load_quad(from + part * kQuads + quad), sum);
      }
      reinterpret_cast<float4*>(sums)[i] = sum;
    }
    if (thread < coarse.node_count) {
      pieces[thread] = kInvalidIndex;
      if (coarse.own_counts[thread] > 0) {
        const std::size_t first = static_cast<std::size_t>(thread) * coarse.member_room;
        const Particle origin = shape_origin(load_particle(particles + coarse.own_places[first]));
        origins[thread][0] = origin.x;
        origins[thread][1] = origin.y;
        origins[thread][2] = origin.z;
        pieces[thread] = __ldg(coarse.pieces + thread);
      }
    }
    __syncthreads();
    for (Index i = thread; i < 16 * coarse.piece_count; i += threads) {
      const Index piece = i / 16, k = i / 4 % 4, axis = i % 4;
      double sum = 0;
      for (Index node = 0; node < coarse.node_count; ++node) {
        const double count{sums[node].shape.of[k][3]};
        const double more =
            axis == 3 ? count
                      : double{sums[node].shape.of[k][axis]} + count * double{origins[node][axis]};
        sum += pieces[node] == piece ? more : 0.0;
      }
      of_pieces[piece][k][axis] = sum;
    }
    __syncthreads();
    for (Index piece = thread; piece < coarse.piece_count; piece += threads) {
      turns[piece] = turn_of(of_pieces[piece]);
    }
    __syncthreads();
  }
};

/// Forces at nodes, as they are in pieces at rest. All threads of a block call it.
/// @param sum_of  (Index i) of 1, X, Y or Z at a node: i = 4 * node + k
template <class SumOf>
__device__ void find_loads(const TurnedPieces& turned, const CoarseArrays& coarse,
                           const SumOf& sum_of, float (&loads)[kAffineNumbers * kMostNodes]) {
  for (Index i = static_cast<Index>(threadIdx.x); i < 4 * coarse.node_count;
       i += static_cast<Index>(blockDim.x)) {
    const Vec3<float> load = turned.turns[__ldg(coarse.pieces + i / 4)].back(sum_of(i));
    loads[3 * i] = load.x;
    loads[3 * i + 1] = load.y;
    loads[3 * i + 2] = load.z;
  }
}

/// How some modes answer to them: of a mode each, with the first threads. All threads of a block
/// call it, and meet in it.
__device__ inline float answer_of_mode(const float (&loads)[kAffineNumbers * kMostNodes],
                                       const CoarseArrays& coarse, Index mode,
                                       float (&partial)[kModeThreads]) {
  float sum = 0;
  if (mode < coarse.mode_count) {
    const float* const from = coarse.numbers + mode;
#pragma unroll 36
    for (Index n = static_cast<Index>(threadIdx.x) / kModesOfBlock;
         n < kAffineNumbers * coarse.node_count; n += kCoarseSums) {
      sum += loads[n] * __ldg(from + n * coarse.mode_count);
    }
  }
  return add_sums<kModesOfBlock>(sum, partial);
}

/// How far some modes move, were it not for what a correction keeps to; and how they move that.
/// @tparam kRows  whether there may be any
template <bool kRows>
__global__ void __launch_bounds__(kModeThreads)
    find_amplitudes(const Particle* particles, Index capacity, CoarseArrays coarse,
                    const StepInput* input) {
  __shared__ SharedRoom<TurnedPieces> room_of_turned;
  TurnedPieces& turned = room_of_turned.get();
  __shared__ float loads[kAffineNumbers * kMostNodes];
  __shared__ float partial[kModeThreads];
  wait_for_previous();
  coarse = of_copy(coarse);
  particles += copy_index() * static_cast<std::size_t>(capacity);
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  turned.find(particles, coarse);
  const auto residuals = [&](Index i) {
    const float(&sum)[4] = turned.sums[i / 4].load.of[i % 4];
    return Vec3<float>{sum[0], sum[1], sum[2]};
  };
  find_loads(turned, coarse, residuals, loads);
  if (blockIdx.x == 0) {
    for (Index piece = thread; piece < coarse.piece_count; piece += kModeThreads) {
      coarse.turns[piece] = turned.turns[piece];
    }
    for (Index node = thread; node < coarse.node_count; node += kModeThreads) {
      coarse.sums[node] = turned.sums[node];
    }
  }
  __syncthreads();
  const Index mode = static_cast<Index>(blockIdx.x) * kModesOfBlock + thread % kModesOfBlock;
  const bool is_there = mode < coarse.mode_count;
  const float sum = answer_of_mode(loads, coarse, mode, partial);
  const bool is_first = is_there && thread < kModesOfBlock;  // of the threads of a mode
  float give = 0;
  if (is_first) {
    give = 1 / (input->substep.inverse_dt_squared + __ldg(coarse.stiffnesses + mode));
    coarse.amplitudes[mode] = sum * give;
  }
  if constexpr (kRows) {
    __shared__ SharedRoom<ListedHolds> room_of_listed;
    ListedHolds& listed = room_of_listed.get();
    listed.find(coarse);
    if (blockIdx.x == 0 && thread == 0) {
      *coarse.holds = listed.holds;
    }
    const Index rows = listed.holds.rows();
    __shared__ double gives[kModesOfBlock];
    __shared__ double hold_modes[kModesOfBlock * (kHoldRows + 1)];  // see sum_of_modes()
    double* const own_modes = hold_modes + thread % kModesOfBlock * (rows + 1);
    if (is_first) {
      gives[thread] = double{give};
      own_modes[rows] = double{sum * give};
    }
    for (Index hold = thread / kModesOfBlock; is_there && hold < listed.holds.count;
         hold += kCoarseSums) {
      float moves[3]{};
#pragma unroll 4
      for (Index i = 0; i < listed.mover_counts[hold]; ++i) {
        const Index node = listed.movers[hold][i];
        const float4 of_node = listed.sums[hold][node];
        const float shares[4] = {of_node.x, of_node.y, of_node.z, of_node.w};
        const float* const numbers =
            coarse.numbers + kAffineNumbers * node * coarse.mode_count + mode;
#pragma unroll
        for (Index k = 0; k < 4; ++k) {
          const float share = shares[k] / listed.holds.sums[hold];
#pragma unroll
          for (Index axis = 0; axis < 3; ++axis) {
            moves[axis] += share * __ldg(numbers + (3 * k + axis) * coarse.mode_count);
          }
        }
      }
#pragma unroll
      for (Index axis = 0; axis < 3; ++axis) {
        own_modes[3 * hold + axis] = double{moves[axis]};
      }
    }
    for (Index wide = 0; wide < coarse.wide_count; ++wide) {
      const auto gradients = [&](Index i) {
        const AffineNumbers& sums = coarse.wide_sums[wide * coarse.node_count + i / 4];
        const float4 sum = load_quad(sums.of[i % 4]);
        return Vec3<float>{sum.x, sum.y, sum.z};
      };
      __syncthreads();  // the loads before have been read
      find_loads(turned, coarse, gradients, loads);
      __syncthreads();
      const float change = answer_of_mode(loads, coarse, mode, partial);
      if (is_first) {
        own_modes[listed.holds.row_of_wide(wide)] = double{change};
      }
    }
    __syncthreads();
    const Index first = static_cast<Index>(blockIdx.x) * kModesOfBlock;
    const Index count =
        coarse.mode_count - first < kModesOfBlock ? coarse.mode_count - first : kModesOfBlock;
    double* const part = coarse.hold_parts + blockIdx.x * HoldSystem::entries(kHoldRows);
    for (Index entry = thread; entry < HoldSystem::entries(rows); entry += kModeThreads) {
      if (HoldSystem::has(entry, rows)) {
        part[entry] = HoldSystem::sum_of_modes(entry, rows, count, gives, hold_modes);
      }
    }
    for (Index i = thread; i < count * rows; i += kModeThreads) {
      coarse.hold_modes[first * rows + i] =
          static_cast<float>(hold_modes[i / rows * (rows + 1) + i % rows]);
    }
  }
}

/// Takes off what would move that. All threads of a block call it, and meet in it.
/// @param inverse_dt_squared  1/s^2
__device__ inline void oppose_rows(const CoarseArrays& coarse, float inverse_dt_squared,
                                   float (&amplitudes)[kMostModes]) {
  __shared__ HoldSystem system;
  __shared__ SharedRoom<CoarseRows> room_of_rows;
  CoarseRows& holds = room_of_rows.get();
  const auto thread = static_cast<Index>(threadIdx.x);
  const auto threads = static_cast<Index>(blockDim.x);
  constexpr Index kWords = sizeof(CoarseHolds) / sizeof(Index);
  for (Index i = thread; i < kWords; i += threads) {
    reinterpret_cast<Index*>(static_cast<CoarseHolds*>(&holds))[i] =
        __ldcg(reinterpret_cast<const Index*>(coarse.holds) + i);
  }
  if (thread == 0) {
    holds.wides = coarse.wide_count;
  }
  if (thread < coarse.wide_count) {
    holds.wide_compliances[thread] = __ldcg(coarse.wide_compliances + thread);
  }
  __syncthreads();
  const Index rows = holds.rows();
  if (rows == 0) {
    return;
  }
  system.solve(BlockOfWorkers{thread, threads}, holds, [&](Index entry) {
    double sum = 0;
#pragma unroll
    for (Index part = 0; part < kMostModeParts; ++part) {
      if (part * kModesOfPart < coarse.mode_count) {
        sum += __ldcg(coarse.hold_parts + part * HoldSystem::entries(kHoldRows) + entry);
      }
    }
    return sum;
  });
  for (Index m = thread; m < coarse.mode_count; m += threads) {
    float moves[kHoldRows];
#pragma unroll
    for (Index row = 0; row < kHoldRows; ++row) {
      moves[row] = row < rows ? __ldcg(coarse.hold_modes + m * rows + row) : 0.0F;
    }
    const float give = 1 / (inverse_dt_squared + __ldg(coarse.stiffnesses + m));
    amplitudes[m] -= system.taken(rows, give, moves);
  }
  __syncthreads();
}

/// And so some nodes.
template <bool kRows>
__global__ void __launch_bounds__(kNumberThreads)
    move_nodes(CoarseArrays coarse, const StepInput* input) {
  __shared__ float amplitudes[kMostModes];
  __shared__ float partial[kNumberThreads];
  __shared__ float moves[kNumbersOfBlock];
  wait_for_previous();
  coarse = of_copy(coarse);
  const auto thread = static_cast<Index>(threadIdx.x);
  for (Index m = thread; m < coarse.mode_count; m += kNumberThreads) {
    amplitudes[m] = __ldcg(coarse.amplitudes + m);
  }
  __syncthreads();
  if constexpr (kRows) {
    input += copy_index();
    oppose_rows(coarse, input->substep.inverse_dt_squared, amplitudes);
  }
  const Index first = static_cast<Index>(blockIdx.x) * kNodesOfBlock;
  const Index number = kAffineNumbers * first + thread % kNumbersOfBlock;
  const Index number_count = kAffineNumbers * coarse.node_count;
  float sum = 0;
  if (number < number_count) {
    const float* const from = coarse.modes + number;
#pragma unroll 24
    for (Index m = thread / kNumbersOfBlock; m < coarse.mode_count; m += kCoarseSums) {
      sum += amplitudes[m] * __ldg(from + m * number_count);
    }
  }
  sum = add_sums<kNumbersOfBlock>(sum, partial);
  if (thread < kNumbersOfBlock) {
    moves[thread] = sum;
  }
  __syncthreads();
  const Index node = first + thread / 4, k = thread % 4;
  if (thread < 4 * kNodesOfBlock && node < coarse.node_count) {
    Turn turn;
    const Turn* const from = coarse.turns + __ldg(coarse.pieces + node);
#pragma unroll
    for (int i = 0; i < 9; ++i) {
      turn.of[i] = __ldcg(from->of + i);
    }
    const float* const v = moves + 3 * thread;
    const Vec3<float> now = turn({v[0], v[1], v[2]});
    *reinterpret_cast<float4*>(coarse.moves_of_nodes[node].of[k]) =
        make_float4(now.x, now.y, now.z, 0);
  }
}

/// A vertex goes so far, and its point, whose count stays.
__device__ inline void displace(const DeviceState& state, Index place, const Vec3<float>& move) {
  const Particle p = load_particle(state.displacements + place);
  const Vec3<float> before = position_of(p), after = before + move;
  store_particle(state.displacements + place, after, p.w);
  const FixedPoint counted = load_counted(state.fixed_points + place);
  const FixedPoint point = moved_point(without_count(counted), before, after);
  store_counted(state.fixed_points + place, point,
                static_cast<Index>(__float_as_uint(counted.unit) & kCountBits));
}

__global__ void __launch_bounds__(kVertexThreads)
    move_coarsely(DeviceState state, CoarseArrays coarse, const StepInput* input) {
  __shared__ float4 nodes[4 * kMostNodes];
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  coarse = of_copy(coarse);
  for (auto i = static_cast<Index>(threadIdx.x); i < 4 * coarse.node_count; i += kVertexThreads) {
    nodes[i] = load_quad(reinterpret_cast<const float4*>(coarse.moves_of_nodes) + i);
  }
  __syncthreads();
  const Index place = thread_index();
  if (place >= count) {
    return;
  }
  const CoarseVertex vertex = load_constant(coarse.vertices + place);
  Vec3<float> way{0, 0, 0};
#pragma unroll
  for (int k = 0; k < 4; ++k) {
    Vec3<float> blend{0, 0, 0};
#pragma unroll
    for (int i = 0; i < kCoarseNodes; ++i) {
      const float4 node = nodes[4 * vertex.nodes[i] + k];
      blend = blend + vertex.weights[i] * Vec3<float>{node.x, node.y, node.z};
    }
    way = way + (k == 0 ? 1.0F : vertex.place[k - 1]) * blend;
  }
  const bool moves =
      __ldcg(&coarse.residuals[place].w) > 0 && vertex.takes_part() && is_finite_way(way);
  store_particle(coarse.moves + place, moves ? way : Vec3<float>{}, moves ? 1.0F : 0.0F);
  if (moves) {
    displace(state, place, way);
  }
}

__global__ void __launch_bounds__(kVertexThreads)
    turn_back(DeviceState state, CoarseArrays coarse, const StepInput* input) {
  __shared__ float backs[kMostNodes];  // [piece]
  __shared__ Index pieces[kMostNodes];
  __shared__ SharedRoom<CoarseGain[kMostNodes]> room_of_gains;
  CoarseGain(&gains)[kMostNodes] = room_of_gains.get();
  const Index count = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  coarse = of_copy(coarse);
  const auto thread = static_cast<Index>(threadIdx.x);
  if (thread < coarse.node_count) {
    pieces[thread] = __ldg(coarse.pieces + thread);
    const double* const parts =
        coarse.part_gains + static_cast<std::size_t>(thread) * coarse.part_room;
    double after = 0;
#pragma unroll 4
    for (Index part = 0; part < parts_of(__ldg(coarse.own_counts + thread)); ++part) {
      after += __ldcg(parts + part);
    }
    gains[thread] = {__ldcg(coarse.gains_before + thread), after};
  }
  __syncthreads();
  bool goes_back = false;
  if (thread < coarse.piece_count) {
    CoarseGain gain;
    for (Index node = 0; node < coarse.node_count; ++node) {
      if (pieces[node] == thread) {
        gain.before += gains[node].before;
        gain.after += gains[node].after;
      }
    }
    backs[thread] = static_cast<float>(gain.length() - 1);
    goes_back = backs[thread] < 0;
  }
  if (__syncthreads_or(goes_back) == 0) {
    return;
  }
  const Index place = thread_index();
  if (place >= count) {
    return;
  }
  const Particle move = load_particle(coarse.moves + place);
  const float back = backs[__ldg(coarse.pieces + coarse.vertices[place].nodes[0])];
  if (move.w > 0 && back < 0) {
    displace(state, place, back * position_of(move));
  }
}

void move_by_modes(const DeviceState& state, const CoarseArrays& coarse, const StepInput* input,
                   bool has_tools, const Launch& how) {
  const bool has_rows = has_tools || coarse.wide_count > 0;
  const auto enqueue_sums = [&](const Launch& here) {
    launch(here, "launching sums of residuals", 2 * coarse.node_count * coarse.part_room,
           kSumThreads, sum_nodes, state.particles, state.capacity, coarse);
  };
  const auto enqueue_holds = [&](const Launch& here) {
    launch(here, "launching sums of what is held", coarse.node_count, kHoldThreads, sum_holds,
           coarse);
  };
  if (has_rows) {
    side_by_side(how, enqueue_sums, enqueue_holds);
  } else {
    enqueue_sums(how);
  }
  launch(how, "launching what finds amplitudes", blocks_for(coarse.mode_count, kModesOfBlock),
         kModeThreads, has_rows ? find_amplitudes<true> : find_amplitudes<false>, state.particles,
         state.capacity, coarse, input);
  launch(how, "launching moves of nodes", blocks_for(coarse.node_count, kNodesOfBlock),
         kNumberThreads, has_rows ? move_nodes<true> : move_nodes<false>, coarse, input);
  launch(how, "launching a coarse move", blocks_for(state.capacity, kVertexThreads), kVertexThreads,
         move_coarsely, state, coarse, input);
}

void turn_back_moves(const DeviceState& state, const CoarseArrays& coarse, const StepInput* input,
                     const Launch& how) {
  launch(how, "launching gains of a coarse move", coarse.node_count * coarse.part_room, kNodeSums,
         weigh_nodes, coarse);
  launch(how, "launching what turns back", blocks_for(state.capacity, kVertexThreads),
         kVertexThreads, turn_back, state, coarse, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
