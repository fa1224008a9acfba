// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tools that meet surfaces: what they touch in a substep, in the order of the host's lists, and
/// what pushes back; see surface_contacts.h.

#include <cub/block/block_scan.cuh>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/stiff_link_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "cuda/solver/vertex_kernels.cuh"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kListThreads = 256;  // of the one block of a copy that lists contacts
constexpr int kAnswerBlocks = 8;   // whatever the number of contacts, which the host does not know

/// A feature that a tool may meet.
struct Candidate {
  FeatureCorners corners;
  Index half_space = kInvalidIndex;  ///< that meets it, else capsules do
};

/// A vertex through the substep.
struct CornerMotion {
  Vec3<float> start, end;  ///< m
  bool is_fixed;
};

__device__ inline CornerMotion load_motion(const DeviceState& state, Index place) {
  const Particle p = load_particle(moving_of(state) + place);
  const Vec3<float> base = base_of(state, place);
  return {
      state.displacements == nullptr ? position_of(load_particle(state.previous + place)) : base,
      base + position_of(p), !(p.w > 0)};
}

/// Of a feature whose places are known.
__device__ inline void load_corners(const DeviceState& state, FeatureCorners& corners) {
  for (int k = 0; k < corners.count; ++k) {
    const CornerMotion motion = load_motion(state, corners.places[k]);
    corners.start[k] = motion.start;
    corners.end[k] = motion.end;
    corners.is_fixed[k] = motion.is_fixed;
  }
}

/// @return  whether there is a candidate of that number, and it can move
__device__ inline bool load_candidate(const DeviceState& state, const SurfaceArrays& surfaces,
                                      const MeeterInput& meeter, Index index, Index vertex_count,
                                      Candidate& candidate) {
  FeatureCorners& corners = candidate.corners;
  const Index of_vertices = vertex_count * (1 + meeter.half_space_count);
  if (index < of_vertices) {
    corners.count = 1;
    corners.places[0] = index % vertex_count;
    candidate.half_space = index / vertex_count - 1;
    if (candidate.half_space == kInvalidIndex && meeter.capsule_count == 0) {
      return false;
    }
  } else {
    const Index triangle = (index - of_vertices) / 4;
    const Index part = (index - of_vertices) % 4;
    if (!meeter.meets_triangles || triangle >= surfaces.triangle_count) {
      return false;
    }
    const Index* const places = surfaces.triangles + 3 * static_cast<std::ptrdiff_t>(triangle);
    ContactFeature feature{{__ldg(places), __ldg(places + 1), __ldg(places + 2)}};
    if (feature.places[0] == kInvalidIndex) {
      return false;
    }
    if (part < 3) {  // edges run from smaller to larger places in one of two triangles
      const Index first = feature.places[part], second = feature.places[(part + 1) % 3];
      if (first > second) {
        return false;
      }
      corners.count = 2;
      corners.places[0] = first;
      corners.places[1] = second;
    } else {
      feature.sort();
      corners.count = 3;
      for (int k = 0; k < 3; ++k) {
        corners.places[k] = feature.places[k];
      }
    }
  }
  load_corners(state, corners);
  bool moves = false;
  for (int k = 0; k < corners.count; ++k) {
    moves |= !corners.is_fixed[k];
  }
  return moves;
}

/// See the host's own_start().
__device__ inline Vec3<float> own_start(const DeviceState& state, Index place) {
  if (state.displacements == nullptr) {
    return position_of(load_particle(state.previous + place));
  }
  if (state.ways != nullptr) {
    return load_way(state.ways + place);
  }
  const Carry carry = load_carry(state.carries + place);
  return {carry.x, carry.y, carry.z};
}

/// See follow_feature().
/// @param swept    capsules of the substep
/// @param spring   of the tool; null if it has none
__device__ inline void follow_feature(const DeviceState& state, const SweptCapsule* swept,
                                      const ToolSpring* spring, const DeviceContact& stored,
                                      SurfaceContact& contact) {
  if (stored.swept == kInvalidIndex) {
    return;
  }
  FeatureCorners corners;
  corners.count = contact.feature.count();
  for (int k = 0; k < corners.count; ++k) {
    corners.places[k] = contact.feature.places[k];
  }
  load_corners(state, corners);
  const Vec3<float> shift = spring == nullptr ? Vec3<float>{} : spring->shift;
  const Vec3<float> displacement = spring == nullptr ? Vec3<float>{} : spring->displacement;
  turn_to(
      corners, swept[stored.swept].moved(displacement + shift), shift,
      [&](Index place) { return base_of(state, place); },
      [&](Index place) { return own_start(state, place); }, contact);
}

/// Of a feature at a share of the substep.
__device__ inline Outward outward_at(const DeviceState& state, const SurfaceArrays& surfaces,
                                     const ContactFeature& feature, float share) {
  Outward outward(feature);
  for (Index corner = __ldg(surfaces.first_corners + feature.places[0]); corner != kInvalidIndex;
       corner = __ldg(surfaces.next_corners + corner)) {
    outward.add(surfaces.triangles + corner - corner % 3, [&](Index place) {
      const CornerMotion motion = load_motion(state, place);
      return at_share(motion.start, motion.end, share);
    });
  }
  return outward;
}

__device__ inline int compare(const ContactFeature& a, const ContactFeature& b) {
  for (int k = 0; k < 3; ++k) {
    if (a.places[k] != b.places[k]) {
      return a.places[k] < b.places[k] ? -1 : 1;
    }
  }
  return 0;
}

/// What the substep before left of a contact; null if there was none.
__device__ inline const RememberedContact* find_remembered(const RememberedContact* first,
                                                           Index count,
                                                           const ContactFeature& feature) {
  Index low = 0, high = count;
  while (low < high) {
    const Index middle = (low + high) / 2;
    const int order = compare(first[middle].feature, feature);
    if (order == 0) {
      return first + middle;
    }
    low = order < 0 ? middle + 1 : low;
    high = order < 0 ? high : middle;
  }
  return nullptr;
}

/// Of all meeters in a substep, of this copy.
__device__ inline const SweptCapsule* swept_capsules(StepInput* input, Index substep) {
  return table<SweptCapsule>(input, input->swept) + of_pusher(substep, input->swept_count);
}

/// The tables of a substep, of this copy.
struct Meeters {
  const MeeterInput* meeters;
  const SweptCapsule* swept;
  const SweptHalfSpace* half_spaces;
  const RememberedContact* remembered;  ///< of the substep before
  const Index* remembered_ends;         ///< null: see MeeterInput
  bool is_first;                        ///< the substep, of a part of a step

  __device__ Meeters(const SurfaceArrays& surfaces, StepInput* input, Index substep)
      : meeters(table<MeeterInput>(input, input->meeters) +
                of_pusher(substep, input->meeter_count)),
        swept(swept_capsules(input, substep)),
        half_spaces(table<SweptHalfSpace>(input, input->half_spaces) +
                    of_pusher(substep, input->half_space_count)),
        remembered(substep == 0 ? table<RememberedContact>(input, input->remembered)
                                : surfaces.remembered),
        remembered_ends(substep == 0 ? nullptr : surfaces.remembered_ends),
        is_first(substep == 0) {}

  /// m, of a tool as the substep begins.
  [[nodiscard]] __device__ Vec3<float> displacement(const SurfaceArrays& surfaces,
                                                    Index meeter) const {
    return is_first ? meeters[meeter].displacement : surfaces.springs[meeter].displacement;
  }

  [[nodiscard]] __device__ const RememberedContact* find(Index meeter,
                                                         const ContactFeature& feature) const {
    const Index first =
        remembered_ends == nullptr ? meeters[meeter].first_remembered : remembered_ends[meeter];
    const Index count = remembered_ends == nullptr ? meeters[meeter].remembered_count
                                                   : remembered_ends[meeter + 1] - first;
    return find_remembered(remembered + first, count, feature);
  }

  [[nodiscard]] __device__ MetFeature meet(const DeviceState& state, const SurfaceArrays& surfaces,
                                           Index meeter, const Candidate& candidate,
                                           const RememberedContact*& known) const {
    const MeeterInput& tool = meeters[meeter];
    const FeatureCorners& corners = candidate.corners;
    const Vec3<float> way = displacement(surfaces, meeter);
    MetFeature met;
    known = nullptr;
    if (candidate.half_space != kInvalidIndex) {
      meet_half_space(corners, half_spaces[tool.first_half_space + candidate.half_space].moved(way),
                      met);
      if (met.gap < kInfinity) {
        known = find(meeter, feature_of(corners));
      }
    } else if (box_of(corners).meets(tool.box.moved(way))) {
      known = find(meeter, feature_of(corners));
      const auto outward = [&](float share) {
        return tool.meets_triangles ? outward_at(state, surfaces, feature_of(corners), share)
                                    : Outward(feature_of(corners));
      };
      for (Index c = 0; c < tool.capsule_count; ++c) {
        meet_capsule(corners, swept[tool.first_capsule + c].moved(way), c,
                     known != nullptr ? &known->normal : nullptr, outward, met);
      }
    }
    return met;
  }
};

/// Marks the candidates that are met: a thread each.
__global__ void __launch_bounds__(kToolThreads)
    find_near(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  const Index vertices = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Meeters meeters(surfaces, input, substep);
  const Index index = thread_index();
  for (Index m = 0; m < input->meeter_count; ++m) {
    Candidate candidate;
    const RememberedContact* known = nullptr;
    const bool is_met =
        load_candidate(state, surfaces, meeters.meeters[m], index, vertices, candidate) &&
        meeters.meet(state, surfaces, m, candidate, known).gap < kInfinity;
    const std::uint32_t bits = __ballot_sync(~0U, is_met);
    if (threadIdx.x % kWarp == 0 && index / kWarp < surfaces.word_room) {
      surfaces.near[of_pusher(m, surfaces.word_room) + static_cast<std::size_t>(index / kWarp)] =
          bits;
    }
  }
}

/// Lists the first candidates of a tool, up to the capacity, in their order.
/// @return  how many were met
__device__ inline Index list_candidates(const SurfaceArrays& surfaces, Index meeter,
                                        Index capacity) {
  using Scan = cub::BlockScan<Index, kListThreads>;
  __shared__ typename Scan::TempStorage storage;
  const std::uint32_t* const near = surfaces.near + of_pusher(meeter, surfaces.word_room);
  Index* const candidates = surfaces.candidates + of_pusher(meeter, surfaces.tool_room);
  const Index each = (surfaces.word_room + kListThreads - 1) / kListThreads;
  const Index first = each * static_cast<Index>(threadIdx.x);
  const Index end = first + each < surfaces.word_room ? first + each : surfaces.word_room;
  Index own = 0, rank = 0, all = 0;
  for (Index word = first; word < end; ++word) {
    own += __popc(__ldcg(near + word));
  }
  Scan(storage).ExclusiveSum(own, rank, all);
  for (Index word = first; word < end && own > 0; ++word) {
    for (std::uint32_t bits = __ldcg(near + word); bits != 0; bits &= bits - 1, ++rank, --own) {
      if (rank < capacity) {
        candidates[rank] = word * kWarp + __ffs(static_cast<int>(bits)) - 1;
      }
    }
  }
  __syncthreads();
  return all;
}

constexpr Index kListedBefore = -1;  // in place of a level: there is one of that feature

/// Puts a tool's contacts in the order of features, each once.
/// @param count  of those found
/// @return       of those kept
__device__ inline Index order_contacts(DeviceContact* found, Index count, DeviceContact* contacts) {
  const auto thread = static_cast<Index>(threadIdx.x);
  Index kept = 0;
  for (Index first = 0; first < count; first += kListThreads) {
    const Index i = first + thread;
    bool is_first = i < count;
    for (Index j = 0; j < i && is_first; ++j) {
      is_first = compare(found[j].contact.feature, found[i].contact.feature) != 0;
    }
    if (i < count) {
      found[i].level = is_first ? 0 : kListedBefore;
    }
    kept += __syncthreads_count(is_first);
  }
  for (Index i = thread; i < count; i += kListThreads) {
    if (found[i].level == kListedBefore) {
      continue;
    }
    Index rank = 0;
    for (Index j = 0; j < count; ++j) {
      const bool is_before = found[j].level != kListedBefore &&
                             compare(found[j].contact.feature, found[i].contact.feature) < 0;
      rank += is_before ? 1 : 0;
    }
    contacts[rank] = found[i];
  }
  __syncthreads();
  return kept;
}

/// What chaining reads again and again, near at hand: of so many contacts at most.
struct ChainStage {
  static constexpr Index kRoom = 512;
  ContactFeature features[kRoom];
  Index before[3 * kRoom];  ///< next_holds
  Index levels[kRoom];
};

/// Chains the holds of each place, the last first, and finds levels.
/// @param count  of contacts
__device__ inline void chain_contacts(const SurfaceArrays& surfaces, Index count) {
  const auto thread = static_cast<Index>(threadIdx.x);
  DeviceContact* const contacts = surfaces.contacts;
  __shared__ ChainStage stage;
  const bool is_staged = count <= ChainStage::kRoom;
  const auto feature_at = [&](Index c) -> const ContactFeature& {
    return is_staged ? stage.features[c] : contacts[c].contact.feature;
  };
  const auto level_at = [&](Index c) -> volatile Index& {
    return is_staged ? stage.levels[c] : contacts[c].level;
  };
  Index* const before_of = is_staged ? stage.before : surfaces.next_holds;
  const auto corner_at = [&](Index c, Index place) {
    const ContactFeature& feature = feature_at(c);
    for (int k = 0; k < 3; ++k) {
      if (feature.places[k] == place) {
        return k;
      }
    }
    return -1;
  };
  constexpr Index kUnknown = -1;
  __shared__ Index levels;
  if (thread == 0) {
    levels = 0;
  }
  for (Index c = thread; c < count; c += kListThreads) {
    if (is_staged) {
      stage.features[c] = contacts[c].contact.feature;
    }
    level_at(c) = kUnknown;
  }
  __syncthreads();
  for (Index hold = thread; hold < 3 * count; hold += kListThreads) {
    const Index own = hold / 3;
    const Index place = feature_at(own).places[hold % 3];
    Index before = kInvalidIndex;
    for (Index c = own - 1; place != kInvalidIndex && before == kInvalidIndex && c >= 0; --c) {
      const int corner = corner_at(c, place);
      before = corner < 0 ? kInvalidIndex : 3 * c + corner;
    }
    before_of[hold] = before;
    if (is_staged) {
      surfaces.next_holds[hold] = before;
    }
    bool is_last = place != kInvalidIndex;
    for (Index c = own + 1; is_last && c < count; ++c) {
      is_last = corner_at(c, place) < 0;
    }
    if (is_last) {
      surfaces.first_holds[place] = hold;
    }
  }
  bool is_any_unknown = count > 0;
  while (is_any_unknown) {
    __syncthreads();
    is_any_unknown = false;
    for (Index c = thread; c < count; c += kListThreads) {
      if (level_at(c) != kUnknown) {
        continue;
      }
      Index level = 0;
      const auto come_after = [&](Index other) {
        const Index known = level_at(other);
        level = known == kUnknown || level == kUnknown ? kUnknown
                                                       : (known + 1 > level ? known + 1 : level);
      };
      for (int k = 0; k < 3; ++k) {
        const Index before = before_of[3 * c + k];
        if (before != kInvalidIndex) {
          come_after(before / 3);
        }
      }
      const Index spring = contacts[c].spring;
      if (spring != kInvalidIndex && c > 0 && contacts[c - 1].spring == spring) {
        come_after(c - 1);
      }
      level_at(c) = level;
      atomicMax(&levels, level + 1);
      is_any_unknown |= level == kUnknown;
    }
    is_any_unknown = __syncthreads_or(is_any_unknown) != 0;
  }
  __syncthreads();
  for (Index c = thread; is_staged && c < count; c += kListThreads) {
    contacts[c].level = stage.levels[c];
  }
  if (thread == 0) {
    *surfaces.level_counts = levels;
  }
}

/// One block a copy.
/// @param has_pushers  then other contacts have been counted
__global__ void __launch_bounds__(kListThreads)
    list_contacts(DeviceState state, ToolArrays tools, StepInput* input, Index substep,
                  bool has_pushers, bool remembers) {
  const Index vertices = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const auto thread = static_cast<Index>(threadIdx.x);
  const Meeters meeters(surfaces, input, substep);
  const Index before = surfaces.ends[surfaces.meeter_room];
  for (Index hold = thread; hold < 3 * before; hold += kListThreads) {
    const Index place = surfaces.contacts[hold / 3].contact.feature.places[hold % 3];
    if (place != kInvalidIndex) {
      surfaces.first_holds[place] = kInvalidIndex;
    }
  }
  const Index capacity =
      input->contact_capacity < surfaces.tool_room ? input->contact_capacity : surfaces.tool_room;
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  Index all = 0, dropped = 0;
  for (Index m = 0; m < input->meeter_count; ++m) {
    const Index met = list_candidates(surfaces, m, capacity);
    const Index count = met < capacity ? met : capacity;
    all += count;
    dropped += met - count;
    if (thread == 0) {
      surfaces.ends[m] = count;  // for now
    }
  }
  __syncthreads();
  // of all tools at once, as a thread waits long for what one candidate needs
  for (Index i = thread; i < all; i += kListThreads) {
    Index m = 0, rank = i;
    for (; rank >= surfaces.ends[m]; ++m) {
      rank -= surfaces.ends[m];
    }
    const MeeterInput& meeter = meeters.meeters[m];
    Candidate candidate;
    load_candidate(state, surfaces, meeter,
                   surfaces.candidates[of_pusher(m, surfaces.tool_room) + rank], vertices,
                   candidate);
    const RememberedContact* known = nullptr;
    const MetFeature met = meeters.meet(state, surfaces, m, candidate, known);
    DeviceContact& found = surfaces.found[i];
    found.contact = contact_of(
        candidate.corners, met, [&](Index place) { return base_of(state, place); },
        [&](Index place) { return own_start(state, place); });
    if (remembers && known != nullptr) {
      recall(*known, inverse_dt_squared, found.contact);
    }
    found.friction = meeter.friction;
    found.swept = met.capsule == kInvalidIndex ? kInvalidIndex : meeter.first_capsule + met.capsule;
    found.spring = meeter.compliance > 0 ? m : kInvalidIndex;
  }
  __syncthreads();
  Index first = 0, end = 0;
  for (Index m = 0; m < surfaces.meeter_room; ++m) {
    const Index count = m < input->meeter_count ? surfaces.ends[m] : 0;
    __syncthreads();
    if (thread == 0) {
      surfaces.ends[m] = end;
    }
    end += order_contacts(surfaces.found + first, count, surfaces.contacts + end);
    first += count;
  }
  for (Index m = thread; m < input->meeter_count; m += kListThreads) {
    ToolSpring spring{meeters.displacement(surfaces, m), {}, 0};
    if (meeters.meeters[m].compliance > 0) {
      begin_spring(meeters.meeters[m].compliance, inverse_dt_squared, remembers, spring);
    }
    surfaces.springs[m] = spring;
  }
  if (thread == 0) {
    surfaces.ends[surfaces.meeter_room] = end;
    input->sums.contacts = (has_pushers ? input->sums.contacts : 0) + end;
    input->sums.dropped_contacts += dropped;
  }
  chain_contacts(surfaces, end);
}

void find_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                           Index substep, bool has_pushers, const Launch& how) {
  launch(how, "launching the search for surfaces",
         blocks_for(tools.surfaces.word_room * kWarp, kToolThreads), kToolThreads, find_near, state,
         tools, input, substep);
  const bool remembers = state.fixed_points != nullptr && !state.starts;
  launch(how, "launching the list of contacts", 1, kListThreads, list_contacts, state, tools, input,
         substep, has_pushers, remembers);
}

constexpr int kYieldThreads = 96;  // three for each contact

/// How stiffly contacts are met, once it is known what holds each vertex: a thread a corner.
template <bool kRowsChange>
__global__ void __launch_bounds__(kYieldThreads)
    find_yields(DeviceState state, VertexArrays vertices, ToolArrays tools, StepInput* input,
                Index substep) {
  wait_for_previous();
  state = of_copy(state);
  vertices = of_copy(vertices);
  tools = of_copy(tools, state.capacity);
  input += copy_index();
  const SurfaceArrays& surfaces = tools.surfaces;
  const Index count = contact_count(surfaces);
  __shared__ float yields[kYieldThreads];
  const auto is_likely = [&](const DeviceContact& stored) {
    return stored.contact.multiplier > 0 || read_contact(state, surfaces, stored).gap < 0;
  };
  for (Index first = static_cast<Index>(blockIdx.x) * kYieldThreads; first < 3 * count;
       first += thread_count()) {
    const Index hold = first + static_cast<Index>(threadIdx.x);
    const Index own = hold / 3, corner = hold % 3;
    float yield = 0;
    if (own < count && corner < surfaces.contacts[own].contact.feature.count()) {
      const SurfaceContact& contact = surfaces.contacts[own].contact;
      const Index place = contact.feature.places[corner];
      const float weight = contact.weights[corner];
      float pushes = is_likely(surfaces.contacts[own]) ? 0 : weight;
      for (Index h = surfaces.first_holds[place]; h != kInvalidIndex; h = surfaces.next_holds[h]) {
        const DeviceContact& other = surfaces.contacts[h / 3];
        pushes += is_likely(other) ? other.contact.weights[h % 3] : 0;
      }
      const VertexGive<float> give =
          find_loose_end<kRowsChange>(state, vertices, tools, input, substep, true, place).give;
      yield = weight * pushes * dot(contact.normal, give * contact.normal);
    }
    yields[threadIdx.x] = yield;
    __syncthreads();
    if (own < count && corner == 0) {
      const float sum = yields[threadIdx.x] + yields[threadIdx.x + 1] + yields[threadIdx.x + 2];
      surfaces.contacts[own].contact.stiffness = sum > 0 ? kContactFirmness / sum : 0.0F;
    }
    __syncthreads();
  }
}

void begin_surface_contacts(const DeviceState& state, const VertexArrays& vertices,
                            const ToolArrays& tools, StepInput* input, Index substep,
                            const Launch& how) {
  launch(how, "launching how contacts are met", share_blocks(kAnswerBlocks, 1, how), kYieldThreads,
         vertices.is_damped ? find_yields<true> : find_yields<false>, state, vertices, tools, input,
         substep);
}

/// Moves corners by their masses, one level of contacts after another: the bits of one contact
/// after another. One block a copy.
/// @param settles  only those that are inside, without friction
__global__ void __launch_bounds__(kListThreads)
    project_surfaces(DeviceState state, ToolArrays tools, bool settles) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  Particle* const moving = moving_of(state);
  const auto project_level = [&](Index level) {
    bool is_any_inside = false;
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kListThreads) {
      DeviceContact& stored = surfaces.contacts[c];
      if (stored.level != level) {
        continue;
      }
      SurfaceContact contact = stored.contact;
      const int corners = contact.feature.count();
      ToolSpring* const spring = spring_of(surfaces, stored);
      float yield = spring == nullptr ? 0 : spring->yield;
      for (int k = 0; k < corners; ++k) {
        const float w = load_particle(moving + contact.feature.places[k]).w;
        yield += contact.weights[k] * contact.weights[k] * w;
      }
      const auto read = [&] {
        return read_contact(state, contact, spring == nullptr ? Vec3<float>{} : spring->shift);
      };
      if (settles && !(read().gap < 0)) {
        continue;
      }
      is_any_inside = true;
      project_contact(
          contact, settles ? 0.0F : stored.friction, yield, read, [&](const Vec3<float>& push) {
            if (spring != nullptr) {
              spring->shift = spring->shift - spring->yield * push;
            }
            for (int k = 0; k < corners; ++k) {
              Particle* const particle = moving + contact.feature.places[k];
              const Particle p = load_particle(particle);
              const Vec3<float> after = position_of(p) + (contact.weights[k] * p.w) * push;
              if (is_finite_way(after)) {
                store_particle(particle, after, p.w);
              }
            }
          });
      stored.contact = contact;
    }
    __syncthreads();
    return is_any_inside;
  };
  // one after another only where there is something to do
  const auto is_any_to_project = [&] {
    bool is_any = !settles;
    for (Index c = static_cast<Index>(threadIdx.x); c < count && !is_any; c += kListThreads) {
      is_any = read_contact(state, surfaces, surfaces.contacts[c]).gap < 0;
    }
    return __syncthreads_or(is_any) != 0;
  };
  bool is_any_inside = is_any_to_project();
  for (int pass = 0; pass < (settles ? kSettlePasses : 1) && is_any_inside; ++pass) {
    is_any_inside = false;
    for (Index level = 0; level < levels; ++level) {
      is_any_inside |= project_level(level);
    }
    is_any_inside = __syncthreads_or(is_any_inside) != 0;
  }
  for (Index c = static_cast<Index>(threadIdx.x); settles && c < count; c += kListThreads) {
    DeviceContact& stored = surfaces.contacts[c];
    stored.contact.is_left_inside = is_left_inside(read_contact(state, surfaces, stored));
  }
}

void project_surface_contacts(const DeviceState& state, const ToolArrays& tools, bool settles,
                              const Launch& how) {
  launch(how, "launching contacts with surfaces", 1, kListThreads, project_surfaces, state, tools,
         settles);
}

/// After a sweep of vertex blocks: see balance_spring(). One block a copy.
__global__ void __launch_bounds__(kListThreads)
    balance_springs(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const auto thread = static_cast<Index>(threadIdx.x);
  struct Answered {
    Vec3<float> normal;
    float stiffness;
    ContactAnswer<float> answer;
  };
  struct AllAnswered {
    Answered of[kListThreads];
  };
  __shared__ SharedRoom<AllAnswered> room;
  Answered* const answers = room.get().of;
  for (Index m = 0; m < input->meeter_count; ++m) {
    const Index begin = surfaces.ends[m], end = surfaces.ends[m + 1];
    ToolSpring spring = surfaces.springs[m];
    if (!(spring.yield > 0)) {
      continue;  // it has none
    }
    // all threads add up all of them, in their order, and come to the same bits
    const auto add_answers = [&](const Vec3<float>& shift, VertexEnergy<float>& energy) {
      for (Index first = begin; first < end; first += kListThreads) {
        const Index c = first + thread;
        __syncthreads();
        if (c < end) {
          const auto& [contact, friction, swept, spring, level] = surfaces.contacts[c];
          answers[thread] = {contact.normal, contact.stiffness,
                             answer(contact, friction, read_contact(state, contact, shift),
                                    inverse_dt_squared, contact.stiffness)};
        }
        __syncthreads();
        for (Index i = 0; i < kListThreads && first + i < end; ++i) {
          add_answer(answers[i], answers[i].answer, -1, energy);
        }
      }
    };
    balance_spring(inverse_dt_squared, add_answers, spring);
    __syncthreads();
    if (thread == 0) {
      surfaces.springs[m] = spring;
    }
  }
}

/// After a sweep of vertex blocks, multipliers become the forces of the contacts, and their planes
/// follow what they meet.
__global__ void __launch_bounds__(kToolThreads)
    answer_surfaces(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const float square = 1 / inverse_dt_squared;
  const SweptCapsule* const swept = swept_capsules(input, substep);
  const Index count = contact_count(surfaces);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    DeviceContact& stored = surfaces.contacts[c];
    SurfaceContact contact = stored.contact;
    take_over(contact,
              answer(contact, stored.friction, read_contact(state, surfaces, stored),
                     inverse_dt_squared, contact.stiffness)
                  .force,
              square);
    follow_feature(state, swept, spring_of(surfaces, stored), stored, contact);
    stored.contact = contact;
  }
}

/// What the next substep has to know, and after the last one the host.
__global__ void __launch_bounds__(kToolThreads)
    remember(ToolArrays tools, StepInput* input, Index place_room, Index substep, bool tells) {
  wait_for_previous();
  const SurfaceArrays surfaces = of_copy(tools, place_room).surfaces;
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Index count = contact_count(surfaces);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    const SurfaceContact& contact = surfaces.contacts[c].contact;
    const RememberedContact now = remembered(contact, inverse_dt_squared);
    surfaces.remembered[c] = now;
    if (tells) {
      surfaces.told[c] = contact;
      surfaces.told_remembered[c] = now;
    }
  }
  for (Index m = thread_index(); m < input->meeter_count; m += thread_count()) {
    const MeeterInput& meeter =
        (table<MeeterInput>(input, input->meeters) + of_pusher(substep, input->meeter_count))[m];
    ToolSpring& spring = surfaces.springs[m];
    if (meeter.compliance > 0) {
      end_spring(meeter.stride, meeter.way, input->h, spring);
    }
    if (tells) {
      surfaces.told_springs[m] = spring;
    }
  }
  for (Index m = thread_index(); m <= surfaces.meeter_room; m += thread_count()) {
    const Index end = __ldcg(surfaces.ends + m);
    surfaces.remembered_ends[m] = end;
    if (tells) {
      surfaces.told_ends[m] = end;
    }
  }
}

void remember_surface_contacts(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                               Index substep, bool tells, const Launch& how) {
  launch(how, "launching what is remembered of contacts", share_blocks(kAnswerBlocks, 1, how),
         kToolThreads, remember, tools, input, state.capacity, substep, tells);
}

/// Of BDF2, as ease() for vertices that tools push: by levels. One block a copy.
__global__ void __launch_bounds__(kListThreads)
    ease_surfaces(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  for (Index level = 0; level < levels; ++level) {
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kListThreads) {
      const DeviceContact& stored = surfaces.contacts[c];
      const SurfaceContact& contact = stored.contact;
      if (stored.level != level || !(contact.multiplier > 0) || contact.is_eased) {
        continue;
      }
      for (int k = 0; k < contact.feature.count(); ++k) {
        const Index place = contact.feature.places[k];
        if (load_particle(state.particles + place).w > 0) {
          ease_vertex(state, place, contact.normal, input->inverse_h);
        }
      }
    }
    __syncthreads();
  }
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
