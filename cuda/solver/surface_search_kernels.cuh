// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What tools that meet surfaces touch in a substep, in no order; see feature_search.h.

#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/feature_meeting.h"
#include "lib/solver/methods/handed_force.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

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
  corners.for_each([&](int k) {
    const CornerMotion motion = load_motion(state, corners.places[k]);
    corners.start[k] = motion.start;
    corners.end[k] = motion.end;
    corners.is_fixed[k] = motion.is_fixed;
  });
}

/// Edges run from smaller to larger places in one of two triangles.
__device__ inline bool is_own_edge(Index first, Index second) {
  return first < second;
}

/// Of fixed vertices, others have no tissue.
__device__ inline bool has_triangle(const SurfaceArrays& surfaces, Index place) {
  return __ldg(surfaces.first_around + place + 1) > __ldg(surfaces.first_around + place);
}

/// @return  whether there is a candidate of that number, and it or the tool gives way
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
    const Index triangle = (index - of_vertices) / kFeaturesOfTriangle;
    const Index part = (index - of_vertices) % kFeaturesOfTriangle;
    if (!meeter.meets_triangles || triangle >= surfaces.triangle_count) {
      return false;
    }
    const Index* const places = surfaces.triangles + 3 * static_cast<std::ptrdiff_t>(triangle);
    ContactFeature feature{{__ldg(places), __ldg(places + 1), __ldg(places + 2)}};
    if (feature.places[0] == kInvalidIndex) {
      return false;
    }
    if (part < 3) {
      const Index first = feature.places[part], second = feature.places[(part + 1) % 3];
      if (!is_own_edge(first, second)) {
        return false;
      }
      corners.count = 2;
      corners.places[0] = first;
      corners.places[1] = second;
    } else {
      if (feature.places[1] == feature.places[2]) {  // a link has edges alone
        return false;
      }
      feature.sort();
      corners.count = 3;
      for (int k = 0; k < 3; ++k) {
        corners.places[k] = feature.places[k];
      }
    }
  }
  load_corners(state, corners);
  if (candidate.half_space == kInvalidIndex && meeter.compliance > 0 &&
      (corners.count > 1 || has_triangle(surfaces, corners.places[0]))) {
    corners.take_as_free();
  }
  bool gives_way = false;
  corners.for_each([&](int k) { gives_way |= !corners.is_fixed[k]; });
  return gives_way;
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
  constexpr Index kAtOnce = 4;  // triangles that are asked for together
  Outward outward(feature);
  const Index end = __ldg(surfaces.first_around + feature.places[0] + 1);
  for (Index first = __ldg(surfaces.first_around + feature.places[0]); first < end;
       first += kAtOnce) {
    Index places[kAtOnce][3];
#pragma unroll
    for (Index i = 0; i < kAtOnce; ++i) {
      const Index triangle = __ldg(surfaces.around + (first + i < end ? first + i : first));
#pragma unroll
      for (int k = 0; k < 3; ++k) {
        places[i][k] = __ldg(surfaces.triangles + 3 * static_cast<std::ptrdiff_t>(triangle) + k);
      }
    }
#pragma unroll
    for (Index i = 0; i < kAtOnce; ++i) {
      if (first + i < end) {
        outward.add(places[i], [&](Index place) {
          const CornerMotion motion = load_motion(state, place);
          return at_share(motion.start, motion.end, share);
        });
      }
    }
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
  return table<SweptCapsule>(input, input->swept) + row_at(substep, input->swept_count);
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
      : meeters(table<MeeterInput>(input, input->meeters) + row_at(substep, input->meeter_count)),
        swept(swept_capsules(input, substep)),
        half_spaces(table<SweptHalfSpace>(input, input->half_spaces) +
                    row_at(substep, input->half_space_count)),
        remembered(substep == 0 ? table<RememberedContact>(input, input->remembered)
                                : surfaces.remembered),
        remembered_ends(substep == 0 ? nullptr : surfaces.remembered_ends),
        is_first(substep == 0) {}

  /// m, of a tool as the substep begins.
  [[nodiscard]] __device__ Vec3<float> displacement(const SurfaceArrays& surfaces,
                                                    Index meeter) const {
    return is_first ? meeters[meeter].displacement : surfaces.springs[meeter].displacement;
  }

  /// Of a meeter, within `remembered`.
  struct Range {
    Index first, count;
  };
  [[nodiscard]] __device__ Range range(Index meeter) const {
    if (remembered_ends == nullptr) {
      return {meeters[meeter].first_remembered, meeters[meeter].remembered_count};
    }
    return {remembered_ends[meeter], remembered_ends[meeter + 1] - remembered_ends[meeter]};
  }

  [[nodiscard]] __device__ const RememberedContact* find(Index meeter,
                                                         const ContactFeature& feature) const {
    const auto [first, count] = range(meeter);
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

/// @param remembers  whether contacts go on from the forces of the substep before
/// @return           whether the meeter meets the candidate
__device__ inline bool find_contact(const DeviceState& state, const SurfaceArrays& surfaces,
                                    const Meeters& meeters, Index m, Index candidate_index,
                                    Index vertices, float inverse_dt_squared, bool remembers,
                                    DeviceContact& found) {
  const MeeterInput& meeter = meeters.meeters[m];
  Candidate candidate;
  if (!load_candidate(state, surfaces, meeter, candidate_index, vertices, candidate)) {
    return false;
  }
  const RememberedContact* known = nullptr;
  const MetFeature met = meeters.meet(state, surfaces, m, candidate, known);
  if (!(met.gap < kInfinity)) {
    return false;
  }
  found.contact = contact_of(
      candidate.corners, met, [&](Index place) { return base_of(state, place); },
      [&](Index place) { return own_start(state, place); });
  found.contact.takes_over =
      met.capsule != kInvalidIndex &&
      may_take_over(known != nullptr, meeters.swept[meeter.first_capsule + met.capsule]);
  if (remembers && known != nullptr) {
    recall(*known, inverse_dt_squared, found.contact);
  }
  found.friction = meeter.friction;
  found.swept = met.capsule == kInvalidIndex ? kInvalidIndex : meeter.first_capsule + met.capsule;
  found.spring = meeter.compliance > 0 ? m : kInvalidIndex;
  found.firmness = kPlainFirmness;
  if (found.swept != kInvalidIndex && state.fixed_points != nullptr) {
    const SweptCapsule& capsule = meeters.swept[found.swept];
    const float thickness =
        relative_thickness(capsule.now, found.contact.feature, found.contact.normal,
                           [&](Index place) { return load_motion(state, place).end; });
    found.firmness = firmness_of(__ldg(surfaces.firmness + found.contact.feature.places[0]),
                                 thickness, capsule.relative_way());
  }
  return true;
}

constexpr int kSearchThreads = 128;

/// Which of some candidates a meeter may meet, by their number of corners, so that threads of a
/// warp do the same with them; in any order. Nearly all are far away.
class NearCandidates {
 public:
  static constexpr Index kItemsOfThread = 2;
  /// Vertices, or triangles with their edges.
  static constexpr Index kItems = kItemsOfThread * kSearchThreads;

  /// All threads of a block call it, and meet in it.
  __device__ void find(const DeviceState& state, const SurfaceArrays& surfaces,
                       const MeeterInput& meeter, const Vec3<float>& displacement, Index first_item,
                       Index vertex_count) {
    const auto thread = static_cast<Index>(threadIdx.x);
    if (thread < 3) {
      counts_[thread] = 0;
    }
    __syncthreads();
    const ContactBox box = meeter.box.moved(displacement);
    const Index of_vertices = vertex_count * (1 + meeter.half_space_count);
#pragma unroll
    for (Index i = 0; i < kItemsOfThread; ++i) {
      const Index item = first_item + i * kSearchThreads + thread;
      if (item >= of_vertices) {
        find_triangle(state, surfaces, meeter, box, of_vertices, item - of_vertices);
      } else if (item >= vertex_count ||
                 (meeter.capsule_count > 0 && may_meet<1>(state, {item}, box))) {
        add(1, item);
      }
    }
    __syncthreads();
  }

  /// Calls visit(candidate) for each, shared out among the threads of a block.
  template <class Visit>
  __device__ void for_each(const Visit& visit) const {
    constexpr Index kWarps = kSearchThreads / kWarp;
    const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
    Index turn = static_cast<Index>(threadIdx.x) / kWarp;  // of the warp, among groups
    for (Index corners = 1; corners <= 3; ++corners) {
      const Index groups = (counts_[corners - 1] + kWarp - 1) / kWarp;
      for (; turn < groups; turn += kWarps) {
        const Index i = turn * kWarp + lane;
        if (i < counts_[corners - 1]) {
          visit(list(corners)[i]);
        }
      }
      turn -= groups;
    }
  }

 private:
  [[nodiscard]] __device__ const Index* list(Index corners) const {
    return corners == 1 ? vertices_ : (corners == 2 ? edges_ : triangles_);
  }
  __device__ void add(Index corners, Index candidate) {
    Index* const list = corners == 1 ? vertices_ : (corners == 2 ? edges_ : triangles_);
    list[atomicAdd(counts_ + corners - 1, 1)] = candidate;
  }

  template <int kCorners>
  __device__ static bool may_meet(const DeviceState& state, const Index (&places)[kCorners],
                                  const ContactBox& meeter) {
    ContactBox own;
#pragma unroll
    for (const Index place : places) {
      const CornerMotion motion = load_motion(state, place);
      own.add(motion.start, motion.end, 0);
    }
    return own.meets(meeter);
  }

  __device__ void find_triangle(const DeviceState& state, const SurfaceArrays& surfaces,
                                const MeeterInput& meeter, const ContactBox& box, Index of_vertices,
                                Index triangle) {
    if (!meeter.meets_triangles || triangle >= surfaces.triangle_count) {
      return;
    }
    const Index* const from = surfaces.triangles + 3 * static_cast<std::ptrdiff_t>(triangle);
    const Index places[3] = {__ldg(from), __ldg(from + 1), __ldg(from + 2)};
    if (places[0] == kInvalidIndex || !may_meet(state, places, box)) {
      return;
    }
    const Index first = of_vertices + kFeaturesOfTriangle * triangle;
#pragma unroll
    for (Index part = 0; part < 3; ++part) {
      if (is_own_edge(places[part], places[(part + 1) % 3])) {
        add(2, first + part);
      }
    }
    if (places[1] != places[2]) {  // no link
      add(3, first + 3);
    }
  }

  Index vertices_[kItems], edges_[3 * kItems], triangles_[kItems];
  Index counts_[3];  // by corners
};

/// Meets all candidates: as many blocks for each meeter.
__global__ void __launch_bounds__(kSearchThreads)
    meet_candidates(DeviceState state, ToolArrays tools, StepInput* input, Index substep,
                    bool remembers) {
  const Index vertices = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Index blocks = static_cast<Index>(gridDim.x) / surfaces.meeter_room;
  const Index m = static_cast<Index>(blockIdx.x) / blocks;
  if (m >= input->meeter_count) {
    return;
  }
  const Meeters meeters(surfaces, input, substep);
  __shared__ SharedRoom<NearCandidates> room;
  NearCandidates& near = room.get();
  near.find(state, surfaces, meeters.meeters[m], meeters.displacement(surfaces, m),
            static_cast<Index>(blockIdx.x) % blocks * NearCandidates::kItems, vertices);
  near.for_each([&](Index candidate) {
    DeviceContact found;
    if (find_contact(state, surfaces, meeters, m, candidate, vertices,
                     input->substep.inverse_dt_squared, remembers, found)) {
      const Index slot = atomicAdd(surfaces.met_counts + m, 1);
      if (slot < surfaces.tool_room) {
        surfaces.found[row_at(m, surfaces.tool_room) + static_cast<std::size_t>(slot)] = found;
      }
    }
  });
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
