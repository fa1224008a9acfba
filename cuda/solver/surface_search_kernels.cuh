// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tools that meet surfaces touch in a substep, in the order of the host's lists; see
/// feature_search.h.

#include <cub/block/block_scan.cuh>

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/spring_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kListThreads = 256;  // of the one block of a copy that lists contacts

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

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
