// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts one after another, as far as the order matters: by levels, those of one share no
/// corner. One block goes through them, or a part of it.
///
/// Arrays are SurfaceArrays or TouchArrays. A Moving is a contact of these while it moves its
/// corners, and knows its level, and its gap when it last looked.

#include "cuda/solver/contact_crew.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/shared_contacts.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// Corners that contacts move, in the memory that all blocks share: near at hand, each once, of as
/// many contacts as there are threads; where they lie, of more.
/// @tparam kThreads  of the block
/// @tparam kCorners  of a contact
template <class Arrays, int kThreads, int kCorners>
class MovingCorners {
 public:
  struct Stage {
    Particle at_roots[kCorners * kThreads];
  };

  __device__ MovingCorners(const DeviceState& state, const Arrays& arrays, Index count,
                           Stage& stage)
      : moving_(moving_of(state)),
        arrays_(arrays),
        stage_(count <= kThreads ? &stage : nullptr),
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
      for_each_corner(arrays_, kCorners * count_, kThreads, visit);
    }
  }

  Particle* moving_;
  const Arrays& arrays_;
  Stage* stage_;
  Index count_;
};

/// The contacts of a thread: in registers if it has but one.
template <class Arrays, class Moving>
class OwnContacts {
 public:
  /// @param count    of all
  /// @param threads  that have them, this one included
  __device__ OwnContacts(const Arrays& arrays, Index count, Index threads)
      : arrays_(arrays),
        count_(count),
        threads_(threads),
        one_(arrays, thread() < count ? thread() : 0) {}

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
      Moving contact(arrays_, c);
      contact.begin(corners);
      if (visit(contact)) {
        contact.put_back(arrays_, c);
      }
    }
  }

  /// All of one level.
  template <class Corners>
  __device__ void project(const Corners& corners, Index level) {
    for_each(corners, [&](Moving& contact) {
      if (contact.level == level) {
        contact.project(corners);
      }
      return contact.level == level;
    });
  }

  /// Puts them back.
  __device__ void end() const {
    if (count_ <= threads_ && thread() < count_) {
      one_.put_back(arrays_, thread());
    }
  }

 private:
  [[nodiscard]] __device__ static Index thread() { return static_cast<Index>(threadIdx.x); }

  const Arrays& arrays_;
  Index count_, threads_;
  Moving one_;
};

/// All contacts, one level after another.
template <class Crew, class Own, class Corners>
__device__ __forceinline__ void project(const Crew& crew, Own& own, const Corners& corners,
                                        Index levels) {
  for (Index level = 0; level < levels; ++level) {
    own.project(corners, level);
    crew.wait();
  }
}

/// Pushes contacts out that are inside when it is their turn, without friction: from one level with
/// such a contact to the next.
/// @param crew  all of a block, or a warp
/// @return      whether any was inside
template <class Crew, class Own, class Corners>
__device__ __forceinline__ bool push_out(const Crew& crew, Own& own, const Corners& corners) {
  bool is_any_inside = false;
  for (Index first = 0;;) {
    Index own_level = kNoLevel;
    own.for_each(corners, [&](const auto& contact) {
      if (contact.gap < 0 && contact.level >= first && contact.level < own_level) {
        own_level = contact.level;
      }
      return false;
    });
    const Index level = crew.least(own_level);
    if (level == kNoLevel) {
      return is_any_inside;
    }
    is_any_inside = true;
    own.for_each(corners, [&](auto& contact) {
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

/// Calls work(crew, own, corners) of the threads that go through contacts, once they and their
/// corners are near at hand. All threads of the only block of a copy call it.
/// @param count  of contacts
template <class Moving, int kThreads, int kCorners, class Arrays, class Work>
__device__ __forceinline__ void go_through_contacts(const DeviceState& state, const Arrays& arrays,
                                                    Index count, const Work& work) {
  using Corners = MovingCorners<Arrays, kThreads, kCorners>;
  if (count == 0) {
    return;
  }
  __shared__ SharedRoom<typename Corners::Stage> room;
  const Corners corners(state, arrays, count, room.get());
  OwnContacts<Arrays, Moving> own(arrays, count, kThreads);
  __syncthreads();
  const ContactCrew crew(count, [] { __syncthreads(); });
  if (crew.has_this_thread()) {
    own.begin(corners);
    crew.wait();
    work(crew, own, corners);
    own.end();
  }
  __syncthreads();
  corners.store_all();
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
