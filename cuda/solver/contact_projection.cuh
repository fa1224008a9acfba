// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts one after another, as far as the order matters: by levels, those of one share no
/// corner. One block goes through them, or a part of it.
///
/// Arrays are SurfaceArrays or TouchArrays. Corners have load(place, root), store_if(moves, place,
/// root, particle) and kAreNear, whether to look at them costs little. A Moving is a contact of
/// these while it moves its corners, and knows its level, and its gap when it last looked.

#include "cuda/solver/contact_crew.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "cuda/solver/shared_contacts.cuh"
#include "lib/solver/methods/contact_multipliers.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// Corners that contacts move, near at hand in their block: each at its root, see
/// for_each_corner().
class StagedCorners {
 public:
  static constexpr bool kAreNear = true;

  /// @param at_roots  [holds]
  __device__ explicit StagedCorners(Particle* at_roots) : at_roots_(at_roots) {}

  [[nodiscard]] __device__ Particle load(Index /*place*/, Index root) const {
    return at_roots_[root];
  }
  __device__ void store_if(bool moves, Index /*place*/, Index root, const Particle& p) const {
    if (moves) {
      at_roots_[root] = p;
    }
  }

 private:
  Particle* at_roots_;
};

/// Likewise where they lie, in the memory that all blocks share.
class CornersInPlace {
 public:
  static constexpr bool kAreNear = false;

  __device__ explicit CornersInPlace(Particle* moving) : moving_(moving) {}

  [[nodiscard]] __device__ Particle load(Index place, Index /*root*/) const {
    return load_particle(moving_ + place);
  }
  __device__ void store_if(bool moves, Index place, Index /*root*/, const Particle& p) const {
    if (moves) {
      store_particle(moving_ + place, position_of(p), p.w);
    }
  }

 private:
  Particle* moving_;
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

  /// Once corners are known. A thread with more than one contact looks at each in for_each().
  template <class Corners>
  __device__ void begin(const Corners& corners) {
    if (has_one()) {
      one_.begin(corners);
    }
  }

  /// Once corners have moved.
  template <class Corners>
  __device__ void look(const Corners& corners) {
    if (has_one()) {
      one_.look(corners);
    }
  }

  /// @param visit  (contact): whether it has changed
  template <class Corners, class Visit>
  __device__ void for_each(const Corners& corners, const Visit& visit) {
    if (has_one()) {
      visit(one_);
    }
    for (Index c = thread(); count_ > threads_ && c < count_; c += threads_) {
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
    if (has_one()) {
      one_.put_back(arrays_, thread());
    }
  }

 private:
  [[nodiscard]] __device__ static Index thread() { return static_cast<Index>(threadIdx.x); }
  [[nodiscard]] __device__ bool has_one() const { return count_ <= threads_ && thread() < count_; }

  const Arrays& arrays_;
  Index count_, threads_;
  Moving one_;
};

/// The first level from one on that has a contact of which something is true, or kNoLevel.
/// @param is_wanted  (contact)
template <class Crew, class Own, class Corners, class IsWanted>
__device__ __forceinline__ Index next_level(Crew& crew, Own& own, const Corners& corners,
                                            Index first, const IsWanted& is_wanted) {
  Index own_level = kNoLevel;
  own.for_each(corners, [&](const auto& contact) {
    if (contact.level >= first && contact.level < own_level && is_wanted(contact)) {
      own_level = contact.level;
    }
    return false;
  });
  return crew.least(own_level);
}

/// All contacts, one level after another. Where few act, and corners are near, from one level with
/// such a contact to the next, which takes half as long again for a level.
/// @param crew  all of a block, or a warp
template <class Crew, class Own, class Corners>
__device__ __forceinline__ void project(Crew& crew, Own& own, const Corners& corners,
                                        Index levels) {
  const auto acts = [](const auto& contact) { return contact.acts(); };
  bool skips = false;
  if constexpr (Corners::kAreNear) {
    bool acts_any = false;
    own.for_each(corners, [&](const auto& contact) {
      acts_any = acts_any || acts(contact);
      return false;
    });
    skips = 3 * crew.count(acts_any) < 2 * levels;
  }
  for (Index level = 0;; ++level) {
    level = skips ? next_level(crew, own, corners, level, acts) : level;
    if (level >= levels) {
      return;
    }
    own.project(corners, level);
    crew.wait();
    if (skips) {
      own.look(corners);
    }
  }
}

/// Pushes contacts out that are inside when it is their turn, without friction: from one level with
/// such a contact to the next.
/// @param crew  all of a block, or a warp
/// @return      whether any was inside
template <class Crew, class Own, class Corners>
__device__ __forceinline__ bool push_out(Crew& crew, Own& own, const Corners& corners) {
  const auto is_inside = [](const auto& contact) { return contact.gap < 0; };
  bool is_any_inside = false;
  for (Index first = 0;;) {
    const Index level = next_level(crew, own, corners, first, is_inside);
    if (level == kNoLevel) {
      return is_any_inside;
    }
    is_any_inside = true;
    own.for_each(corners, [&](auto& contact) {
      const bool moves = contact.level == level && is_inside(contact);
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
/// corners are near at hand, of as many contacts as there are threads; of more, these are where
/// they lie. All threads of the only block of a copy call it.
/// @param count  of contacts
template <class Moving, int kThreads, int kCorners, class Arrays, class Work>
__device__ __forceinline__ void go_through_contacts(const DeviceState& state, const Arrays& arrays,
                                                    Index count, const Work& work) {
  struct Stage {
    Particle at_roots[kCorners * kThreads];
    CrewBoard board;
  };
  __shared__ SharedRoom<Stage> room;
  if (count == 0) {
    return;
  }
  const auto go_through = [&](const auto& corners) {
    OwnContacts<Arrays, Moving> own(arrays, count, kThreads);
    __syncthreads();
    ContactCrew crew(count, room.get().board, [] { __syncthreads(); });
    if (crew.has_this_thread()) {
      own.begin(corners);
      crew.wait();
      work(crew, own, corners);
      own.end();
    }
    __syncthreads();
  };
  Particle* const moving = moving_of(state);
  if (count > kThreads) {
    go_through(CornersInPlace(moving));
    return;
  }
  Particle* const at_roots = room.get().at_roots;
  for_each_corner(arrays, kCorners * count, kThreads,
                  [&](Index place, Index root) { at_roots[root] = load_particle(moving + place); });
  go_through(StagedCorners(at_roots));
  for_each_corner(arrays, kCorners * count, kThreads, [&](Index place, Index root) {
    store_particle(moving + place, position_of(at_roots[root]), at_roots[root].w);
  });
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
