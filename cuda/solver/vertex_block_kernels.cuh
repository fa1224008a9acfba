// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The vertex-block method: a thread a vertex, two blocks of vertices side by side in a warp, so
/// that lanes of a row lie side by side, too.

#include <cstddef>

#include "cuda/solver/grip_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/methods/vertex_moves.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

// that share the rows of a vertex: see move_blocks()
constexpr int kVertexParts = kRowParts;
// whether the first rows of a thread are added before others, which the serial backend does not
constexpr bool kTakesFirstRows = !PBDSURG_KERNELS_ARE_STRICT;

__device__ inline VertexArrays of_copy(VertexArrays vertices) {
  const std::size_t copy = copy_index();
  vertices.holds += copy * static_cast<std::size_t>(vertices.block_room * kBlockLanes);
  if (vertices.guards != nullptr) {
    vertices.guards += copy * static_cast<std::size_t>(vertices.block_room * kBlockLanes);
  }
  if (vertices.is_damped) {
    vertices.springs += copy * static_cast<std::size_t>(vertices.spring_room);
    vertices.volumes += copy * static_cast<std::size_t>(vertices.volume_room);
    vertices.hinges += copy * static_cast<std::size_t>(vertices.hinge_room);
    vertices.triangles += copy * static_cast<std::size_t>(vertices.triangle_room);
  }
  return vertices;
}

__device__ inline VertexRows rows_of(const VertexArrays& vertices) {
  return {vertices.blocks, vertices.pulls,     vertices.springs, vertices.volumes,
          vertices.hinges, vertices.triangles, vertices.fibres};
}

/// A block without its corners.
/// @tparam kRare  with triangles and fibres; without, kernels have no code for them, and more
///                registers
template <bool kRare>
__device__ VertexBlock load_ranges(const VertexBlock* block) {
  constexpr std::size_t kFirst = offsetof(VertexBlock, lane_count);
  static_assert(kFirst % sizeof(int4) == 0 && offsetof(VertexBlock, is_damped) == kFirst + 4 &&
                offsetof(VertexBlock, has_angles) == kFirst + 5 &&
                offsetof(VertexBlock, pulls) == kFirst + 8 &&
                offsetof(VertexBlock, springs) == kFirst + 16 &&
                offsetof(VertexBlock, volumes) == kFirst + 24 &&
                offsetof(VertexBlock, hinges) == kFirst + 32 &&
                offsetof(VertexBlock, triangles) == kFirst + 40 &&
                offsetof(VertexBlock, fibres) == kFirst + 48);
  const int4* const words = reinterpret_cast<const int4*>(block) + kFirst / sizeof(int4);
  const int4 head = __ldg(words);
  const int4 tail = __ldg(words + 1);
  VertexBlock result{};
  result.lane_count = head.x;
  result.is_damped = (head.y & 0xff) != 0;
  result.has_angles = (head.y & 0xff00) != 0;
  result.pulls = {head.z, head.w};
  result.springs = {tail.x, tail.y};
  result.volumes = {tail.z, tail.w};
  if constexpr (kRare) {
    const int4 others = __ldg(words + 2);
    const int2 fibres = __ldg(reinterpret_cast<const int2*>(words + 3));
    result.hinges = {others.x, others.y};
    result.triangles = {others.z, others.w};
    result.fibres = {fibres.x, fibres.y};
  } else {
    const int2 hinges = __ldg(reinterpret_cast<const int2*>(words + 2));
    result.hinges = {hinges.x, hinges.y};
  }
  return result;
}

/// One lane of a block within sweeps: see LaneAccess.
/// @tparam kRowsChange  whether kernels of the step write the numbers that this loads
template <bool kRowsChange>
struct DeviceLane {
  const FixedPoint* fixed_points;
  FixedPoint own;
  Index lane;

  [[nodiscard]] __device__ float load(const float* numbers) const {
    if constexpr (kRowsChange) {
      return __ldcg(numbers + lane);
    } else {
      return __ldg(numbers + lane);
    }
  }
  [[nodiscard]] __device__ Vec3<float> position(const ParticleOffset* corners) const {
    return position(__ldg(corners + lane));
  }
  [[nodiscard]] __device__ Vec3<float> position(ParticleOffset corner) const {
    const FixedPoint point = load_point(&at(fixed_points, corner));
    return fixed_difference<float, std::uint32_t>({point.x, point.y, point.z},
                                                  {own.x, own.y, own.z}, point.unit);
  }
};

/// Likewise at the start of a substep: see StartAccess.
struct DeviceStart {
  const Particle* bases;
  const Carry* carries;
  Vec3<float> own_base;
  Index lane;

  [[nodiscard]] __device__ float load(const float* numbers) const { return __ldg(numbers + lane); }
  __device__ void store(float number, float* numbers) const { numbers[lane] = number; }
  [[nodiscard]] __device__ Vec3<float> position(const ParticleOffset* corners) const {
    const ParticleOffset corner = __ldg(corners + lane);
    const Carry carry = load_carry(&at(carries, corner));
    return (position_of(load_particle(&at(bases, corner))) - own_base) +
           Vec3<float>{carry.x, carry.y, carry.z};
  }
};

/// The index of a place's HeldInput, or kInvalidIndex.
__device__ inline Index find_held(StepInput* input, Index place) {
  const HeldInput* const held = table<HeldInput>(input, input->held);
  Index first = 0;
  Index last = input->held_count;
  while (first < last) {
    const Index middle = (first + last) / 2;
    if (held[middle].place < place) {
      first = middle + 1;
    } else {
      last = middle;
    }
  }
  return first < input->held_count && held[first].place == place ? first : kInvalidIndex;
}

/// What tools do at a vertex: see VertexArrays::holds.
__device__ inline Index find_hold(const ToolArrays& tools, StepInput* input, Index place) {
  const Index held = find_held(input, place);
  if (held != kInvalidIndex) {
    return held;
  }
  for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
    if (touches(tools, pusher, place)) {
      return kOnlyTouched;
    }
  }
  return holds_of(tools.surfaces, place).count > 0 || holds_of(tools.touches, place).count > 0
             ? kOnlySurfaces
             : kInvalidIndex;
}

/// What sweeps of a substep read: what tools do where, and what damping makes of rows.
__global__ void __launch_bounds__(kBlockThreads)
    prepare_blocks(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                   bool has_tools) {
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  input += copy_index();
  if (has_tools) {
    tools = of_copy(tools, state.capacity);
    // no sweep visits those that hold what cannot move
    for (Index a = thread_index(); a < input->attachment_count; a += thread_count()) {
      tools.attachment_multipliers[a] = {};
    }
  }
  const Index index = thread_index() / kBlockLanes;
  const Index lane = thread_index() % kBlockLanes;
  if (index >= vertices.block_count) {
    return;
  }
  const VertexBlock* const block = vertices.blocks + index;
  const VertexBlock ranges = load_ranges<false>(block);
  if (lane >= ranges.lane_count) {
    return;
  }
  const ParticleOffset corner = __ldg(block->corners + lane);
  if (has_tools) {
    vertices.holds[thread_index()] = find_hold(tools, input, place_at(corner));
  }
  if (ranges.is_damped) {
    add_damping(DampedRows{vertices.blocks, vertices.springs, vertices.volumes, vertices.hinges,
                           vertices.triangles, vertices.damped_springs, vertices.damped_volumes,
                           vertices.damped_triangles},
                *block,
                DeviceStart{state.particles, state.carries,
                            position_of(load_particle(&at(state.particles, corner))), lane},
                input->substep.inverse_dt);
  }
}

void prepare_vertices(const DeviceState& state, const VertexArrays& vertices,
                      const ToolArrays& tools, StepInput* input, bool has_tools,
                      const Launch& how) {
  launch(how, "launching what comes before sweeps of vertices",
         blocks_for(vertices.block_count * kBlockLanes, kBlockThreads), kBlockThreads,
         prepare_blocks, state, vertices, tools, input, has_tools);
}

/// Tools at one vertex, as move_held() takes them.
/// @tparam kGrips  whether jaws may hold with a limit; without, kernels have no code for that
template <bool kGrips>
struct HeldVertex {
  const DeviceState& state;
  const ToolArrays& tools;
  StepInput* input;
  Index substep, place;
  Index hold;  ///< index of its HeldInput, or kOnlyTouched
  SplitPosition position;

  struct Grasp {
    AttachmentInput attachment;
    const SplitPosition& position;
    Vec3<float>* stored;

    [[nodiscard]] __device__ Vec3<float> target() const {
      return position.way_to(attachment.target);
    }
    [[nodiscard]] __device__ float compliance() const { return attachment.compliance; }
    __device__ void set_multiplier(const Vec3<float>& multiplier) const { *stored = multiplier; }
  };

  struct Touch {
    CapsulePlane plane;
    const SplitPosition& position;
    float* stored;

    [[nodiscard]] __device__ Vec3<float> normal() const { return plane.normal; }
    [[nodiscard]] __device__ float offset() const {
      return position.height_to(plane.normal, plane.offset);
    }
    [[nodiscard]] __device__ float multiplier() const { return *stored; }
    __device__ void set_multiplier(float multiplier) const { *stored = multiplier; }
  };

  template <class Visit>
  __device__ void for_each_grasp(const Visit& visit) const {
    if (hold < 0) {
      return;
    }
    const AttachmentInput* const attachments = table<AttachmentInput>(input, input->attachments) +
                                               row_at(substep, input->attachment_count);
    const Index* const order = table<Index>(input, input->held_order);
    const HeldInput held = load_constant(table<HeldInput>(input, input->held) + hold);
    for (Index i = held.first + held.count; i-- > held.first;) {
      const Index a = order[i];
      if constexpr (kGrips) {
        if (a >= input->attachment_count) {
          visit(GripDraw(state, input, a - input->attachment_count));
          continue;
        }
      }
      visit(Grasp{load_constant(attachments + a), position, tools.attachment_multipliers + a});
    }
  }

  template <class Visit>
  __device__ void for_each_contact(const Visit& visit) const {
    for (Index pusher = input->pusher_count; pusher-- > 0;) {
      if (touches(tools, pusher, place)) {
        const std::size_t slot = row_at(pusher, state.capacity) + static_cast<std::size_t>(place);
        visit(Touch{tools.planes[slot], position, tools.contact_multipliers + slot});
      }
    }
  }
};

/// By how much a vertex moves that tools touch or hold, m.
/// @param hold    see VertexArrays::holds
/// @param u       m, its displacement
/// @param energy  with that of contacts with surfaces
template <bool kGrips>
__device__ Vec3<float> move_touched(const DeviceState& state, const ToolArrays& tools,
                                    StepInput* input, Index substep, ParticleOffset corner,
                                    Index hold, const Vec3<float>& u,
                                    const VertexEnergy<float>& energy) {
  if (hold == kOnlySurfaces) {
    return VertexFactor<float>(energy).solve(energy.force);
  }
  const Vec3<float> base = position_of(load_particle(&at(state.particles, corner)));
  const HeldVertex<kGrips> held{state, tools, input, substep, place_at(corner), hold, {base, u}};
  return move_held(held, energy, 1 / input->substep.inverse_dt_squared);
}

/// The sum of what some neighbouring threads of a warp have found, for each of them: in the order
/// of add_tree().
/// @param mask  threads of the warp that call this
template <int kThreads>
__device__ void add_up(VertexEnergy<float>& energy, unsigned mask) {
  float* const numbers[] = {&energy.force.x, &energy.force.y, &energy.force.z, &energy.isotropic,
                            &energy.xx,      &energy.yy,      &energy.zz,      &energy.xy,
                            &energy.xz,      &energy.yz};
#pragma unroll
  for (int distance = kThreads / 2; distance > 0; distance /= 2) {
#pragma unroll
    for (float* const number : numbers) {
      *number += __shfl_xor_sync(mask, *number, distance);
    }
  }
}

/// Likewise of forces alone.
template <int kThreads>
__device__ void add_up(VertexForce<float>& sum, unsigned mask) {
  float* const numbers[] = {&sum.force.x, &sum.force.y, &sum.force.z};
#pragma unroll
  for (int distance = kThreads / 2; distance > 0; distance /= 2) {
#pragma unroll
    for (float* const number : numbers) {
      *number += __shfl_xor_sync(mask, *number, distance);
    }
  }
}

/// Those with which a thread shares a vertex.
template <int kThreads>
__device__ unsigned mask_of_parts() {
  const unsigned lane = threadIdx.x % kWarp;
  return ((1U << kThreads) - 1) << (lane / kThreads * kThreads);
}

/// The first rows of a thread, in registers before it waits for other kernels: what they name does
/// not change in a step, and all their neighbours are then asked for at once. Where there are none,
/// the vertex stands for neighbours, without stiffness.
template <int kParts, bool kDamped>
struct FirstRows {
  static constexpr int kPulls = 2;
  static constexpr int kVolumes = 3;

  ParticleOffset neighbors[kPulls];
  ParticleOffset faces[kVolumes][3];
  float weights[kPulls];
  float stiffness[kVolumes], targets[kVolumes];

  __device__ void load(const VertexArrays& vertices, const VertexBlock& block,
                       ParticleOffset corner, Index lane, Index part) {
#pragma unroll
    for (int k = 0; k < kPulls; ++k) {
      const Index i = part + k * kParts;
      const bool is_there = i < block.pulls.count;
      const PullRow* const row = vertices.pulls + (block.pulls.first + i);
      neighbors[k] = is_there ? __ldg(row->neighbors + lane) : corner;
      weights[k] = is_there ? __ldg(row->weights + lane) : 0.0F;
    }
#pragma unroll
    for (int k = 0; k < kVolumes; ++k) {
      const bool is_there = part + k * kParts < block.volumes.count;
      const VolumeRow* const row = row_of(vertices, block, part, k);
#pragma unroll
      for (int c = 0; c < 3; ++c) {
        faces[k][c] = is_there ? __ldg(row->face[c] + lane) : corner;
      }
    }
    if constexpr (!kDamped) {
      load_numbers(vertices, block, lane, part);
    }
  }

  /// What damping changes: after the kernel that does.
  __device__ void load_numbers(const VertexArrays& vertices, const VertexBlock& block, Index lane,
                               Index part) {
#pragma unroll
    for (int k = 0; k < kVolumes; ++k) {
      const bool is_there = part + k * kParts < block.volumes.count;
      const VolumeRow* const row = row_of(vertices, block, part, k);
      const auto number = [&](const float* from) {
        return is_there ? (kDamped ? __ldcg(from + lane) : __ldg(from + lane)) : 0.0F;
      };
      stiffness[k] = number(row->stiffness);
      targets[k] = number(row->target);
    }
  }

  __device__ void add(const DeviceLane<kDamped>& access, VertexEnergy<float>& energy) const {
    Vec3<float> ways[kPulls];
    Vec3<float> corners[kVolumes][3];
#pragma unroll
    for (int k = 0; k < kPulls; ++k) {
      ways[k] = access.position(neighbors[k]);
    }
#pragma unroll
    for (int k = 0; k < kVolumes; ++k) {
#pragma unroll
      for (int c = 0; c < 3; ++c) {
        corners[k][c] = access.position(faces[k][c]);
      }
    }
#pragma unroll
    for (int k = 0; k < kPulls; ++k) {
      energy.add_pull(weights[k], ways[k]);
    }
#pragma unroll
    for (int k = 0; k < kVolumes; ++k) {
      energy.add_volume(stiffness[k], targets[k], corners[k][0], corners[k][1], corners[k][2]);
    }
  }

  /// Leaves the rows that threads have here out of a block.
  __device__ static void leave_out(VertexBlock& block) {
    const auto leave = [](RowRange& range, Index rows) {
      const Index left = range.count < rows ? range.count : rows;
      range = {range.first + left, range.count - left};
    };
    leave(block.pulls, kPulls * kParts);
    leave(block.volumes, kVolumes * kParts);
  }

 private:
  __device__ static const VolumeRow* row_of(const VertexArrays& vertices, const VertexBlock& block,
                                            Index part, int k) {
    return vertices.volumes + (block.volumes.first + part + k * kParts);
  }
};

/// Blocks [first, first + count), of one colour.
/// @tparam kParts  threads of a vertex, neighbours in a warp, which share its rows: it has some 36,
///                 and a colour is small.
/// @tparam kRare   see load_ranges()
template <int kParts, bool kDamped, bool kTools, bool kRare>
__global__ void __launch_bounds__(kBlockThreads)
    move_blocks(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                Index first, Index count, VertexSweep sweep) {
  const Index vertex = thread_index() / kParts;
  const Index part = thread_index() % kParts;
  const Index index = first + vertex / kBlockLanes;
  const Index lane = vertex % kBlockLanes;
  VertexBlock block{};
  ParticleOffset corner = 0;
  if (index < first + count) {  // no kernel of this step writes them
    block = load_ranges<kRare>(vertices.blocks + index);
    corner = __ldg(vertices.blocks[index].corners + lane);
  }
  vertices = of_copy(vertices);
  FirstRows<kParts, kDamped> first_rows;
  if constexpr (kTakesFirstRows) {
    first_rows.load(vertices, block, corner, lane, part);
  }
  wait_for_previous();
  if (lane >= block.lane_count) {
    return;
  }
  state = of_copy(state);
  input += copy_index();
  Particle* const particle = &at(state.displacements, corner);
  const Particle p = load_particle(particle);
  if (!(p.w > 0)) {
    return;  // without tissue
  }
  const Vec3<float> u = position_of(p);
  const FixedPoint point = load_point(&at(state.fixed_points, corner));
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  VertexEnergy<float> start;
  const Particle flight = load_particle(&at(state.flights, corner));
  const float relaxation = sweep.relaxation < flight.w ? sweep.relaxation : flight.w;
  start.add_pull(inverse_dt_squared / p.w, position_of(flight) - u);
  if (vertices.guards != nullptr) {
    start.isotropic = start.isotropic + __ldcg(vertices.guards + index * kBlockLanes + lane);
  }
  [[maybe_unused]] Index hold = kInvalidIndex;
  if constexpr (kTools) {
    tools = of_copy(tools, state.capacity);
    hold = __ldcg(vertices.holds + index * kBlockLanes + lane);
    if (sweep.holds_only && hold == kInvalidIndex) {
      return;
    }
  }
  const auto solve = [&](VertexEnergy<float> energy) {
    if constexpr (kTools) {
      if (hold != kInvalidIndex) {
        add_contacts(state, tools.touches, place_at(corner), inverse_dt_squared, energy);
        add_contacts(state, tools.surfaces, place_at(corner), inverse_dt_squared, energy);
        return move_touched<true>(state, tools, input, sweep.substep, corner, hold, u, energy);
      }
    }
    return relaxation * VertexFactor<float>(energy).solve(energy.force);
  };
  const VertexRows rows = rows_of(vertices);
  if (is_lost(point)) {
    block = {};
  }
  const DeviceLane<kDamped> access{state.fixed_points, point, lane};
  VertexEnergy<float> energy{};
  if (part == 0) {
    energy = start;
  }
  VertexBlock others = block;
  if constexpr (kTakesFirstRows) {
    if (!is_lost(point)) {
      if constexpr (kDamped) {
        first_rows.load_numbers(vertices, block, lane, part);
      }
      first_rows.add(access, energy);
      first_rows.leave_out(others);
    }
  }
  add_rows(rows, others, access, energy, {part, kParts});
  add_up<kParts>(energy, mask_of_parts<kParts>());
  if (part > 0) {
    return;
  }
  const Vec3<float> moved = u + move_vertex(rows, block, access, start, energy, solve);
  store_particle(particle, moved, p.w);
  store_point(&at(state.fixed_points, corner), moved_point(point, u, moved));
}

template <bool kRare>
constexpr auto* move_kernel(bool is_damped, bool has_tools) {
  auto* const with_tools = is_damped ? move_blocks<kVertexParts, true, true, kRare>
                                     : move_blocks<kVertexParts, false, true, kRare>;
  auto* const alone = is_damped ? move_blocks<kVertexParts, true, false, kRare>
                                : move_blocks<kVertexParts, false, false, kRare>;
  return has_tools ? with_tools : alone;
}

void solve_vertices(const Stage& stage, const VertexSweep& sweep, const DeviceState& state,
                    const VertexArrays& vertices, const ToolArrays& tools, StepInput* input,
                    const Launch& how) {
  auto* const kernel = vertices.has_rare_rows
                           ? move_kernel<true>(vertices.is_damped, sweep.has_tools)
                           : move_kernel<false>(vertices.is_damped, sweep.has_tools);
  launch(how, "launching a colour of vertices",
         blocks_for(stage.count * kBlockLanes * kVertexParts, kBlockThreads), kBlockThreads, kernel,
         state, vertices, tools, input, stage.first, stage.count, sweep);
}

/// All vertices, by the forces where the substep starts.
/// @tparam kParts  as in move_blocks()
/// @tparam kRare   see load_ranges()
template <int kParts, bool kTools, bool kRare>
__global__ void __launch_bounds__(kBlockThreads)
    push_blocks(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                Index substep) {
  const Index vertex = thread_index() / kParts;
  const Index part = thread_index() % kParts;
  const Index index = vertex / kBlockLanes;
  const Index lane = vertex % kBlockLanes;
  VertexBlock block{};
  ParticleOffset corner = 0;
  if (index < vertices.block_count) {  // no kernel of this step writes them
    block = load_ranges<kRare>(vertices.blocks + index);
    corner = __ldg(vertices.blocks[index].corners + lane);
  }
  vertices = of_copy(vertices);
  wait_for_previous();
  if (lane >= block.lane_count) {
    return;
  }
  state = of_copy(state);
  input += copy_index();
  Particle* const particle = &at(state.displacements, corner);
  const Particle p = load_particle(particle);
  if (!(p.w > 0)) {
    return;  // without tissue
  }
  const FixedPoint point = load_point(&at(state.fixed_points, corner));
  const VertexRows rows = rows_of(vertices);
  if (is_lost(point)) {
    block = {};
  }
  const DeviceLane<false> access{state.fixed_points, point, lane};
  VertexForce<float> sum;
  add_rows(rows, block, access, sum, {part, kParts});
  add_up<kParts>(sum, mask_of_parts<kParts>());
  if (part > 0) {
    return;
  }
  const Vec3<float> force = finite_force(rows, block, access, sum);
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Vec3<float> u = position_of(p);
  const Vec3<float> flight = position_of(load_particle(&at(state.flights, corner)));
  Vec3<float> moved = flight + pushed_flight(force, p.w, inverse_dt_squared);
  if constexpr (kTools) {
    tools = of_copy(tools, state.capacity);
    const Index hold = __ldcg(vertices.holds + index * kBlockLanes + lane);
    if (hold != kInvalidIndex) {
      moved = u + move_touched<false>(state, tools, input, substep, corner, hold, u,
                                      pushed_energy(flight - u, force, inverse_dt_squared / p.w));
    }
  }
  if (is_finite_way(moved)) {
    store_particle(particle, moved, p.w);
  }
}

template <bool kRare>
constexpr auto* push_kernel_by_rows(bool has_tools) {
  return has_tools ? push_blocks<kVertexParts, true, kRare>
                   : push_blocks<kVertexParts, false, kRare>;
}

void push_vertices(const DeviceState& state, const VertexArrays& vertices, const ToolArrays& tools,
                   StepInput* input, Index substep, bool has_tools, const Launch& how) {
  launch(how, "launching explicit vertices",
         blocks_for(vertices.block_count * kBlockLanes * kVertexParts, kBlockThreads),
         kBlockThreads,
         vertices.has_rare_rows ? push_kernel_by_rows<true>(has_tools)
                                : push_kernel_by_rows<false>(has_tools),
         state, vertices, tools, input, substep);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
