// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All sweeps of the vertex-block method in one kernel. Warps go through the colours on their own:
/// a vertex waits for the vertices that it hears from and for nothing else, where a launch a colour
/// waits for the whole device. Every fixed point tells how many sweeps its vertex has made, and is
/// one access of 16 bytes, so that who reads the one has read the other.
///
/// A neighbour of an earlier colour has one sweep more to make than the vertex, one of a later
/// colour as many. Neither can make another before the vertex has made its own. So who waits for a
/// neighbour finds what the serial order gives it, and no one waits in a circle: of all that is not
/// done, what comes first in that order waits for nothing. All blocks of the kernel are on the
/// device at once, or those waited for might never come.

#include <cstddef>
#include <cstdint>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "lib/device/neighbor_lists.h"

/// Accesses of 16 bytes that order nothing but themselves: since PTX 8.3.
#define PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS (CUDART_VERSION >= 12030)

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kPackThreads = 128;
/// The sweeps of a point are in the low bits of its unit, a power of two or not a number: bits that
/// are zero in both.
constexpr auto kSweepBits = static_cast<std::uint32_t>(VertexRecords::kMostSweeps);

__device__ inline FixedPoint load_counted(const FixedPoint* point) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  std::uint64_t low, high;
  asm volatile(
      "{\n\t.reg .b128 point;\n\t"
      "ld.relaxed.gpu.global.b128 point, [%2];\n\t"
      "mov.b128 {%0, %1}, point;\n\t}"
      : "=l"(low), "=l"(high)
      : "l"(point)
      : "memory");
  return {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(low >> 32),
          static_cast<std::uint32_t>(high),
          __uint_as_float(static_cast<std::uint32_t>(high >> 32))};
#else
  return load_point(point);
#endif
}

__device__ inline void store_counted(FixedPoint* to, const FixedPoint& point, Index sweeps) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  const std::uint32_t unit = __float_as_uint(point.unit) | static_cast<std::uint32_t>(sweeps);
  const std::uint64_t low = std::uint64_t{point.y} << 32 | point.x;
  const std::uint64_t high = std::uint64_t{unit} << 32 | point.z;
  asm volatile(
      "{\n\t.reg .b128 point;\n\t"
      "mov.b128 point, {%1, %2};\n\t"
      "st.relaxed.gpu.global.b128 [%0], point;\n\t}"
      :
      : "l"(to), "l"(low), "l"(high)
      : "memory");
#else
  static_cast<void>(sweeps);
  store_point(to, point);
#endif
}

__device__ inline Index sweeps_of(const FixedPoint& point) {
  return static_cast<Index>(__float_as_uint(point.unit) & kSweepBits);
}
__device__ inline FixedPoint without_sweeps(const FixedPoint& point) {
  return {point.x, point.y, point.z, __uint_as_float(__float_as_uint(point.unit) & ~kSweepBits)};
}

/// A point whose vertex has made so many sweeps.
__device__ inline FixedPoint wait_for(const FixedPoint* at, FixedPoint point, Index sweeps) {
  while (sweeps_of(point) < sweeps) {
    point = load_counted(at);
  }
  return without_sweeps(point);
}

__device__ inline Vec3<float> way_between(const FixedPoint& from, const FixedPoint& to) {
  return fixed_difference<float, std::uint32_t>({to.x, to.y, to.z}, {from.x, from.y, from.z},
                                                to.unit);
}

/// As DeviceLane, while the neighbours stand still.
struct WaitingLane {
  const FixedPoint* fixed_points;
  FixedPoint own;
  Index lane;

  [[nodiscard]] __device__ float load(const float* numbers) const { return __ldg(numbers + lane); }
  [[nodiscard]] __device__ Vec3<float> position(const ParticleOffset* corners) const {
    const FixedPoint point = load_counted(&at(fixed_points, __ldg(corners + lane)));
    return way_between(own, without_sweeps(point));
  }
};

__device__ inline VertexRecords of_copy(VertexRecords records, const VertexArrays& vertices) {
  if (vertices.is_damped) {
    const std::size_t lanes = copy_index() * kBlockLanes;
    records.springs += lanes * static_cast<std::size_t>(vertices.spring_count);
    records.volumes += lanes * static_cast<std::size_t>(vertices.volume_count);
  }
  return records;
}

/// Where the rows of a lane start in the arrays of VertexRecords.
__device__ inline std::size_t first_record(const RowRange& rows, Index lane) {
  return static_cast<std::size_t>(rows.first) * kBlockLanes +
         static_cast<std::size_t>(lane * rows.count);
}

__device__ inline RowRange load_range(const RowRange* range) {
  const int2 words = __ldg(reinterpret_cast<const int2*>(range));
  return {words.x, words.y};
}

/// A block a block of vertices.
template <bool kNumbersOnly>
__global__ void __launch_bounds__(kPackThreads)
    pack_block(VertexArrays vertices, VertexRecords records) {
  wait_for_previous();
  records = of_copy(records, vertices);
  vertices = of_copy(vertices);
  const auto index = static_cast<Index>(blockIdx.x);
  const VertexBlock block = load_ranges(vertices.blocks + index);
  const RowRange list = load_range(records.lists + index);
  const Index first = static_cast<Index>(threadIdx.x) / kBlockLanes;
  const Index lane = static_cast<Index>(threadIdx.x) % kBlockLanes;
  constexpr Index kStride = kPackThreads / kBlockLanes;
  const auto position_of = [&](ParticleOffset corner) {
    const std::uint32_t* const neighbors = records.neighbors + first_record(list, lane);
    std::uint32_t position = 0;
    while (position < static_cast<std::uint32_t>(list.count) &&
           (__ldg(neighbors + position) & ~kNeighborFlags) != corner) {
      ++position;
    }
    return position;
  };
  if (!kNumbersOnly && copy_index() == 0) {
    for (Index i = first; i < block.pulls.count; i += kStride) {
      const PullRow& row = vertices.pulls[block.pulls.first + i];
      records.pulls[first_record(block.pulls, lane) + i] = {row.weights[lane],
                                                            position_of(row.neighbors[lane])};
    }
  }
  if (!vertices.is_damped && copy_index() > 0) {
    return;
  }
  for (Index i = first; i < block.springs.count; i += kStride) {
    const SpringRow& row = vertices.springs[block.springs.first + i];
    SpringRecord* const record = records.springs + first_record(block.springs, lane) + i;
    *reinterpret_cast<float2*>(record) =
        make_float2(__ldcg(row.stiffness + lane), __ldcg(row.rest + lane));
    if constexpr (!kNumbersOnly) {
      record->neighbor = position_of(row.neighbors[lane]);
    }
  }
  for (Index i = first; i < block.volumes.count; i += kStride) {
    const VolumeRow& row = vertices.volumes[block.volumes.first + i];
    VolumeRecord* const record = records.volumes + first_record(block.volumes, lane) + i;
    *reinterpret_cast<float2*>(record) =
        make_float2(__ldcg(row.stiffness + lane), __ldcg(row.target + lane));
    if constexpr (!kNumbersOnly) {
      record->face = position_of(row.face[0][lane]) | position_of(row.face[1][lane]) << 8 |
                     position_of(row.face[2][lane]) << 16;
    }
  }
}

void pack_rows(const VertexArrays& vertices, const VertexRecords& records, bool numbers_only,
               const Launch& how) {
  launch(how, "launching the packing of rows", vertices.block_count, kPackThreads,
         numbers_only ? pack_block<true> : pack_block<false>, vertices, records);
}

/// Neighbours that a thread waits for, several at once.
template <int kCount, int kParts>
class Arrivals {
 public:
  /// Asks for the first.
  __device__ void begin(const FixedPoint* points, const Neighbor* neighbors, Index count,
                        Index part) {
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      if (part + k * kParts < count) {
        names_[k] = __ldg(neighbors + part + k * kParts);
      }
    }
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      if (part + k * kParts < count) {
        met_[k] = load_counted(&at(points, names_[k] & ~kNeighborFlags));
      }
    }
  }

  /// Writes the ways to all of them.
  /// @param ways  [count] of the vertex, shared by its threads
  __device__ void finish(const FixedPoint* points, const Neighbor* neighbors, Index count,
                         Index part, const FixedPoint& own, Index sweep, float4* ways) {
    for (Index first = part;;) {
#pragma unroll
      for (int k = 0; k < kCount; ++k) {
        const Index i = first + k * kParts;
        if (i < count) {
          const Index due = (names_[k] & kStandsStill) != 0    ? 0
                            : (names_[k] & kMovesEarlier) != 0 ? sweep + 1
                                                               : sweep;
          const FixedPoint point = wait_for(&at(points, names_[k] & ~kNeighborFlags), met_[k], due);
          const Vec3<float> way = way_between(own, point);
          ways[i] = make_float4(way.x, way.y, way.z, 0);
        }
      }
      first += kCount * kParts;
      if (first >= count) {
        return;
      }
      begin(points, neighbors, count, first);
    }
  }

 private:
  Neighbor names_[kCount];
  FixedPoint met_[kCount];
};

/// The first records of a thread, in registers while neighbours are on their way.
template <class Record, int kCount, int kParts>
struct FirstRecords {
  Record records[kCount];

  __device__ void load(const Record* from, Index count, Index part) {
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      if (part + k * kParts < count) {
        records[k] = load_record(from + part + k * kParts);
      }
    }
  }

  /// Visits these and all others of the thread.
  template <class Visit>
  __device__ void for_each(const Record* from, Index count, Index part, const Visit& visit) const {
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      if (part + k * kParts < count) {
        visit(records[k]);
      }
    }
    for (Index i = part + kCount * kParts; i < count; i += kParts) {
      visit(load_record(from + i));
    }
  }

 private:
  __device__ static Record load_record(const Record* record) {
    if constexpr (sizeof(Record) == sizeof(int2)) {
      const int2 words = __ldg(reinterpret_cast<const int2*>(record));
      return *reinterpret_cast<const Record*>(&words);
    } else {
      return load_constant(record);
    }
  }
};

__device__ inline Vec3<float> way_at(const float4* ways, std::uint32_t position) {
  const float4 way = ways[position];
  return {way.x, way.y, way.z};
}

/// float4 of shared memory for a vertex: odd, so that vertices of a warp use other banks.
__host__ __device__ inline Index ways_room(const VertexRecords& records) {
  return (records.longest_list + 1) | 1;
}

/// Where a warp goes: some vertices of a colour, then others, then the next colour.
struct Visit {
  VertexBlock block{};  ///< without corners
  RowRange list{};
  Index index, lane;
  ParticleOffset corner = 0;

  __device__ Visit(const VertexArrays& vertices, const VertexRecords& records,
                   const RowRange& blocks, Index vertex) {
    index = blocks.first + vertex / kBlockLanes;
    lane = vertex % kBlockLanes;
    if (vertex < blocks.count * kBlockLanes) {
      block = load_ranges(vertices.blocks + index);
      list = load_range(records.lists + index);
      corner = __ldg(vertices.blocks[index].corners + lane);
    }
  }
  [[nodiscard]] __device__ bool is_there() const { return lane < block.lane_count; }
};

/// @tparam kParts  threads of a vertex: see move_blocks()
template <int kParts, bool kTools>
__global__ void __launch_bounds__(kBlockThreads)
    sweep_blocks(VertexSweeps sweeps, VertexColors colors, DeviceState state, VertexArrays vertices,
                 VertexRecords records, ToolArrays tools, StepInput* input) {
  extern __shared__ float4 all_ways[];
  state = of_copy(state);
  records = of_copy(records, vertices);
  vertices = of_copy(vertices);
  input += copy_index();
  if constexpr (kTools) {
    tools = of_copy(tools, state.capacity);
  }
  constexpr Index kVerticesOfWarp = kWarp / kParts;
  const Index of_block = static_cast<Index>(threadIdx.x) / kParts;
  const Index part = static_cast<Index>(threadIdx.x) % kParts;
  float4* const ways = all_ways + of_block * ways_room(records);
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const VertexRows rows{vertices.blocks, vertices.pulls, vertices.springs, vertices.volumes,
                        vertices.hinges};
  const Index first_of_warp = (thread_index() / kWarp) * kVerticesOfWarp;
  const Index stride = thread_count() / kParts;
  for (Index sweep = 0; sweep < sweeps.count; ++sweep) {
    for (Index color = 0; color < colors.count; ++color) {
      const RowRange blocks = colors.blocks[color];
      // a warp's vertices go together, or their threads would wait for each other
      for (Index first = first_of_warp; first < blocks.count * kBlockLanes; first += stride) {
        const Visit visit(vertices, records, blocks, first + of_block % kVerticesOfWarp);
        const Index lane = visit.lane;
        const ParticleOffset corner = visit.corner;
        const bool is_there = visit.is_there();
        VertexBlock block = visit.block;
        const Neighbor* const neighbors = records.neighbors + first_record(visit.list, lane);
        const PullRecord* const first_pull = records.pulls + first_record(block.pulls, lane);
        const SpringRecord* const first_spring =
            records.springs + first_record(block.springs, lane);
        const VolumeRecord* const first_volume =
            records.volumes + first_record(block.volumes, lane);
        constexpr auto kOfThread = [](int count) { return (count - 1) / kParts + 1; };
        Arrivals<kParts == 1 ? 8 : kOfThread(24), kParts> arrivals;
        FirstRecords<PullRecord, kParts == 1 ? 1 : kOfThread(16), kParts> pulls;
        FirstRecords<VolumeRecord, kParts == 1 ? 1 : kOfThread(32), kParts> volumes;
        FixedPoint own{};
        Particle p{};
        Particle flight{};
        if (is_there) {
          // what its own threads wrote last, so it need not wait
          own = load_counted(&at(state.fixed_points, corner));
          arrivals.begin(state.fixed_points, neighbors, visit.list.count, part);
          p = load_particle(&at(state.displacements, corner));
          if (part == 0) {
            flight = load_particle(&at(state.flights, corner));
          }
          pulls.load(first_pull, block.pulls.count, part);
          volumes.load(first_volume, block.volumes.count, part);
          own = without_sweeps(own);
        }
        const bool moves = is_there && p.w > 0;
        if (moves) {
          arrivals.finish(state.fixed_points, neighbors, visit.list.count, part, own, sweep, ways);
          if (part == 0) {
            ways[visit.list.count] = make_float4(0, 0, 0, 0);
          }
        }
        __syncwarp();
        VertexEnergy<float> start{};
        VertexEnergy<float> energy{};
        float relaxation = 1;
        const Vec3<float> u = position_of(p);
        if (moves && part == 0) {
          relaxation = sweep + 1 < sweeps.count ? sweeps.over_relaxation : 1.0F;
          relaxation = relaxation < flight.w ? relaxation : flight.w;
          start.add_pull(inverse_dt_squared / p.w, position_of(flight) - u);
          energy = start;
        }
        if (is_lost(own)) {
          block = {};
        }
        const WaitingLane access{state.fixed_points, own, lane};
        if (moves) {
          pulls.for_each(first_pull, block.pulls.count, part, [&](const PullRecord& record) {
            energy.add_pull(record.weight, way_at(ways, record.neighbor));
          });
          for (Index i = part; i < block.springs.count; i += kParts) {
            const SpringRecord record = load_constant(first_spring + i);
            energy.add_spring(record.stiffness, record.rest, way_at(ways, record.neighbor));
          }
          volumes.for_each(
              first_volume, block.volumes.count, part, [&](const VolumeRecord& record) {
                energy.add_volume(record.stiffness, record.target, way_at(ways, record.face & 255),
                                  way_at(ways, record.face >> 8 & 255),
                                  way_at(ways, record.face >> 16));
              });
          if (block.hinges.count > 0) {
            VertexBlock hinges{};
            hinges.hinges = block.hinges;
            add_rows(rows, hinges, access, energy, {part, kParts});
          }
        }
        if constexpr (kParts > 1) {
          __syncwarp();
          add_up<kParts>(energy);
        }
        if (moves && part == 0) {
          [[maybe_unused]] Index hold = kInvalidIndex;
          if constexpr (kTools) {
            hold = __ldcg(vertices.holds + visit.index * kBlockLanes + lane);
          }
          const auto solve = [&](const VertexEnergy<float>& whole) {
            if constexpr (kTools) {
              if (hold != kInvalidIndex) {
                const Vec3<float> base = position_of(load_particle(&at(state.particles, corner)));
                const HeldVertex held{tools,          input, sweeps.substep, place_at(corner),
                                      state.capacity, hold,  {base, u}};
                return move_held(held, whole, 1 / inverse_dt_squared);
              }
            }
            return relaxation * VertexFactor<float>(whole).solve(whole.force);
          };
          const Vec3<float> moved = u + move_vertex(rows, block, access, start, energy, solve);
          store_counted(&at(state.fixed_points, corner), moved_point(own, u, moved), sweep + 1);
          store_particle(&at(state.displacements, corner), moved, p.w);
        } else if (is_there && part == 0) {  // without tissue
          store_counted(&at(state.fixed_points, corner), own, sweep + 1);
        }
        __syncwarp();
      }
    }
  }
}

constexpr int kVerticesOfBlock = kBlockThreads / kVertexParts;

std::size_t shared_bytes(const VertexRecords& records) {
  return kVerticesOfBlock * static_cast<std::size_t>(ways_room(records)) * sizeof(float4);
}

Index thread_blocks_for(Index block_count) {
  return blocks_for(block_count * kBlockLanes, kVerticesOfBlock);
}

Index prepare_sweep_of_vertices(const VertexRecords& records) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  const int room = device_attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  if (device_attribute(cudaDevAttrCooperativeLaunch) == 0 || code_architecture() < 70 ||
      shared_bytes(records) > static_cast<std::size_t>(room)) {
    return 0;
  }
  int fewest = 0;
  for (auto* const kernel : {sweep_blocks<kVertexParts, false>, sweep_blocks<kVertexParts, true>}) {
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, room),
          "asking for all shared memory of a block");
    int blocks = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel, kBlockThreads,
                                                        shared_bytes(records)),
          "asking how many blocks a multiprocessor runs at a time");
    fewest = fewest == 0 || blocks < fewest ? blocks : fewest;
  }
  return fewest * device_attribute(cudaDevAttrMultiProcessorCount);
#else
  static_cast<void>(records);
  return 0;
#endif
}

void sweep_vertices(const VertexSweeps& sweeps, const VertexColors& colors,
                    const DeviceState& state, const VertexArrays& vertices,
                    const VertexRecords& records, const ToolArrays& tools, StepInput* input,
                    const Launch& how) {
  cudaLaunchAttribute cooperative{};
  cooperative.id = cudaLaunchAttributeCooperative;
  cooperative.val.cooperative = 1;
  cudaLaunchConfig_t config{};
  config.gridDim =
      dim3(static_cast<unsigned>(sweeps.block_count), static_cast<unsigned>(how.copies));
  config.blockDim = dim3(kBlockThreads);
  config.dynamicSmemBytes = shared_bytes(records);
  config.stream = how.stream;
  config.attrs = &cooperative;
  config.numAttrs = 1;
  check(cudaLaunchKernelEx(
            &config,
            sweeps.has_tools ? sweep_blocks<kVertexParts, true> : sweep_blocks<kVertexParts, false>,
            sweeps, colors, state, vertices, records, tools, input),
        "launching the sweeps of vertices");
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
