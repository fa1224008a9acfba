// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All sweeps of the vertex-block method in one kernel. Warps go through the colours on their own:
/// a vertex waits for the vertices that it hears from and for nothing else, where a launch a colour
/// waits for the whole device. Every fixed point counts how often its vertex has moved, and is one
/// access of 16 bytes, so that who reads the one has read the other.
///
/// A neighbour of an earlier colour has one sweep more to make than the vertex, one of a later
/// colour as many. Neither can make another before the vertex has made its own. So who waits for a
/// neighbour finds what the serial order gives it, and no one waits in a circle: of all that is not
/// done, what comes first in that order waits for nothing. All blocks of the kernel are on the
/// device at once, or those waited for might never come.
///
/// Where nothing comes between substeps, one kernel takes all of a step. To begin a substep is a
/// move like any other, which the vertex makes after its last sweep of the substep before. It goes
/// to the other one of two mailboxes: what it overwrites there is of two substeps before, which its
/// neighbours have read, or they could not have come to where it has just found them. Counts go on
/// from step to step, so that a step begins without a look at all vertices.

#include <cstddef>
#include <cstdint>
#include <initializer_list>

#include "cuda/solver/counted_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tile_kernels.cuh"
#include "cuda/solver/vertex_block_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/device/vertex_tiles.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// As DeviceLane, while the neighbours stand still.
struct WaitingLane {
  const FixedPoint* fixed_points;
  FixedPoint own;
  Index lane;

  [[nodiscard]] __device__ float load(const float* numbers) const { return __ldcg(numbers + lane); }
  [[nodiscard]] __device__ Vec3<float> position(const ParticleOffset* corners) const {
    const FixedPoint point = load_counted(&at(fixed_points, __ldg(corners + lane)));
    return way_between(own, without_count(point));
  }
};

/// What a thread holds in registers while neighbours are on their way.
template <int kParts>
struct TileShape {
  static constexpr Index kTiles = tiles_of_block(kParts);
  static constexpr Index kStride = kTiles * kTileThreads;  ///< records from a row to the next
  static constexpr int kNeighbors = usual_counts(kParts).neighbors;
  static constexpr int kPulls = usual_counts(kParts).pulls;
  static constexpr int kVolumes = usual_counts(kParts).volumes;
};

/// Where a warp goes: some tiles of a colour, then of the next colour, then of the next sweep.
template <int kTiles>
class TileWalk {
 public:
  __device__ TileWalk(const VertexColors& colors, Index sweeps, Index warp, Index warps)
      : colors_(colors), sweeps_(sweeps), warp_(warp), warps_(warps), tile_(warp) {
    find();
  }

  [[nodiscard]] __device__ bool is_done() const { return sweep_ == sweeps_; }
  [[nodiscard]] __device__ Index sweep() const { return sweep_; }
  [[nodiscard]] __device__ Index block() const {
    return colors_.blocks[color_].first + tile_ / kTiles;
  }
  [[nodiscard]] __device__ Index tile() const { return tile_ % kTiles; }

  __device__ void advance() {
    tile_ += warps_;
    find();
  }

 private:
  __device__ void find() {
    while (tile_ >= colors_.blocks[color_].count * kTiles) {
      tile_ = warp_;
      if (++color_ == colors_.count) {
        color_ = 0;
        if (++sweep_ == sweeps_) {
          return;
        }
      }
    }
  }

  const VertexColors& colors_;
  Index sweeps_, warp_, warps_;
  Index sweep_ = 0, color_ = 0, tile_;
};

/// A tile before its turn.
template <int kParts>
struct NextTile {
  int4 firsts;  ///< of TileBlock
  Index more;   ///< likewise
  Neighbor own;
  Neighbor names[TileShape<kParts>::kNeighbors];

  __device__ void load_block(const TileArrays& tiles, Index index) {
    const TileBlock* const block = tiles.blocks + index;
    firsts = __ldg(reinterpret_cast<const int4*>(block));
    more = __ldg(&block->counts.more);
  }
  /// @param thread  of the block
  __device__ void load_names(const TileArrays& tiles, Index thread) {
    const Neighbor* const from = tiles.neighbors + first_record(firsts.x, thread);
    own = __ldg(from);
#pragma unroll
    for (int k = 0; k < TileShape<kParts>::kNeighbors; ++k) {
      names[k] = __ldg(from + (1 + k) * TileShape<kParts>::kStride);
    }
  }
};

/// The count of a neighbour that is due.
/// @param met    that neighbour, late or not
/// @param count  of the vertex
__device__ inline std::uint32_t count_due(Neighbor name, const FixedPoint& met, Index count) {
  return (name & kStandsStill) != 0
             ? __float_as_uint(met.unit)
             : static_cast<std::uint32_t>(count) + static_cast<std::uint32_t>(name & kMovesEarlier);
}

__device__ inline FixedPoint load_neighbor(const FixedPoint* points, Neighbor name) {
  return load_counted(&at(points, name & ~kNeighborFlags));
}

/// Ways from a vertex to its neighbours, in shared memory: the first is zero.
class Ways {
 public:
  __device__ explicit Ways(const float4* ways)
      : start_(static_cast<std::uint32_t>(__cvta_generic_to_shared(ways))) {
    store(0, {});
  }

  __device__ void store(Index position, const Vec3<float>& way) const {
    asm volatile("st.shared.v4.f32 [%0], {%1, %2, %3, %3};"
                 :
                 : "r"(start_ + 16 * static_cast<std::uint32_t>(position)), "f"(way.x), "f"(way.y),
                   "f"(way.z)
                 : "memory");
  }
  [[nodiscard]] __device__ Vec3<float> operator[](std::uint32_t position) const {
    Vec3<float> way;
    [[maybe_unused]] float unused;
    asm volatile("ld.shared.v4.f32 {%0, %1, %2, %3}, [%4];"
                 : "=f"(way.x), "=f"(way.y), "=f"(way.z), "=f"(unused)
                 : "r"(start_ + 16 * position)
                 : "memory");
    return way;
  }

 private:
  std::uint32_t start_;
};

/// Whether a warp is to wait no more, because it or another has waited for too long. What is then
/// in the state is of no use.
__device__ inline bool gives_up(StepInput* input, std::uint32_t looks) {
  constexpr std::uint32_t kBetween = 4096;  // asks about others
  const bool is_long = looks >= input->longest_wait;
  if (__builtin_expect(!is_long && looks % kBetween != kBetween - 1, 1)) {
    return false;
  }
  if (is_long) {
    input->sums.stalled = 1;
  }
  return __any_sync(~0U, is_long || __ldcg(&input->sums.stalled) != 0);
}

/// Waits for neighbours of a warp's vertices, several of a thread, and writes the ways to them.
/// @param count  of the vertex
/// @param first  position of the first, the others' follow kParts apart
template <int kParts, int kCount>
__device__ void wait_for(const FixedPoint* points, const Neighbor (&names)[kCount], Index count,
                         FixedPoint (&met)[kCount], const FixedPoint& own, Index first,
                         const Ways& ways, StepInput* input) {
  const FixedPoint* from[kCount];
  std::uint32_t due[kCount];
#pragma unroll
  for (int k = 0; k < kCount; ++k) {
    from[k] = &at(points, names[k] & ~kNeighborFlags);
    due[k] = count_due(names[k], met[k], count);
  }
  for (std::uint32_t looks = 0;; ++looks) {
    bool is_late[kCount];
    bool is_any_late = false;
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      is_late[k] = is_before(met[k], due[k]);
      is_any_late = is_any_late || is_late[k];
    }
    if (!__any_sync(~0U, is_any_late) || gives_up(input, looks)) {
      break;
    }
#pragma unroll
    for (int k = 0; k < kCount; ++k) {
      reload_counted(met[k], from[k], is_late[k]);  // others would only be in the way
    }
  }
#pragma unroll
  for (int k = 0; k < kCount; ++k) {
    ways.store(first + k * kParts, way_between(own, without_count(met[k])));
  }
}

/// The rows that a thread adds, with all ways asked for before any is needed.
template <int kParts>
struct UsualRows {
  using Shape = TileShape<kParts>;

  PullRecord pulls[Shape::kPulls];
  VolumeRecord volumes[Shape::kVolumes];

  __device__ void load(const PullRecord* first_pull, const VolumeRecord* first_volume) {
#pragma unroll
    for (int k = 0; k < Shape::kPulls; ++k) {
      const int2 words = __ldg(reinterpret_cast<const int2*>(first_pull + k * Shape::kStride));
      pulls[k] = *reinterpret_cast<const PullRecord*>(&words);
    }
#pragma unroll
    for (int k = 0; k < Shape::kVolumes; ++k) {
      volumes[k] = load_constant(first_volume + k * Shape::kStride);
    }
  }

  template <class Energy>
  __device__ void add_pulls(const Ways& ways, Energy& energy) const {
    Vec3<float> to[Shape::kPulls];
#pragma unroll
    for (int k = 0; k < Shape::kPulls; ++k) {
      to[k] = ways[pulls[k].neighbor];
    }
#pragma unroll
    for (int k = 0; k < Shape::kPulls; ++k) {
      energy.add_pull(pulls[k].weight, to[k]);
    }
  }

  template <class Energy>
  __device__ void add_volumes(const Ways& ways, Energy& energy) const {
    Vec3<float> face[Shape::kVolumes][3];
#pragma unroll
    for (int k = 0; k < Shape::kVolumes; ++k) {
      face[k][0] = ways[volumes[k].face & 255];
      face[k][1] = ways[volumes[k].face >> 8 & 255];
      face[k][2] = ways[volumes[k].face >> 16];
    }
#pragma unroll
    for (int k = 0; k < Shape::kVolumes; ++k) {
      energy.add_volume(volumes[k].stiffness, volumes[k].target, face[k][0], face[k][1],
                        face[k][2]);
    }
  }
};

/// What a thread adds of its vertex, once the ways to all neighbours are known.
/// @tparam kRare  see load_ranges()
/// @param index   of the block of vertices
/// @param thread  of that
template <int kParts, bool kRare, class Energy>
__device__ __forceinline__ void add_tile(const UsualRows<kParts>& usual, const TileArrays& tiles,
                                         const NextTile<kParts>& tile, const VertexRows& rows,
                                         Index index, Index thread, const Ways& ways,
                                         const WaitingLane& access, Energy& energy) {
  using Shape = TileShape<kParts>;
  usual.add_pulls(ways, energy);
  if (__builtin_expect(tile.more, 0) != 0) {
    const TileCounts counts = tiles.blocks[index].counts;
    const PullRecord* const first_pull = tiles.pulls + first_record(tile.firsts.y, thread);
#pragma unroll 1
    for (Index k = Shape::kPulls; k < counts.pulls; ++k) {
      const PullRecord record = first_pull[k * Shape::kStride];
      energy.add_pull(record.weight, ways[record.neighbor]);
    }
    const SpringRecord* const first_spring = tiles.springs + first_record(tile.firsts.z, thread);
#pragma unroll 1
    for (Index k = 0; k < counts.springs; ++k) {
      const SpringRecord record = load_constant(first_spring + k * Shape::kStride);
      energy.add_spring(record.stiffness, record.rest, ways[record.neighbor]);
    }
  }
  usual.add_volumes(ways, energy);
  if (__builtin_expect(tile.more, 0) != 0) {
    const TileCounts counts = tiles.blocks[index].counts;
    const VolumeRecord* const first_volume = tiles.volumes + first_record(tile.firsts.w, thread);
#pragma unroll 1
    for (Index k = Shape::kVolumes; k < counts.volumes; ++k) {
      const VolumeRecord record = load_constant(first_volume + k * Shape::kStride);
      energy.add_volume(record.stiffness, record.target, ways[record.face & 255],
                        ways[record.face >> 8 & 255], ways[record.face >> 16]);
    }
    if (counts.others > 0) {
      const VertexBlock ranges = load_ranges<kRare>(rows.blocks + index);
      VertexBlock others{};
      others.is_damped = ranges.is_damped;
      others.has_angles = ranges.has_angles;
      others.hinges = ranges.hinges;
      others.triangles = ranges.triangles;
      others.fibres = ranges.fibres;
      add_rows(rows, others, access, energy, {thread % kParts, kParts});
    }
  }
}

/// Waits for the neighbours that are more than usual, one after another.
template <int kParts>
__device__ __forceinline__ void wait_for_more(const FixedPoint* points, const TileArrays& tiles,
                                              const NextTile<kParts>& tile, Index count,
                                              Index index, Index thread, const FixedPoint& own,
                                              const Ways& ways, StepInput* input) {
  using Shape = TileShape<kParts>;
  if (__builtin_expect(tile.more, 0) == 0) {
    return;
  }
  const Index neighbors = tiles.blocks[index].counts.neighbors;
#pragma unroll 1
  for (Index k = Shape::kNeighbors; k < neighbors; ++k) {
    const Neighbor name[1] = {
        __ldg(tiles.neighbors + first_record(tile.firsts.x, thread) + (1 + k) * Shape::kStride)};
    FixedPoint one[1] = {load_neighbor(points, name[0])};
    wait_for<kParts>(points, name, count, one, own, 1 + thread % kParts + k * kParts, ways, input);
  }
}

/// float4 of shared memory for a vertex, a zero first: odd, so that vertices of a warp use other
/// banks.
__host__ __device__ inline Index ways_room(Index parts, Index most_neighbors) {
  return 1 + parts * most_neighbors;
}

/// A vertex as it began its substep.
struct BegunVertex {
  Particle base;
  Vec3<float> velocity, rounding;
  float falling;

  __device__ void load(const DeviceState& state, ParticleOffset corner) {
    const Index place = place_at(corner);
    base = load_particle(state.particles + place);
    velocity = load_velocity(state.velocities + place);
    const Carry carry = load_carry(state.carries + place);
    rounding = {carry.x, carry.y, carry.z};
    falling = carry.falling;
  }
  __device__ void store(const DeviceState& state, ParticleOffset corner) const {
    const Index place = place_at(corner);
    store_particle(state.particles + place, position_of(base), base.w);
    store_velocity(state.velocities + place, velocity);
    store_carry(state.carries + place, rounding, falling);
  }
  /// @param motion  flying_motion()
  [[nodiscard]] __device__ Vec3<float> flight(const FreeMotion<float>& motion) const {
    return flight_of(motion, rounding, flying_velocity(motion, velocity, base.w));
  }
  /// The displacement before the first sweep.
  /// @param motion  falling_motion()
  [[nodiscard]] __device__ Vec3<float> start(const FreeMotion<float>& motion) const {
    return start_of(motion, flight(motion), base.w, falling);
  }
  /// Goes to the end of the substep.
  /// @param motion  falling_motion()
  /// @param u       m, the displacement
  __device__ void end(const FreeMotion<float>& motion, const Vec3<float>& u) {
    const Settled<float> end = settle(motion, position_of(base), base.w, velocity, rounding, u);
    base = {end.x.x, end.x.y, end.x.z, base.w};
    velocity = end.velocity;
    rounding = end.rounding;
    falling = end.falling;
  }
};

/// What a step does to vertices that no block has: these stop. And what it does to others, in no
/// order, before they wait for each other.
template <class Begin>
__device__ void begin_step(const DeviceState& state, const VertexArrays& vertices,
                           const StepInput& input, const Begin& begin) {
  for (Index i = thread_index(); i < input.vertex_count; i += thread_count()) {
    BegunVertex vertex;
    if (__ldg(vertices.lane_of_place + i) != kInvalidIndex) {
      begin(i, vertex);
      continue;
    }
    vertex.load(state, offset_of(i));
    vertex.base.w = 0;
    for (Index substep = 0; substep < input.substep_count && substep < 2;
         ++substep) {  // then it stays so
      vertex.end(falling_motion(state, input.motion, i), vertex.rounding);
    }
    store_velocity(state.velocities + i, vertex.velocity);
    store_carry(state.carries + i, vertex.rounding, vertex.falling);
  }
}

__device__ inline Mailboxes of_copy(Mailboxes boxes, Index capacity) {
  const std::size_t first = copy_index() * static_cast<std::size_t>(capacity);
  return {{boxes.points[0] + first, boxes.points[1] + first}};
}

/// Where vertices are, with the count that the step goes on from.
__global__ void __launch_bounds__(kVertexThreads)
    fill_points(DeviceState state, Mailboxes boxes, const StepInput* input) {
  const Index i = thread_index();
  if (i >= vertex_count(input)) {
    return;
  }
  state = of_copy(state);
  boxes = of_copy(boxes, state.capacity);
  const Carry carry = load_carry(state.carries + i);
  const FixedPoint point = fixed_point(position_of(load_particle(state.particles + i)),
                                       {carry.x, carry.y, carry.z}, input->unit);
  store_counted(boxes.points[0] + i, point, input->moves_before);
  store_counted(boxes.points[1] + i, point, input->moves_before);
}

void fill_mailboxes(const DeviceState& state, const Mailboxes& boxes, const StepInput* input,
                    const Launch& how) {
  launch(how, "launching where vertices are", blocks_for(state.capacity, kVertexThreads),
         kVertexThreads, fill_points, state, boxes, input);
}

/// All sweeps. Threads of a warp stay together.
/// @tparam kParts  threads of a vertex, a divisor of kRowParts; as many give the serial bits
/// @tparam kRare  see load_ranges()
/// @param boxes    of a step; else state.fixed_points has the points
template <int kParts, Reach kReach, bool kRare>
__global__ void __launch_bounds__(kBlockThreads)
    sweep_tiles(VertexSweeps sweeps, VertexColors colors, DeviceState state, VertexArrays vertices,
                TileArrays tiles, ToolArrays tools, Mailboxes boxes, StepInput* input) {
  constexpr bool kTouches = kReach == Reach::met_substep;
  constexpr bool kGrips = kReach == Reach::gripped_substep || kTouches;
  constexpr bool kTools = kReach == Reach::held_substep || kGrips;
  constexpr bool kStep = kReach == Reach::step;
  using Shape = TileShape<kParts>;
  extern __shared__ float4 all_ways[];
  state = of_copy(state);
  tiles = of_copy(tiles, vertices);
  vertices = of_copy(vertices);
  input += copy_index();
  if constexpr (kTools) {
    tools = of_copy(tools, state.capacity);
  }
  const Index of_warp = static_cast<Index>(threadIdx.x) % kTileThreads;
  const Index part = of_warp % kParts;
  const Ways ways(all_ways + static_cast<Index>(threadIdx.x) / kParts *
                                 ways_room(kParts, tiles.most_neighbors));
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const float unit = input->unit;
  const float inverse_unit = 1 / unit;
  const VertexRows rows = rows_of(vertices);
  FixedPoint* points = state.fixed_points;
  FixedPoint* next_points = nullptr;
  Index all_sweeps = sweeps.end - sweeps.first;
  Index first_sweep = -sweeps.first;  // of the substep
  Index moves_before = sweeps.first;  // those of this kernel
  if constexpr (kStep) {
    boxes = of_copy(boxes, state.capacity);
    points = boxes.points[0];
    next_points = boxes.points[1];
    all_sweeps *= input->substep_count;
    moves_before = input->moves_before + 1;
    begin_step(state, vertices, *input, [&](Index place, BegunVertex& vertex) {
      vertex.load(state, offset_of(place));
      store_counted(points + place,
                    fixed_point(position_of(vertex.base),
                                vertex.start(falling_motion(state, input->motion, place)), unit),
                    moves_before);
    });
  }
  TileWalk<Shape::kTiles> walk(colors, all_sweeps, thread_index() / kTileThreads,
                               thread_count() / kTileThreads);
  if (walk.is_done()) {
    return;
  }
  NextTile<kParts> next;
  next.load_block(tiles, walk.block());
  next.load_names(tiles, walk.tile() * kTileThreads + of_warp);
  do {
    // everything that can be asked for, and all that needs no neighbour
    const NextTile<kParts> tile = next;
    const ParticleOffset corner = tile.own & ~kNeighborFlags;
    FixedPoint met[Shape::kNeighbors];
#pragma unroll
    for (int k = 0; k < Shape::kNeighbors; ++k) {
      met[k] = load_neighbor(points, tile.names[k]);
    }
    const Index count = moves_before + walk.sweep();  // before it moves
    const Index sweep = walk.sweep() - first_sweep;
    const bool ends = sweep + 1 == sweeps.count;
    const bool ends_step = walk.sweep() + 1 == all_sweeps;
    const bool leads = part == 0 && (tile.own & kIsIdle) == 0;
    FixedPoint own;
    Particle p, flight;
    if (kStep && sweep == 0) {  // what it has told, without a look at who told it
      BegunVertex vertex;
      vertex.load(state, corner);
      const FreeMotion<float> motion = falling_motion(state, input->motion, place_at(corner));
      const Vec3<float> start = vertex.start(motion);
      const Vec3<float> free =
          vertex.flight(flying_motion(state, motion, vertex.base.w, place_at(corner)));
      p = {start.x, start.y, start.z, vertex.base.w};
      flight = {free.x, free.y, free.z, kFreely};
      own = fixed_point(position_of(vertex.base), start, unit);
      if (leads && !ends) {
        store_particle(&at(state.flights, corner), position_of(flight), flight.w);
      }
    } else {
      own = without_count(load_counted(&at(points, corner)));
      p = load_particle(&at(state.displacements, corner));
      flight = load_particle(&at(state.flights, corner));
    }
    const Index index = walk.block();
    const Index thread = walk.tile() * kTileThreads + of_warp;
    UsualRows<kParts> usual;
    usual.load(tiles.pulls + first_record(tile.firsts.y, thread),
               tiles.volumes + first_record(tile.firsts.w, thread));
    [[maybe_unused]] Index hold = kInvalidIndex;
    [[maybe_unused]] SharedContacts<kParts, SurfaceArrays> contacts(tools.surfaces, part);
    [[maybe_unused]] SharedContacts<kParts, TouchArrays> touches(tools.touches, part);
    if constexpr (kTools) {
      hold = __ldcg(vertices.holds + index * kBlockLanes + thread / kParts);
      const bool is_held = hold != kInvalidIndex && (tile.own & kIsIdle) == 0;
      contacts.load(is_held ? holds_of(tools.surfaces, place_at(corner)) : HoldRange{});
      if constexpr (kTouches) {
        touches.load(is_held ? holds_of(tools.touches, place_at(corner)) : HoldRange{});
      }
    }
    walk.advance();
    const bool is_last = walk.is_done();
    if (!is_last) {
      next.load_block(tiles, walk.block());
    }
    const Vec3<float> u = position_of(p);
    const bool moves = p.w > 0;
    VertexEnergy<float> start{};
    start.add_pull(moves ? inverse_dt_squared / p.w : 0.0F, position_of(flight) - u);
    VertexEnergy<float> energy{};
    if (part == 0) {
      energy = start;
    }
    float relaxation = ends ? 1.0F : sweeps.over_relaxation;
    relaxation = relaxation < flight.w ? relaxation : flight.w;
    const FixedPoint base = without_move(own, u, inverse_unit);

    wait_for<kParts>(points, tile.names, count, met, own, 1 + part, ways, input);
    wait_for_more<kParts>(points, tiles, tile, count, index, thread, own, ways, input);
    if constexpr (kTools) {
      if (hold != kInvalidIndex) {
        __threadfence();  // other corners of contacts are neighbours: they are where they said
      }
    }
    __syncwarp();
    const Index lane = thread / kParts;
    const WaitingLane access{points, own, lane};
    add_tile<kParts, kRare>(usual, tiles, tile, rows, index, thread, ways, access, energy);
    if (!is_last) {
      next.load_names(tiles, walk.tile() * kTileThreads + of_warp);
    }
    add_up<kParts>(energy, ~0U);
    if (is_lost(own)) {
      energy = start;
    }

    const auto solve = [&](const VertexEnergy<float>& whole) {
      if constexpr (kTools) {
        if (hold != kInvalidIndex) {
          return move_touched<kGrips>(state, tools, input, sweeps.substep, corner, hold, u, whole);
        }
      }
      return relaxation * VertexFactor<float>(whole).solve(whole.force);
    };
    VertexEnergy<float> whole = energy;
    if constexpr (kTouches) {
      touches.add(state, inverse_dt_squared, whole);
    }
    if constexpr (kTools) {
      contacts.add(state, inverse_dt_squared, whole);
    }
    if (leads) {
      Vec3<float> move = solve(whole);
      if (__builtin_expect(!is_finite_way(move) || !is_finite_way(energy.force), 0)) {
        const VertexBlock block =
            is_lost(own) ? VertexBlock{} : load_ranges<kRare>(vertices.blocks + index);
        move = move_vertex(rows, block, access, start, energy, [&](VertexEnergy<float> finite) {
          if constexpr (kTouches) {
            add_contacts(state, tools.touches, place_at(corner), inverse_dt_squared, finite);
          }
          if constexpr (kTools) {
            add_contacts(state, tools.surfaces, place_at(corner), inverse_dt_squared, finite);
          }
          return solve(finite);
        });
      }
      const Vec3<float> moved = moves ? u + move : u;
      if constexpr (kTools) {
        if (hold != kInvalidIndex && (kGrips || tools.surfaces.holds_at != nullptr)) {
          store_particle(&at(state.displacements, corner), moved, p.w);
          __threadfence();  // before its point says so
        }
      }
      store_counted(&at(points, corner), moves ? with_move(base, moved, inverse_unit) : own,
                    count + 1);
      if (kStep && ends) {
        BegunVertex vertex;
        vertex.load(state, corner);
        const FreeMotion<float> motion = falling_motion(state, input->motion, place_at(corner));
        vertex.end(motion, moved);
        vertex.store(state, corner);
        if (!ends_step) {
          store_counted(&at(next_points, corner),
                        fixed_point(position_of(vertex.base), vertex.start(motion), unit),
                        count + 2);
        }
      } else {
        store_particle(&at(state.displacements, corner), moved, p.w);
      }
    }
    if (kStep && walk.sweep() == first_sweep + sweeps.count) {
      FixedPoint* const last_points = points;
      points = next_points;
      next_points = last_points;
      first_sweep += sweeps.count;
      ++moves_before;
    }
    __syncwarp();
  } while (!walk.is_done());
}

template <bool kRare, int kParts>
constexpr auto* sweep_kernel(Reach reach) {
  return reach == Reach::step              ? sweep_tiles<kParts, Reach::step, kRare>
         : reach == Reach::gripped_substep ? sweep_tiles<kParts, Reach::gripped_substep, kRare>
         : reach == Reach::met_substep     ? sweep_tiles<kParts, Reach::met_substep, kRare>
         : reach == Reach::held_substep    ? sweep_tiles<kParts, Reach::held_substep, kRare>
                                           : sweep_tiles<kParts, Reach::substep, kRare>;
}

template <bool kRare>
constexpr auto* sweep_kernel(Index parts, Reach reach) {
  return parts == 16  ? sweep_kernel<kRare, 16>(reach)
         : parts == 8 ? sweep_kernel<kRare, 8>(reach)
                      : sweep_kernel<kRare, 4>(reach);
}

auto* sweep_kernel(const TileArrays& tiles, Reach reach) {
  return tiles.has_rare_rows ? sweep_kernel<true>(tiles.parts, reach)
                             : sweep_kernel<false>(tiles.parts, reach);
}

std::size_t shared_bytes(const TileArrays& tiles) {
  return static_cast<std::size_t>(kBlockThreads / tiles.parts *
                                  ways_room(tiles.parts, tiles.most_neighbors)) *
         sizeof(float4);
}

/// Makes kernels over tiles ready.
/// @return  how many blocks of any of them the device runs at a time; 0 if it cannot
template <class... Arguments>
Index blocks_at_once(const TileArrays& tiles,
                     std::initializer_list<void (*)(Arguments...)> kernels) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  const int room = device_attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  if (device_attribute(cudaDevAttrCooperativeLaunch) == 0 || code_architecture() < 70 ||
      shared_bytes(tiles) > static_cast<std::size_t>(room)) {
    return 0;
  }
  int fewest = 0;
  for (auto* const kernel : kernels) {
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, room),
          "asking for all shared memory of a block");
    int blocks = 0;
    check(cudaOccupancyMaxActiveBlocksPerMultiprocessor(&blocks, kernel, kBlockThreads,
                                                        shared_bytes(tiles)),
          "asking how many blocks a multiprocessor runs at a time");
    fewest = fewest == 0 || blocks < fewest ? blocks : fewest;
  }
  return fewest * device_attribute(cudaDevAttrMultiProcessorCount);
#else
  static_cast<void>(tiles);
  static_cast<void>(kernels);
  return 0;
#endif
}

/// Launches so many blocks of such a kernel for each copy, all of which are on the device at once.
template <class... Parameters, class... Arguments>
void launch_at_once(const Launch& how, const char* name, Index blocks, const TileArrays& tiles,
                    void (*kernel)(Parameters...), const Arguments&... arguments) {
  cudaLaunchAttribute cooperative{};
  cooperative.id = cudaLaunchAttributeCooperative;
  cooperative.val.cooperative = 1;
  cudaLaunchConfig_t config{};
  config.gridDim = dim3(static_cast<unsigned>(blocks), static_cast<unsigned>(how.copies));
  config.blockDim = dim3(kBlockThreads);
  config.dynamicSmemBytes = shared_bytes(tiles);
  config.stream = how.stream;
  config.attrs = &cooperative;
  config.numAttrs = 1;
  check(cudaLaunchKernelEx(&config, kernel, arguments...), name);
}

Index prepare_sweep_of_vertices(const TileArrays& tiles) {
  return blocks_at_once(
      tiles, {sweep_kernel(tiles, Reach::substep), sweep_kernel(tiles, Reach::held_substep),
              sweep_kernel(tiles, Reach::gripped_substep), sweep_kernel(tiles, Reach::met_substep),
              sweep_kernel(tiles, Reach::step)});
}

void sweep_vertices(const VertexSweeps& sweeps, const VertexColors& colors,
                    const DeviceState& state, const VertexArrays& vertices, const TileArrays& tiles,
                    const ToolArrays& tools, const Mailboxes& boxes, StepInput* input,
                    const Launch& how) {
  launch_at_once(how, "launching the sweeps of vertices", sweeps.block_count, tiles,
                 sweep_kernel(tiles, sweeps.reach), sweeps, colors, state, vertices, tiles, tools,
                 boxes, input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
