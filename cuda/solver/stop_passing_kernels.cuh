// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What has come through a tool goes along with it instead: see stop_passing.h.

#include "cuda/solver/surface_contact.cuh"
#include "cuda/solver/surface_search_kernels.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/passing.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kStopThreads = 512;

/// m, the longest of a vertex of sheets and threads; for all threads of a block.
__device__ inline float farthest_way(const DeviceState& state, const SurfaceArrays& surfaces) {
  __shared__ int farthest;  // bits: of what is not negative, they have the order of numbers
  if (threadIdx.x == 0) {
    farthest = 0;
  }
  __syncthreads();
  float square = 0;
  for (Index corner = static_cast<Index>(threadIdx.x); corner < 3 * surfaces.thin_count;
       corner += kStopThreads) {
    const Index place = __ldg(surfaces.thin + corner);
    if (place != kInvalidIndex) {
      const CornerMotion motion = load_motion(state, place);
      const Vec3<float> way = motion.end - motion.start;
      const float own = dot(way, way);
      square = square < own ? own : square;
    }
  }
  atomicMax(&farthest, __float_as_int(square));
  __syncthreads();
  return sqrtf(__int_as_float(farthest));
}

/// What one tool takes along, by all threads of a block.
class ToolPassing {
 public:
  __device__ ToolPassing(const DeviceState& state, const SurfaceArrays& surfaces,
                         const MeeterInput& meeter, const SweptCapsule* swept, Index index,
                         Index vertices)
      : state_(state),
        surfaces_(surfaces),
        meeter_(meeter),
        swept_(swept),
        index_(index),
        vertices_(vertices) {}

  /// Whether anything has gone far enough, or may not have been met for want of room.
  /// @param farthest  m, of a vertex
  [[nodiscard]] __device__ bool may_pass(float farthest) const {
    const Index first = __ldcg(surfaces_.ends + index_), end = __ldcg(surfaces_.ends + index_ + 1);
    bool may = end - first >= surfaces_.tool_room;
    for (Index c = static_cast<Index>(threadIdx.x); c < meeter_.capsule_count; c += kStopThreads) {
      const SweptCapsule capsule = swept(c);
      may |= !(farthest + capsule.way() < way_through(capsule.before));
    }
    for (Index i = first + static_cast<Index>(threadIdx.x); i < end; i += kStopThreads) {
      const SurfaceContact& contact = surfaces_.contacts[i].contact;
      if (contact.capsule == kInvalidIndex) {
        continue;
      }
      const SweptCapsule capsule = swept(contact.capsule);
      may |= !(farthest + capsule.way() < way_through(capsule.before, corners_of(contact.feature)));
    }
    return __syncthreads_or(may ? 1 : 0) != 0;
  }

  /// @param feel  (count, at), of those that are new: see cuda::feel()
  template <class Feel>
  __device__ void stop(const Feel& feel_new) const {
    bool stays = false;
    for (int pass = 0; pass < kStopPasses; ++pass) {
      Look look;
      for (Index t = static_cast<Index>(threadIdx.x); t < surfaces_.thin_count; t += kStopThreads) {
        look_at(t, look);
      }
      if (__syncthreads_or(look.meets_wall && !stays ? 1 : 0) != 0) {
        stays = true;
        stay();
        continue;
      }
      if (__syncthreads_or(look.finds ? 1 : 0) == 0) {
        break;
      }
      const Index count = list_new();
      for (Index i = static_cast<Index>(threadIdx.x); i < count; i += kStopThreads) {
        take_along(surfaces_.stopped[i]);
      }
      __syncthreads();
      feel_new(count);
    }
    for (Index place = static_cast<Index>(threadIdx.x); place < vertices_; place += kStopThreads) {
      surfaces_.passed[place] = kNothing;
    }
    __syncthreads();
  }

 private:
  // Of SurfaceArrays::passed: capsules are from 0 on.
  static constexpr Index kNothing = kNothingPassed, kTaken = -1;

  [[nodiscard]] __device__ SweptCapsule swept(Index capsule) const {
    const ToolSpring& spring = surfaces_.springs[index_];
    const SweptCapsule& own = swept_[capsule];
    return {own.before.moved(spring.displacement),
            own.now.moved(spring.displacement + spring.shift)};
  }

  [[nodiscard]] __device__ FeatureCorners corners_of(const ContactFeature& feature) const {
    FeatureCorners corners;
    corners.count = feature.count();
    for (int k = 0; k < 3; ++k) {
      corners.places[k] = feature.places[k];
    }
    load_corners(state_, corners);
    return corners;
  }

  struct Look {
    bool finds = false;       // corners that have come through and are not known to
    bool meets_wall = false;  // or fixed ones, and the tool gives way
  };

  __device__ void look_at(Index triangle, Look& look) const {
    const Index* const places = surfaces_.thin + 3 * static_cast<std::ptrdiff_t>(triangle);
    FeatureCorners corners;
    corners.count = 3;
    for (int k = 0; k < 3; ++k) {
      corners.places[k] = __ldg(places + k);
    }
    if (corners.places[0] == kInvalidIndex) {
      return;
    }
    load_corners(state_, corners);
    const ContactBox box = box_of(corners);
    for (Index c = 0; c < meeter_.capsule_count; ++c) {
      const SweptCapsule capsule = swept(c);
      if (!box.meets(core_box(capsule))) {
        continue;
      }
      const Passing passing(capsule, corners);
      for (int k = 0; k < 3; ++k) {
        if (!passing.has(k)) {
          continue;
        }
        if (corners.is_fixed[k]) {
          look.meets_wall |= meeter_.compliance > 0;
        } else {
          look.finds |= atomicMin(surfaces_.passed + corners.places[k], c) > kTaken;
        }
      }
    }
  }

  // What its contacts say of sides may be what took it there.
  __device__ void stay() const {
    for (Index place = static_cast<Index>(threadIdx.x); place < vertices_; place += kStopThreads) {
      if (__ldcg(surfaces_.passed + place) != kTaken) {
        surfaces_.passed[place] = kNothing;
      }
    }
    if (threadIdx.x == 0) {
      surfaces_.springs[index_].shift = -1.0F * meeter_.told;
    }
    __syncthreads();
    const Index end = __ldcg(surfaces_.ends + index_ + 1);
    for (Index i = __ldcg(surfaces_.ends + index_) + static_cast<Index>(threadIdx.x); i < end;
         i += kStopThreads) {
      SurfaceContact& contact = surfaces_.contacts[i].contact;
      if (contact.capsule != kInvalidIndex) {
        take_side(corners_of(contact.feature), swept(contact.capsule), contact);
      }
    }
    __syncthreads();
  }

  // In the order of places.
  // @return  how many
  __device__ Index list_new() const {
    constexpr int kWarps = kStopThreads / kWarp;
    __shared__ Index of_warps[kWarps];
    const int lane = static_cast<int>(threadIdx.x) % kWarp,
              warp = static_cast<int>(threadIdx.x) / kWarp;
    Index count = 0;
    for (Index first = 0; first < vertices_; first += kStopThreads) {
      const Index place = first + static_cast<Index>(threadIdx.x);
      const Index capsule = place < vertices_ ? __ldcg(surfaces_.passed + place) : kNothing;
      const bool is_new = capsule != kNothing && capsule != kTaken;
      const unsigned all = __ballot_sync(~0U, is_new);
      if (lane == 0) {
        of_warps[warp] = __popc(all);
      }
      __syncthreads();
      Index rank = count + __popc(all & ((1U << lane) - 1));
      for (int w = 0; w < kWarps; ++w) {
        rank += w < warp ? of_warps[w] : 0;
        count += of_warps[w];
      }
      if (is_new) {
        surfaces_.stopped[rank] = {place, capsule, {}, {}};
        surfaces_.passed[place] = kTaken;
      }
      __syncthreads();
    }
    return count;
  }

  __device__ void take_along(DeviceStopped& stopped) const {
    Particle* const moving = moving_of(state_) + stopped.place;
    const Particle p = load_particle(moving);
    const Vec3<float> base = base_of(state_, stopped.place);
    const Vec3<float> before = base + position_of(p);
    const Vec3<float> along =
        taken_along(swept(stopped.capsule), load_motion(state_, stopped.place).start);
    Vec3<float> after = position_of(p) + (along - before);
    after = is_finite_way(after) ? after : position_of(p);
    store_particle(moving, after, p.w);
    stopped.point = base + after;
    stopped.push = (1 / p.w) * (stopped.point - before);
  }

  const DeviceState& state_;
  const SurfaceArrays& surfaces_;
  const MeeterInput& meeter_;
  const SweptCapsule* swept_;
  Index index_;
  Index vertices_;
};

/// One block a copy: nearly always, nothing has gone far enough.
__global__ void __launch_bounds__(kStopThreads)
    stop(DeviceState state, ToolArrays tools, StepInput* input, Index substep) {
  const Index vertices = vertex_count(input);
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Meeters meeters(surfaces, input, substep);
  const float farthest = farthest_way(state, surfaces);
  for (Index t = 0; t < input->tool_count; ++t) {
    const Index m = table<ToolInput>(input, input->tools)[t].meeter;
    if (m == kInvalidIndex || !meeters.meeters[m].meets_triangles) {
      continue;
    }
    const MeeterInput& meeter = meeters.meeters[m];
    const ToolPassing passing(state, surfaces, meeter, meeters.swept + meeter.first_capsule, m,
                              vertices);
    if (!passing.may_pass(farthest)) {
      continue;
    }
    passing.stop([&](Index count) {
      feel<kStopThreads>(table<Wrench>(input, input->wrenches)[t],
                         origin_of(input, substep, t, surfaces, m), count,
                         [&](Index i, Vec3<float>& force, Vec3<float>& point) {
                           force = input->force_per_multiplier * surfaces.stopped[i].push;
                           point = surfaces.stopped[i].point;
                         });
    });
  }
}

void stop_passing(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                  Index substep, const Launch& how) {
  launch(how, "launching the stop of what passes", 1, kStopThreads, stop, state, tools, input,
         substep);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
