// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts with surfaces one after another, as far as the order matters: by levels, see
/// SurfaceArrays. One block goes through them.

#include "cuda/solver/contact_crew.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/tool_kernels.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kProjectThreads = 256;

/// Corners that contacts move, in the memory that all blocks share: near at hand, each once, of as
/// many contacts as there are threads; where they lie, of more.
class MovingCorners {
 public:
  struct Stage {
    Particle at_roots[3 * kProjectThreads];
  };

  __device__ MovingCorners(const DeviceState& state, const SurfaceArrays& surfaces, Index count,
                           Stage& stage)
      : moving_(moving_of(state)),
        surfaces_(surfaces),
        stage_(count <= kProjectThreads ? &stage : nullptr),
        count_(count) {
    for_each_staged(
        [&](Index place, Index root) { stage_->at_roots[root] = load_particle(moving_ + place); });
  }

  /// Puts them back where they lie.
  __device__ void store_all() const {
    for_each_staged([&](Index place, Index root) {
      const Particle& p = stage_->at_roots[root];
      store_particle(moving_ + place, position_of(p), p.w);
    });
  }

  [[nodiscard]] __device__ Particle load(Index place, Index root) const {
    return stage_ != nullptr ? stage_->at_roots[root] : load_particle(moving_ + place);
  }
  __device__ void store(Index place, Index root, const Particle& p) const {
    if (stage_ != nullptr) {
      stage_->at_roots[root] = p;
    } else {
      store_particle(moving_ + place, position_of(p), p.w);
    }
  }

 private:
  template <class Visit>
  __device__ void for_each_staged(const Visit& visit) const {
    if (stage_ != nullptr) {
      for_each_corner(surfaces_, count_, kProjectThreads, visit);
    }
  }

  Particle* moving_;
  const SurfaceArrays& surfaces_;
  Stage* stage_;
  Index count_;
};

/// A contact while it moves its corners.
struct MovingContact {
  DeviceContact stored;
  Index level;
  Index roots[3];
  ToolSpring* spring;  ///< null if its tool has none
  float stiffness;     ///< kg, see project_contact()
  float gap;           ///< m, when it last looked

  __device__ MovingContact(const SurfaceArrays& surfaces, Index c)
      : stored(surfaces.contacts[c]), level(surfaces.levels[c]) {
    for (int k = 0; k < 3; ++k) {
      roots[k] = surfaces.roots[3 * c + k];
    }
    spring = spring_of(surfaces, stored);
  }

  /// Once corners are known.
  template <class Corners>
  __device__ void begin(const Corners& corners) {
    float yield = spring == nullptr ? 0 : spring->yield;
    for_each_corner([&](int k) {
      yield += stored.contact.weights[k] * stored.contact.weights[k] * load(corners, k).w;
    });
    stiffness = stiffness_of(yield);
    look(corners);
  }

  template <class Corners>
  __device__ void look(const Corners& corners) {
    gap = read(corners).gap;
  }

  template <class Corners>
  [[nodiscard]] __device__ ContactReading<float> read(const Corners& corners) const {
    Vec3<float> sum;
    for_each_corner(
        [&](int k) { sum = sum + stored.contact.weights[k] * position_of(load(corners, k)); });
    return read_plane(stored.contact, sum - (spring == nullptr ? Vec3<float>{} : spring->shift));
  }

  template <class Corners>
  __device__ void project(const Corners& corners) {
    project_contact(
        stored.contact, stored.friction, stiffness, [&] { return read(corners); },
        [&](const Vec3<float>& push) { move(corners, push); });
  }

  /// Out of the plane alone, which it has just looked at.
  template <class Corners>
  __device__ void push_out(const Corners& corners) {
    push_contact_out(stored.contact, stiffness, {gap, {}},
                     [&](const Vec3<float>& push) { move(corners, push); });
  }

 private:
  template <class Visit>
  __device__ void for_each_corner(const Visit& visit) const {
#pragma unroll
    for (int k = 0; k < 3; ++k) {
      if (stored.contact.feature.places[k] != kInvalidIndex) {
        visit(k);
      }
    }
  }
  template <class Corners>
  [[nodiscard]] __device__ Particle load(const Corners& corners, int k) const {
    return corners.load(stored.contact.feature.places[k], roots[k]);
  }
  template <class Corners>
  __device__ void move(const Corners& corners, const Vec3<float>& push) {
    if (spring != nullptr) {
      spring->shift = spring->shift - spring->yield * push;
    }
    for_each_corner([&](int k) {
      const Particle p = load(corners, k);
      const Vec3<float> after = position_of(p) + (stored.contact.weights[k] * p.w) * push;
      if (is_finite_way(after)) {
        corners.store(stored.contact.feature.places[k], roots[k], {after.x, after.y, after.z, p.w});
      }
    });
  }
};

/// The contacts of a thread: in registers if it has but one.
class OwnContacts {
 public:
  /// @param count    of all
  /// @param threads  that have them, this one included
  __device__ OwnContacts(const SurfaceArrays& surfaces, Index count, Index threads)
      : surfaces_(surfaces),
        count_(count),
        threads_(threads),
        one_(surfaces, thread() < count ? thread() : 0) {}

  /// Once corners are known.
  template <class Corners>
  __device__ void begin(const Corners& corners) {
    one_.begin(corners);
  }

  /// Once corners have moved. Where a thread has more than one contact, it looks at each anew.
  template <class Corners>
  __device__ void look(const Corners& corners) {
    one_.look(corners);
  }

  /// @param visit  (contact): whether it has changed
  template <class Corners, class Visit>
  __device__ void for_each(const Corners& corners, const Visit& visit) {
    if (count_ <= threads_) {
      if (thread() < count_) {
        visit(one_);
      }
      return;
    }
    for (Index c = thread(); c < count_; c += threads_) {
      MovingContact contact(surfaces_, c);
      contact.begin(corners);
      if (visit(contact)) {
        surfaces_.contacts[c].contact = contact.stored.contact;
      }
    }
  }

  /// All of one level.
  template <class Corners>
  __device__ void project(const Corners& corners, Index level) {
    for_each(corners, [&](MovingContact& contact) {
      if (contact.level == level) {
        contact.project(corners);
      }
      return contact.level == level;
    });
  }

  /// Puts them back.
  __device__ void end() const {
    if (count_ <= threads_ && thread() < count_) {
      surfaces_.contacts[thread()].contact = one_.stored.contact;
    }
  }

 private:
  [[nodiscard]] __device__ static Index thread() { return static_cast<Index>(threadIdx.x); }

  const SurfaceArrays& surfaces_;
  Index count_, threads_;
  MovingContact one_;
};

/// All contacts, one level after another.
template <class Crew, class Corners>
__device__ __forceinline__ void project(const Crew& crew, OwnContacts& own, const Corners& corners,
                                        Index levels) {
  for (Index level = 0; level < levels; ++level) {
    own.project(corners, level);
    crew.wait();
  }
}

/// See settle_surface_contacts(). From one level with a contact inside to the next.
/// @param crew  all of a block, or a warp
template <class Crew, class Corners>
__device__ __forceinline__ void settle(const Crew& crew, OwnContacts& own, const Corners& corners) {
  bool is_any_inside = true;
  for (int pass = 0; pass < kSettlePasses && is_any_inside; ++pass) {
    is_any_inside = false;
    for (Index first = 0;;) {
      Index own_level = kNoLevel;
      own.for_each(corners, [&](const MovingContact& contact) {
        if (contact.gap < 0 && contact.level >= first && contact.level < own_level) {
          own_level = contact.level;
        }
        return false;
      });
      const Index level = crew.least(own_level);
      if (level == kNoLevel) {
        break;
      }
      is_any_inside = true;
      own.for_each(corners, [&](MovingContact& contact) {
        const bool moves = contact.gap < 0 && contact.level == level;
        if (moves) {
          contact.push_out(corners);
        }
        return moves;
      });
      crew.wait();
      own.look(corners);
      first = level + 1;
    }
  }
  own.for_each(corners, [&](MovingContact& contact) {
    contact.stored.contact.is_left_inside = is_left_inside(contact.read(corners));
    return true;
  });
}

/// Moves corners by their masses: the bits of one contact after another. One block a copy.
/// @tparam kSettles  only those that are inside, without friction
template <bool kSettles>
__global__ void __launch_bounds__(kProjectThreads, 1)
    project_surfaces(DeviceState state, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  const Index count = contact_count(surfaces);
  if (count == 0) {
    return;
  }
  __shared__ SharedRoom<MovingCorners::Stage> room;
  const MovingCorners corners(state, surfaces, count, room.get());
  OwnContacts own(surfaces, count, kProjectThreads);
  __syncthreads();
  const ContactCrew crew(count, [] { __syncthreads(); });
  if (crew.has_this_thread()) {
    own.begin(corners);
    crew.wait();
    if constexpr (kSettles) {
      settle(crew, own, corners);
    } else {
      project(crew, own, corners, __ldcg(surfaces.level_counts));
    }
    own.end();
  }
  __syncthreads();
  corners.store_all();
}

void project_surface_contacts(const DeviceState& state, const ToolArrays& tools, bool settles,
                              const Launch& how) {
  launch(how, "launching contacts with surfaces", 1, kProjectThreads,
         settles ? project_surfaces<true> : project_surfaces<false>, state, tools);
}

/// Of BDF2, as ease() for vertices that tools push: by levels. One block a copy.
__global__ void __launch_bounds__(kProjectThreads)
    ease_surfaces(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const SurfaceArrays surfaces = of_copy(tools, state.capacity).surfaces;
  input += copy_index();
  const Index count = contact_count(surfaces);
  const Index levels = __ldcg(surfaces.level_counts);
  for (Index level = 0; level < levels; ++level) {
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kProjectThreads) {
      const DeviceContact& stored = surfaces.contacts[c];
      const SurfaceContact& contact = stored.contact;
      if (surfaces.levels[c] != level || !(contact.multiplier > 0) || contact.is_eased) {
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
