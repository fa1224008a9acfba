// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Threads that go through contacts together.

#include <limits>

#include "cuda/solver/kernel_support.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// Behind all levels of contacts.
constexpr Index kNoLevel = std::numeric_limits<Index>::max();

__device__ inline Index least_of_warp(Index own) {
#if defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 800
  return __reduce_min_sync(~0U, own);
#else
  for (int distance = kWarp / 2; distance > 0; distance /= 2) {
    const Index other = __shfl_xor_sync(~0U, own, distance);
    own = other < own ? other : own;
  }
  return own;
#endif
}

__device__ inline float least_of_warp(float own) {
  for (int distance = kWarp / 2; distance > 0; distance /= 2) {
    const float other = __shfl_xor_sync(~0U, own, distance);
    own = other < own ? other : own;
  }
  return own;
}

/// What threads of a crew tell each other, in shared memory.
struct CrewBoard {
  Index leasts[3];
  Index total;
};

/// Where a warp has a thread for each contact, it goes alone, for it waits for itself in a fraction
/// of the time; else all threads of a block do.
/// @tparam Meet  () of all threads that have contacts
template <class Meet>
class ContactCrew {
 public:
  /// All wait() once before they do anything else.
  /// @param contacts  how many
  /// @param board     of no other crew meanwhile
  __device__ ContactCrew(Index contacts, CrewBoard& board, const Meet& meet)
      : is_warp_(contacts <= kWarp), board_(board), meet_(meet) {
    if (threadIdx.x == 0) {
      board.leasts[0] = kNoLevel;
      board.total = 0;
    }
  }

  [[nodiscard]] __device__ bool has_this_thread() const { return !is_warp_ || threadIdx.x < kWarp; }

  /// Until all have come here; then each sees what the others have stored.
  __device__ void wait() const {
    if (is_warp_) {
      __syncwarp();
    } else {
      meet_();
    }
  }

  /// Of all threads.
  [[nodiscard]] __device__ Index least(Index own) {
    const Index of_warp = least_of_warp(own);
    if (is_warp_) {
      return of_warp;
    }
    // of three places one is read, the next made ready, and none of them still read by anyone
    Index& of_all = board_.leasts[turn_];
    turn_ = turn_ == 2 ? 0 : turn_ + 1;
    if (threadIdx.x == 0) {
      board_.leasts[turn_] = kNoLevel;
    }
    if (threadIdx.x % kWarp == 0 && of_warp != kNoLevel) {
      atomicMin(&of_all, of_warp);
    }
    meet_();
    return of_all;
  }

  /// Of how many threads it is true; once.
  [[nodiscard]] __device__ Index count(bool own) const {
    const Index of_warp = __popc(__ballot_sync(~0U, own));
    if (is_warp_) {
      return of_warp;
    }
    if (threadIdx.x % kWarp == 0 && of_warp > 0) {
      atomicAdd(&board_.total, of_warp);
    }
    meet_();
    return board_.total;
  }

 private:
  bool is_warp_;
  CrewBoard& board_;
  Meet meet_;
  int turn_ = 0;
};

/// Finds the levels of contacts: those of one do not share what one of them moves. A warp does it,
/// for 32 contacts at a time.
/// @param levels      [count]
/// @param befores_of  (c, before[4]): the last contact before that one which shares something with
/// it,
///                    for each of up to four things, or leaves kInvalidIndex
/// @return            how many levels there are
template <class Befores>
__device__ inline Index find_levels(Index count, Index* levels, const Befores& befores_of) {
  const auto later = [](Index a, Index b) { return a < b ? b : a; };
  const Index lane = static_cast<Index>(threadIdx.x) % kWarp;
  Index most = -1;
  for (Index first = 0; first < count; first += kWarp) {
    const Index c = first + lane;
    Index befores[4] = {kInvalidIndex, kInvalidIndex, kInvalidIndex, kInvalidIndex};
    if (c < count) {
      befores_of(c, befores);
    }
    Index of_earlier = -1;
#pragma unroll
    for (Index& before : befores) {
      if (before != kInvalidIndex && before < first) {
        of_earlier = later(of_earlier, levels[before]);
        before = kInvalidIndex;
      }
    }
    Index level = c < count ? kNoLevel : -1;
    while (__any_sync(~0U, level == kNoLevel) != 0) {
      Index last = of_earlier;
#pragma unroll
      for (const Index before : befores) {
        const Index met = __shfl_sync(~0U, level, before == kInvalidIndex ? lane : before - first);
        last = before == kInvalidIndex ? last : later(last, met);
      }
      level = level == kNoLevel && last != kNoLevel ? last + 1 : level;
    }
    if (c < count) {
      levels[c] = level;
      most = later(most, level);
    }
    __syncwarp();
  }
  return 1 - least_of_warp(-most);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
