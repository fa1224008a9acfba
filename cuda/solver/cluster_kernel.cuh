// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All sweeps of a substep by one cluster of blocks, which holds the vertices in its shared memory.
/// See ClusterSchedule for the idea and cuda/README.md for what it costs.
///
/// In a block, one warp fetches the words of rounds to come; the others project, one constraint a
/// thread, and meet after each round.

#include <iterator>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/fibre.h"
#include "pbdsurg/constraints/membrane.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"

#include "cuda/solver/cluster_memory.cuh"
#include "cuda/solver/grip_points.cuh"
#include "cuda/solver/grip_projection.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/surface_projection_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/touch_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/device/cluster_layout.h"
#include "lib/device/cluster_shapes.h"
#include "lib/solver/methods/displacement.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

#if defined(PBDSURG_CUDA_HAS_CLUSTERS)

constexpr int kRoundBarrier = 1;    // of all threads
constexpr int kProjectBarrier = 2;  // of those that project

static_assert(
    std::size(kClusterShapes) == 8,
    "each kind has a case in sweep_by_cluster(), but stiff links, of vertex blocks alone");

/// A block's shared memory, by addresses.
struct ClusterMemory {
  std::uint32_t slots, bases, carries, stages, corners, rounds, arrived, fetched, surfaces;
  std::uint32_t stage_bytes;
  std::uint32_t corner_room;
  CrewBoard* board;
};

/// Bytes that the launch gave to a block.
__device__ inline std::uint32_t dynamic_shared_bytes() {
  std::uint32_t bytes;
  asm("mov.u32 %0, %%dynamic_smem_size;" : "=r"(bytes));
  return bytes;
}

/// A round of this thread's block, unpacked as it is needed.
struct Round {
  uint4 raw;

  __device__ std::uint32_t first() const { return raw.x; }
  __device__ std::uint32_t first_multiplier() const { return raw.y; }
  __device__ std::uint32_t count() const { return raw.z & 0xffff; }
  __device__ std::uint32_t border() const { return raw.z >> 16; }
  __device__ std::uint32_t phase() const { return raw.w & 0xffff; }
  __device__ PhaseKind kind() const { return static_cast<PhaseKind>((raw.w >> 16) & 0xff); }
  __device__ std::uint32_t words() const { return raw.w >> 24; }
  __device__ std::uint32_t bytes() const { return 16 * (count() * words() + border()); }
};

__device__ inline float4 load_slot(std::uint32_t address) {
  const uint4 v = load_shared(address);
  return make_float4(__uint_as_float(v.x), __uint_as_float(v.y), __uint_as_float(v.z),
                     __uint_as_float(v.w));
}

__device__ inline std::uint32_t half(const uint4& head, int corner) {
  const std::uint32_t pair = corner < 2 ? head.x : head.y;
  return corner % 2 == 0 ? pair & 0xffff : pair >> 16;
}

__device__ inline bool leaves(const uint4& head, int corner) {
  return (half(head, corner) & kLeaves) != 0;
}

__device__ inline std::uint32_t part(const uint4& word, int i) {
  return i == 0 ? word.x : i == 1 ? word.y : i == 2 ? word.z : word.w;
}

/// Words of a constraint, without targets: as ClusterRound has it.
template <class Constraint, bool kDamped>
constexpr std::uint32_t kWordsOf = Constraint::kParameterCount > 3
                                       ? (Constraint::kParameterCount + 5) / 4
                                   : Constraint::kVertexCount == 4 && kDamped ? 2
                                                                              : 1;

static_assert(kWordsOf<MembraneConstraint, false> == shape_of(PhaseKind::membrane)->words(false) &&
              kWordsOf<MembraneConstraint, true> == shape_of(PhaseKind::membrane)->words(true));
static_assert(kWordsOf<FibreConstraint, false> == shape_of(PhaseKind::fibre)->words(false) &&
              kWordsOf<FibreConstraint, true> == shape_of(PhaseKind::fibre)->words(true));

/// The parameters of a constraint: two are in its head, the others in further words.
template <class Constraint, bool kDamped>
__device__ void unpack_parameters(const uint4& head, std::uint32_t words, std::uint32_t stride,
                                  float (&parameters)[Constraint::kParameterCount]) {
  constexpr int kCount = Constraint::kParameterCount;
  parameters[0] = __uint_as_float(head.z);
  if constexpr (kCount > 1) {
    parameters[1] = __uint_as_float(head.w);
  }
  if constexpr (Constraint::kVertexCount == 2 && kCount > 2) {
    parameters[2] = __uint_as_float(head.y);
  } else if constexpr (kCount > 3 || (kCount > 2 && kDamped)) {
#pragma unroll
    for (int p = 2; p < kCount; p += 4) {
      const uint4 word = load_shared(words + (p + 2) / 4 * stride);
#pragma unroll
      for (int i = 0; i < 4 && p + i < kCount; ++i) {
        parameters[p + i] = __uint_as_float(part(word, i));
      }
    }
  } else if constexpr (kCount > 2) {
    parameters[2] = 0;
  }
}

/// What a thread needs to project its constraint of a round.
struct RoundWork {
  uint4 head;            ///< its first word
  std::uint32_t words;   ///< where it lies
  std::uint32_t stride;  ///< bytes between words
  bool is_active;        ///< whether there is a constraint for this thread
  bool is_border;        ///< whether this thread's warp has vertices from or for other blocks
  float* multipliers;    ///< of this constraint
  std::uint32_t multiplier_stride;
  bool takes_multipliers;
  bool leaves_multipliers;
};

/// @param load_next  called while the vertices are on their way from shared memory
template <class Constraint, ProjectionMode kMode, bool kDamped, class LoadNext>
__device__ void project_round(const ClusterMemory& memory, const RoundWork& work,
                              const Substep<float>& substep, LoadNext load_next) {
  constexpr int kVertices = Constraint::kVertexCount;
  constexpr bool kDisplaces = kMode == ProjectionMode::compliance;
  constexpr bool kKeeps = kRemembers<Constraint, kMode>;
  Vec3<float> moving[kVertices];
  float w[kVertices];
  std::uint32_t slots[kVertices];
#pragma unroll
  for (int k = 0; k < kVertices; ++k) {
    slots[k] = 16 * (half(work.head, k) & kSlotMask);
  }
  if (work.is_active) {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      const float4 p = load_slot(memory.slots + slots[k]);
      moving[k] = {p.x, p.y, p.z};
      w[k] = p.w;
    }
  }
  load_next();
  uint4 targets{};
  if (work.is_border) {
    targets = load_shared(work.words + work.stride * kWordsOf<Constraint, kDamped>);
  }
  if (!work.is_active) {
    return;
  }
  if (work.head.z != kRemovedConstraint) {
    float parameters[Constraint::kParameterCount];
    unpack_parameters<Constraint, kDamped>(work.head, work.words, work.stride, parameters);
    float multipliers[Constraint::kMultiplierCount] = {};
    if (kKeeps && work.takes_multipliers) {
#pragma unroll
      for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
        multipliers[m] = work.multipliers[m * work.multiplier_stride];
      }
    }
    const auto load_all = [&](std::uint32_t array, Vec3<float>(&vectors)[kVertices]) {
#pragma unroll
      for (int k = 0; k < kVertices; ++k) {
        const float4 v = load_slot(array + slots[k]);
        vectors[k] = {v.x, v.y, v.z};
      }
    };
    Vec3<float> bases[kVertices];
    Vec3<float> seen[kVertices];
    if constexpr (kDisplaces) {
      load_all(memory.bases, bases);
      see_corners(bases, moving, seen);
    } else {
#pragma unroll
      for (int k = 0; k < kVertices; ++k) {
        seen[k] = moving[k];
      }
    }
    Moves<float, kVertices> moves;
    if constexpr (kDamped && kKeeps) {
      Vec3<float> roundings[kVertices];
      load_all(memory.carries, roundings);
      Damped<float, kVertices> damping;
      see_corners(bases, roundings, damping.start);
      moves = Constraint::template move<kMode>(seen, w, parameters, substep, multipliers, damping);
    } else {
      moves = Constraint::template move<kMode>(seen, w, parameters, substep, multipliers);
    }
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      moving[k] = moving[k] + moves.of[k];
    }
    if (kKeeps && work.leaves_multipliers) {
#pragma unroll
      for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
        work.multipliers[m * work.multiplier_stride] = multipliers[m];
      }
    }
  }
#pragma unroll
  for (int k = 0; k < kVertices; ++k) {
    if (!leaves(work.head, k)) {
      store_shared(memory.slots + slots[k],
                   make_float4(moving[k].x, moving[k].y, moving[k].z, w[k]));
    }
  }
  if (work.is_border) {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      const std::uint32_t target = part(targets, k);
      const bool goes = leaves(work.head, k);
      const std::uint32_t block = goes ? target >> 28 : 0;  // else it is what lies there
      const std::uint32_t phase = (target >> 16) & 0xfff;
      const std::uint32_t slot = target & 0xffff;
      send_if(goes, address_in(block, memory.slots + 16 * slot),
              make_float4(moving[k].x, moving[k].y, moving[k].z, w[k]),
              address_in(block, memory.arrived + 8 * phase));
    }
  }
}

/// The warp that fetches: one of its threads. A round's words are asked for three rounds ahead,
/// and the next round does not begin before those of the one after it are there.
__device__ inline void fetch_rounds(const ClusterArrays& cluster, const ClusterMemory& memory,
                                    std::uint32_t round_count, std::uint32_t total, int threads) {
  const bool is_fetcher = threadIdx.x % kWarp == 0;
  std::uint32_t next = 0;
  Round round{load_shared(memory.rounds)};
  const auto ask = [&](std::uint32_t stage) {
    const std::uint32_t barrier = memory.fetched + 8 * stage;
    const std::uint32_t bytes = round.bytes();
    arm(barrier, bytes);
    if (bytes > 0) {
      fetch(memory.stages + stage * memory.stage_bytes, cluster.words + round.first(), bytes,
            barrier);
    }
    next = next + 1 == round_count ? 0 : next + 1;
    round.raw = load_shared(memory.rounds + 16 * next);
  };
  std::uint32_t waited = 0;  // round whose words are there
  const auto await = [&] {
    wait_for(memory.fetched + 8 * (waited % kClusterStages), waited / kClusterStages % 2);
    ++waited;
  };
  if (is_fetcher) {
    for (std::uint32_t stage = 0; stage + 1 < kClusterStages; ++stage) {
      ask(stage);
    }
    await();
    await();
  }
  meet(kRoundBarrier, threads);
  for (std::uint32_t i = 0; i < total; ++i) {
    if (is_fetcher) {
      ask((i + kClusterStages - 1) % kClusterStages);
      await();
    }
    meet(kRoundBarrier, threads);
  }
  if (is_fetcher) {  // nothing may come after the block has left
    while (waited < total + kClusterStages - 1) {
      await();
    }
  }
}

/// Lists the vertices at home here that tools hold or touch.
template <int kThreads>
__device__ void list_tool_vertices(const ClusterArrays& cluster, const ToolArrays& tools,
                                   StepInput* input, const ClusterSweep& sweep, const Index* places,
                                   std::uint32_t home_count, std::uint32_t block,
                                   std::uint32_t* counts, uint2* held, std::uint32_t* touched) {
  // Their order does not matter: each is one thread's, in all sweeps.
  if (sweep.has_attachments) {
    const HeldInput* const inputs = table<HeldInput>(input, input->held);
    for (Index i = static_cast<Index>(threadIdx.x); i < input->held_count; i += kThreads) {
      const std::uint32_t home = __ldg(cluster.homes + inputs[i].place);
      if (home >> 16 == block) {
        held[atomicAdd(counts, 1)] = make_uint2(home & 0xffff, static_cast<std::uint32_t>(i));
      }
    }
  }
  if (sweep.has_pushers) {
    for (std::uint32_t slot = threadIdx.x; slot < home_count; slot += kThreads) {
      const Index place = __ldg(places + slot);
      bool is_touched = false;
      for (Index pusher = 0; pusher < input->pusher_count; ++pusher) {
        is_touched |= touches(tools, pusher, place);
      }
      if (is_touched) {
        touched[atomicAdd(counts + 1, 1)] = slot;
      }
    }
  }
}

/// Corners of contacts in the shared memory of the blocks where they are at home.
class ClusterCorners {
 public:
  /// Nor may a block ask for what it does not wait for: others may have left meanwhile.
  static constexpr bool kAreNear = false;

  __device__ ClusterCorners(const ClusterArrays& cluster, const ClusterMemory& memory)
      : homes_(cluster.homes), slots_(memory.slots) {}

  [[nodiscard]] __device__ std::uint32_t home(Index place) const {
    const std::uint32_t home = __ldg(homes_ + place);
    return address_in(home >> 16, slots_ + 16 * (home & 0xffff));
  }
  [[nodiscard]] __device__ Particle load(Index place, Index /*root*/) const {
    const float4 p = load_there(home(place));
    return {p.x, p.y, p.z, p.w};
  }
  __device__ void store_if(bool moves, Index place, Index /*root*/, const Particle& p) const {
    if (moves) {
      store_there(home(place), make_float4(p.x, p.y, p.z, p.w));
    }
  }

 private:
  const std::uint32_t* homes_;
  std::uint32_t slots_;
};

/// Those near at hand in this block, each at its root.
class StagedClusterCorners {
 public:
  static constexpr bool kAreNear = true;

  __device__ explicit StagedClusterCorners(const ClusterMemory& memory)
      : stage_(memory.corners), room_(memory.corner_room) {}

  [[nodiscard]] __device__ bool have_room(Index holds) const {
    return static_cast<std::uint32_t>(holds) <= room_;
  }
  [[nodiscard]] __device__ std::uint32_t staged(Index root) const {
    return stage_ + 16 * static_cast<std::uint32_t>(root);
  }
  [[nodiscard]] __device__ Particle load(Index /*place*/, Index root) const {
    const float4 p = load_slot(staged(root));
    return {p.x, p.y, p.z, p.w};
  }
  __device__ void store_if(bool moves, Index /*place*/, Index root, const Particle& p) const {
    store_shared_if(moves, staged(root), make_float4(p.x, p.y, p.z, p.w));
  }

 private:
  std::uint32_t stage_, room_;
};

/// After a sweep, what one block does for all, the first, while others wait.
/// @param parity  of how often this was done
template <class Work>
__device__ __forceinline__ void do_in_one_block(const ClusterArrays& cluster,
                                                const ClusterMemory& memory, std::uint32_t parity,
                                                const Work& work) {
  const std::uint32_t are_home = memory.surfaces, have_moved = memory.surfaces + 8;
  if (threadIdx.x == 0) {
    arrive(address_in(0, are_home));
  }
  if (block_of_cluster() == 0) {
    work([&] { wait_for_cluster(are_home, parity); });
    if (threadIdx.x < cluster.block_count) {
      arrive(address_in(threadIdx.x, have_moved));
    }
  }
  wait_for_cluster(have_moved, parity);
}

/// What contacts with surfaces or between bodies do.
/// @tparam Arrays    and Moving: see contact_projection.cuh
/// @tparam kCorners  of a contact
/// @param  count     of contacts
/// @param  await     () until all vertices are at home
template <int kThreads, class Arrays, class Moving, int kCorners, class Await>
__device__ __forceinline__ void project_contacts_of_cluster(const ClusterArrays& cluster,
                                                            const ClusterMemory& memory,
                                                            const Arrays& arrays, Index count,
                                                            const Await& await) {
  const ClusterCorners corners(cluster, memory);
  const StagedClusterCorners staged(memory);
  const bool are_staged = staged.have_room(kCorners * count);
  const auto for_each_staged = [&](const auto& visit) {
    if (are_staged) {
      for_each_corner(arrays, kCorners * count, kThreads, visit);
    }
  };
  const Index levels = __ldcg(arrays.level_counts);
  OwnContacts<Arrays, Moving> own(arrays, count, kThreads);
  await();
  for_each_staged([&](Index place, Index root) {
    store_shared(staged.staged(root), load_there(corners.home(place)));
  });
  const auto meet_all = [] { meet(kProjectBarrier, kThreads); };
  meet_all();
  ContactCrew crew(count, *memory.board, meet_all);
  const auto project_from = [&](const auto& from) {
    own.begin(from);
    crew.wait();
    project(crew, own, from, levels);
    own.end();
  };
  if (crew.has_this_thread()) {
    if (are_staged) {
      project_from(staged);
    } else {
      project_from(corners);
    }
  }
  meet_all();
  for_each_staged([&](Index place, Index root) {
    store_there(corners.home(place), load_slot(staged.staged(root)));
  });
  meet_all();
}

/// The same, not among the instructions of sweeps.
template <int kThreads, class Arrays, class Moving, int kCorners>
__device__ __noinline__ void project_contacts_apart(const ClusterArrays& cluster,
                                                    const ClusterMemory& memory,
                                                    const Arrays& arrays, Index count,
                                                    std::uint32_t parity) {
  do_in_one_block(cluster, memory, parity, [&](const auto& await) {
    project_contacts_of_cluster<kThreads, Arrays, Moving, kCorners>(cluster, memory, arrays, count,
                                                                    await);
  });
}

/// What jaws do that hold with a limit: likewise.
template <int kThreads>
__device__ __noinline__ void project_grips_apart(const ClusterArrays& cluster,
                                                 const ClusterMemory& memory,
                                                 const DeviceState& state, StepInput* input,
                                                 Index substep, std::uint32_t parity) {
  do_in_one_block(cluster, memory, parity, [&](const auto& await) {
    const ClusterCorners corners(cluster, memory);
    const StagedClusterCorners staged(memory);
    const auto meet_all = [] { meet(kProjectBarrier, kThreads); };
    await();
    for (Index g = 0; g < input->grip_count; ++g) {
      const GripTables tables(input, substep, g);
      const bool are_staged = staged.have_room(tables.grip.corner_count);
      const auto for_each_staged = [&](const auto& visit) {
        for (Index c = static_cast<Index>(threadIdx.x); are_staged && c < tables.grip.corner_count;
             c += kThreads) {
          visit(staged.staged(c), corners.home(tables.corners[c].place));
        }
      };
      for_each_staged(
          [](std::uint32_t here, std::uint32_t home) { store_shared(here, load_there(home)); });
      meet_all();
      if (threadIdx.x < kWarp) {
        if (are_staged) {
          GripProjection(state, input, tables, staged).run();
        } else {
          GripProjection(state, input, tables, corners).run();
        }
      }
      meet_all();
      for_each_staged(
          [](std::uint32_t here, std::uint32_t home) { store_there(home, load_slot(here)); });
      meet_all();
    }
  });
}

/// @param kThreads      that project; one warp more fetches
/// @param kExtraPhases  whether it has code for bodies that meet each other, and jaws that hold
/// with
///                      a limit
template <ProjectionMode kMode, bool kDamped, ClusterTissue kTissue, int kThreads,
          bool kExtraPhases>
__global__ void __launch_bounds__(kThreads + kWarp, 1)
    sweep_by_cluster(ClusterArrays cluster, DeviceState state, ToolArrays tools, StepInput* input,
                     ClusterSweep sweep) {
  state = of_copy(state);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  cluster.multipliers += copy_index() * cluster.multiplier_count;
  extern __shared__ float4 shared[];
  constexpr int kAll = kThreads + kWarp;
  constexpr bool kDisplaces = kMode == ProjectionMode::compliance;
  const ClusterLayout layout(cluster, kDisplaces, kDamped);
  const std::uint32_t start = shared_address(shared);
  char* const bytes = reinterpret_cast<char*>(shared);
  const ClusterMemory memory{start + layout.slots,
                             start + layout.bases,
                             start + layout.carries,
                             start + layout.stages,
                             start + layout.corners,
                             start + layout.rounds,
                             start + layout.arrived,
                             start + layout.fetched,
                             start + layout.surfaces,
                             cluster.stage_bytes,
                             (dynamic_shared_bytes() - layout.corners) / 16,
                             reinterpret_cast<CrewBoard*>(bytes + layout.board)};
  const std::uint32_t rank = block_of_cluster();
  const std::uint32_t thread = threadIdx.x;
  const ClusterBlock block = cluster.blocks[rank];
  const std::uint32_t* const arrivals = cluster.arrivals + rank * (cluster.phase_count + 1);
  const Index* const places = cluster.places + block.first_place;
  {  // what edits change was written before the step's first kernel began
    auto* const rounds = reinterpret_cast<uint4*>(bytes + layout.rounds);
    const auto* const from = reinterpret_cast<const uint4*>(cluster.rounds + block.first_round);
    for (std::uint32_t i = thread; i <= block.round_count; i += kAll) {
      rounds[i] = __ldg(from + (i == block.round_count ? 0 : i));
    }
    auto* const kept_arrivals = reinterpret_cast<std::uint32_t*>(bytes + layout.arrivals);
    for (std::uint32_t phase = thread; phase <= cluster.phase_count; phase += kAll) {
      kept_arrivals[phase] = __ldg(arrivals + phase);
      make_barrier(memory.arrived + 8 * phase);
    }
    if (thread < kClusterStages) {
      make_barrier(memory.fetched + 8 * thread);
    }
    if (thread == 0) {
      make_barrier(memory.surfaces, cluster.block_count);
      make_barrier(memory.surfaces + 8);
    }
    publish_barriers();
  }
  wait_for_previous();
  const auto bring = [&](const auto* quads, std::uint32_t array, std::uint32_t count) {
    auto* const here = reinterpret_cast<float4*>(bytes + array);
    for (std::uint32_t slot = thread; slot < count; slot += kAll) {
      here[slot] = __ldcg(reinterpret_cast<const float4*>(quads + __ldg(places + slot)));
    }
  };
  bring(moving_of(state), layout.slots, block.home_count);
  if constexpr (kDisplaces) {
    bring(state.particles, layout.bases, block.slot_count);
  }
  if constexpr (kDamped) {
    bring(state.carries, layout.carries, block.slot_count);
  }
  auto* const tool_counts = reinterpret_cast<std::uint32_t*>(bytes + layout.tool_counts);
  if (thread < 2) {
    tool_counts[thread] = 0;
  }
  __syncthreads();  // tools that look for races know no meetings of clusters
  meet_cluster();

  if (thread >= kThreads) {
    fetch_rounds(cluster, memory, block.round_count,
                 block.round_count * static_cast<std::uint32_t>(sweep.sweep_count), kAll);
    return;
  }
  auto* const held = reinterpret_cast<uint2*>(bytes + layout.held);
  auto* const touched = reinterpret_cast<std::uint32_t*>(bytes + layout.touched);
  const bool has_tools = sweep.has_attachments || sweep.has_pushers;
  if (has_tools) {
    list_tool_vertices<kThreads>(cluster, tools, input, sweep, places, block.home_count, rank,
                                 tool_counts, held, touched);
  }
  const Index contacts = sweep.has_meeters ? contact_count(tools.surfaces) : 0;
  [[maybe_unused]] const Index body_contacts =
      kExtraPhases && sweep.has_touches ? contact_count(tools.touches) : 0;
  [[maybe_unused]] std::uint32_t contact_phases = 0;
  const Substep<float> substep = input->substep;
  const std::uint32_t warp = thread / kWarp * kWarp;  // its first thread
  const std::uint32_t stages_end = memory.stages + kClusterStages * memory.stage_bytes;
  meet(kRoundBarrier, kAll);

  Round round{load_shared(memory.rounds)};
  std::uint32_t stage = memory.stages;
  uint4 head = load_shared(stage + 16 * thread);
  for (Index s = 0; s < sweep.sweep_count; ++s) {
    const std::uint32_t parity = static_cast<std::uint32_t>(s) % 2;
    for (std::uint32_t phase = thread; phase <= cluster.phase_count; phase += kThreads) {
      arm(memory.arrived + 8 * phase,
          reinterpret_cast<const std::uint32_t*>(bytes + layout.arrivals)[phase]);
    }
    const std::uint32_t rounds_end = memory.rounds + 16 * (block.round_count + 1);
    for (std::uint32_t next = memory.rounds + 16; next != rounds_end; next += 16) {
      const std::uint32_t next_stage =
          stage + memory.stage_bytes == stages_end ? memory.stages : stage + memory.stage_bytes;
      uint4 next_head{};
      Round next_round{};
      const std::uint32_t count = round.count();
      if (warp < count) {
        const bool is_border = warp < round.border();
        if (is_border) {
          wait_for(memory.arrived + 8 * round.phase(), parity);
        }
        const bool is_active = thread < count;
        const bool is_first = s == 0;
        const bool is_last = s + 1 == sweep.sweep_count;
        const RoundWork work{
            head,      stage + 16 * thread, 16 * count,
            is_active, is_border,           cluster.multipliers + round.first_multiplier() + thread,
            count,     !is_first,           !is_last};
        const auto load_next = [&] {
          next_round.raw = load_shared(next);
          next_head = load_shared(next_stage + 16 * thread);
        };
        const auto limit_strain = [&] {
          project_round<StrainLimitConstraint, kMode, kDamped>(memory, work, substep, load_next);
        };
        // No switch: it would test each round for the kinds that this kernel leaves out, too.
        const PhaseKind kind = round.kind();
        if (kind == PhaseKind::distance) {
          project_round<DistanceConstraint, kMode, kDamped>(memory, work, substep, load_next);
        } else if (kind == PhaseKind::volume) {
          project_round<VolumeConstraint, kMode, kDamped>(memory, work, substep, load_next);
        } else if constexpr (kTissue != ClusterTissue::springs) {
          if (kind == PhaseKind::neo_hookean) {
            project_round<NeoHookeanConstraint, kMode, kDamped>(memory, work, substep, load_next);
          } else if (kind == PhaseKind::bending) {
            project_round<BendingConstraint, kMode, kDamped>(memory, work, substep, load_next);
          } else if (kTissue == ClusterTissue::all && kind == PhaseKind::membrane) {
            project_round<MembraneConstraint, kMode, kDamped>(memory, work, substep, load_next);
          } else if (kTissue == ClusterTissue::all && kind == PhaseKind::fibre) {
            project_round<FibreConstraint, kMode, kDamped>(memory, work, substep, load_next);
          } else {
            limit_strain();
          }
        } else {
          limit_strain();
        }
      } else {
        next_round.raw = load_shared(next);
        if (warp < next_round.count()) {
          next_head = load_shared(next_stage + 16 * thread);
        }
      }
      meet(kRoundBarrier, kAll);
      round = next_round;
      head = next_head;
      stage = next_stage;
    }
    wait_for(memory.arrived + 8 * cluster.phase_count, parity);  // all are at home
    // Where nothing has to come, a barrier completes as soon as it is armed again, and whoever
    // still waited for the time before would wait for ever.
    meet(kProjectBarrier, kThreads);
    if constexpr (kExtraPhases) {
      if (body_contacts > 0) {  // before tools, so that nothing stays in those
        project_contacts_apart<kThreads, TouchArrays, MovingTouch, TissueTouch::kCorners>(
            cluster, memory, tools.touches, body_contacts, contact_phases++ % 2);
      }
      if (sweep.has_grips) {
        project_grips_apart<kThreads>(cluster, memory, state, input, sweep.substep,
                                      contact_phases++ % 2);
      }
    }
    if (has_tools) {
      const auto base_at = [&](std::uint32_t slot) {
        Vec3<float> base{};
        if constexpr (kDisplaces) {
          const float4 v = load_slot(memory.bases + 16 * slot);
          base = {v.x, v.y, v.z};
        }
        return base;
      };
      for (std::uint32_t i = thread; i < tool_counts[0]; i += kThreads) {
        const float4 p = shared[held[i].x];
        const Particle moved =
            pull(tools, input, sweep.substep, s == 0, static_cast<Index>(held[i].y),
                 {p.x, p.y, p.z, p.w}, base_at(held[i].x));
        shared[held[i].x] = make_float4(moved.x, moved.y, moved.z, moved.w);
      }
      meet(kProjectBarrier, kThreads);
      for (std::uint32_t i = thread; i < tool_counts[1]; i += kThreads) {
        const float4 p = shared[touched[i]];
        const Particle moved = push(tools, input, __ldg(places + touched[i]), state.capacity,
                                    {p.x, p.y, p.z, p.w}, base_at(touched[i]));
        shared[touched[i]] = make_float4(moved.x, moved.y, moved.z, moved.w);
      }
      meet(kProjectBarrier, kThreads);
    }
    if (contacts > 0) {
      if constexpr (kExtraPhases) {
        project_contacts_apart<kThreads, SurfaceArrays, MovingContact, 3>(
            cluster, memory, tools.surfaces, contacts, contact_phases++ % 2);
      } else {
        do_in_one_block(cluster, memory, parity, [&](const auto& await) {
          project_contacts_of_cluster<kThreads, SurfaceArrays, MovingContact, 3>(
              cluster, memory, tools.surfaces, contacts, await);
        });
      }
    }
  }
  for (std::uint32_t slot = thread; slot < block.home_count; slot += kThreads) {
    *reinterpret_cast<float4*>(moving_of(state) + __ldg(places + slot)) = shared[slot];
  }
}

#else

template <ProjectionMode kMode, bool kDamped, ClusterTissue kTissue, int kThreads,
          bool kExtraPhases>
__global__ void sweep_by_cluster(ClusterArrays, DeviceState, ToolArrays, StepInput*, ClusterSweep) {
  __trap();  // never launched: see prepare_cluster()
}

#endif

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
