// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How bodies answer each other in a substep: see touch_response.h.

#include "cuda/solver/contact_projection.cuh"
#include "cuda/solver/surface_answer_kernels.cuh"
#include "cuda/solver/touch_contact.cuh"
#include "cuda/solver/vertex_kernels.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

// A warp each, so that many multiprocessors load and store contacts, which lie far apart.
constexpr int kWarpBlocks = 32;

constexpr int kMoveThreads = 512;  // as many contacts are near at hand

/// A contact while it moves its corners, all or none: momentum is theirs together.
struct MovingTouch {
  TissueTouch touch;
  Index level;
  Index roots[TissueTouch::kCorners];
  float stiffness;  ///< kg, see project_contact()
  float gap;        ///< m, when it last looked

  __device__ MovingTouch(const TouchArrays& touches, Index c)
      : touch(touches.contacts[c]), level(touches.levels[c]) {
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      // a contact depends on its first corner, which stands for those that it does not depend on
      roots[k] = touches.roots[TissueTouch::kCorners * c + (touch.weights[k] != 0 ? k : 0)];
    }
  }

  /// Once corners are known.
  template <class Corners>
  __device__ void begin(const Corners& corners) {
    const At at(*this, corners);
    float yield = 0;
#pragma unroll
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      yield += touch.weights[k] * touch.weights[k] * at.corners[k].w;
    }
    stiffness = stiffness_of(yield);
    gap = read(at).gap;
  }

  template <class Corners>
  __device__ void look(const Corners& corners) {
    gap = read(At(*this, corners)).gap;
  }

  /// After look().
  [[nodiscard]] __device__ bool acts() const {
    return pbdsurg::acts(touch, gap);
  }

  template <class Corners>
  __device__ void project(const Corners& corners) {
    At at(*this, corners);
    project_contact(
        touch, touch.mu, stiffness, [&] { return read(at); },
        [&](const Vec3<float>& push) { at.move(touch, push); });
    put_back(at, corners);
  }

  /// Out of the plane alone, which it has just looked at.
  template <class Corners>
  __device__ void push_out(const Corners& corners) {
    At at(*this, corners);
    push_contact_out(touch, stiffness, {gap, {}},
                     [&](const Vec3<float>& push) { at.move(touch, push); });
    put_back(at, corners);
  }

  __device__ void put_back(const TouchArrays& touches, Index c) const {
    touches.contacts[c].multiplier = touch.multiplier;
    touches.contacts[c].friction = touch.friction;
  }

 private:
  /// Where the corners are: all are asked for before any is needed.
  struct At {
    Particle corners[TissueTouch::kCorners];
    bool has_moved = false;

    template <class Corners>
    __device__ At(const MovingTouch& own, const Corners& all) {
#pragma unroll
      for (int k = 0; k < TissueTouch::kCorners; ++k) {
        corners[k] = all.load(own.touch.places[k], own.roots[k]);
      }
    }

    __device__ void move(const TissueTouch& touch, const Vec3<float>& push) {
      Vec3<float> after[TissueTouch::kCorners];
      bool are_finite = true;
#pragma unroll
      for (int k = 0; k < TissueTouch::kCorners; ++k) {
        after[k] = position_of(corners[k]) + (touch.weights[k] * corners[k].w) * push;
        are_finite = are_finite && is_finite_way(after[k]);
      }
      has_moved = has_moved || are_finite;
#pragma unroll
      for (int k = 0; k < TissueTouch::kCorners; ++k) {
        const Vec3<float> x = are_finite ? after[k] : position_of(corners[k]);
        corners[k] = {x.x, x.y, x.z, corners[k].w};
      }
    }
  };

  [[nodiscard]] __device__ ContactReading<float> read(const At& at) const {
    Vec3<float> sums[2];
#pragma unroll
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      const Vec3<float> part = touch.weights[k] * position_of(at.corners[k]);
      if (touch.side_of(k) == 0) {
        sums[0] = sums[0] + part;
      } else {
        sums[1] = sums[1] + part;
      }
    }
    return read_plane(touch, sums[0] + sums[1]);
  }

  template <class Corners>
  __device__ void put_back(const At& at, const Corners& corners) const {
#pragma unroll
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      corners.store_if(at.has_moved && touch.weights[k] != 0, touch.places[k], roots[k],
                       at.corners[k]);
    }
  }
};

/// @tparam kSettles  only those that are inside, without friction
template <bool kSettles>
__global__ void __launch_bounds__(kMoveThreads, 1)
    move_touches(DeviceState state, ToolArrays tools) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  go_through_contacts<MovingTouch, kMoveThreads, TissueTouch::kCorners>(
      state, touches, contact_count(touches), [&](auto& crew, auto& own, const auto& corners) {
        if constexpr (kSettles) {
          push_out(crew, own, corners);
        } else {
          project(crew, own, corners, __ldcg(touches.level_counts));
        }
      });
}

/// Before the sweeps of vertex blocks: how stiffly bodies meet.
void begin_touches(const DeviceState& state, const VertexArrays& vertices, const ToolArrays& tools,
                   StepInput* input, Index substep, const Launch& how) {
  launch_yields<TouchArrays>(how, "launching how bodies are met", state, vertices, tools, input,
                             substep);
}

void project_touches(const DeviceState& state, const ToolArrays& tools, bool settles,
                     const Launch& how) {
  launch(how, "launching contacts of bodies", 1, kMoveThreads,
         settles ? move_touches<true> : move_touches<false>, state, tools);
}

/// Where vertices are when a sweep of vertex blocks begins; and before, multipliers become the
/// forces of the contacts.
/// @tparam kAnswers  whether they do
template <bool kAnswers>
__global__ void __launch_bounds__(kToolThreads)
    see_touches(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Index count = contact_count(touches);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    TissueTouch touch = touches.contacts[c];
    TissueTouch& stored = touches.contacts[c];
    stored.seen[0] = touch.seen[0] = sum_of_side(state, touch, 0);
    stored.seen[1] = touch.seen[1] = sum_of_side(state, touch, 1);
    if constexpr (kAnswers) {
      take_over(touch,
                answer(touch, touch.mu, read_plane(touch, touch.seen[0] + touch.seen[1]),
                       inverse_dt_squared, touch.stiffness)
                    .force,
                1 / inverse_dt_squared);
      stored.multiplier = touch.multiplier;
      stored.friction = touch.friction;
    }
  }
}

void see_touches(const DeviceState& state, const ToolArrays& tools, StepInput* input, bool answers,
                 const Launch& how) {
  launch(how, "launching the answer of bodies", share_blocks(kWarpBlocks, 1, how), kWarp,
         answers ? see_touches<true> : see_touches<false>, state, tools, input);
}

/// What the next substep has to know, and after the last one the host.
__global__ void __launch_bounds__(kToolThreads)
    keep_touches(ToolArrays tools, const StepInput* input, Index place_room, bool tells) {
  wait_for_previous();
  const TouchArrays touches = of_copy(tools.touches, place_room);
  input += copy_index();
  const float inverse_dt_squared = input->substep.inverse_dt_squared;
  const Index count = contact_count(touches);
  for (Index c = thread_index(); c < count; c += thread_count()) {
    const TissueTouch& touch = touches.contacts[c];
    const RememberedTouch now{touch.slot, touch.normal, inverse_dt_squared * touch.multiplier,
                              inverse_dt_squared * touch.friction};
    touches.remembered[c] = now;
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      touches.holds_at[touch.places[k]] = {};
    }
    if (tells) {
      touches.told[c] = touch;
      touches.told_remembered[c] = now;
    }
  }
  if (thread_index() == 0) {
    *touches.remembered_counts = count;
    if (tells) {
      *touches.told_counts = count;
    }
  }
}

void remember_touches(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                      bool tells, const Launch& how) {
  launch(how, "launching what is remembered of bodies", share_blocks(kWarpBlocks, 1, how), kWarp,
         keep_touches, tools, input, state.capacity, tells);
}

/// As on the host.
__device__ inline void ease_touch(const DeviceState& state, const TissueTouch& touch,
                                  float inverse_h) {
  Pushed<float> between;
  Vec3<float> way;
  float yield = 0;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    const Index place = touch.places[k];
    const float weight = touch.weights[k];
    between.velocity = between.velocity + weight * load_velocity(state.velocities + place);
    between.velocity_before =
        between.velocity_before + weight * load_velocity(state.velocities_before + place);
    way = way + weight * load_way(state.ways + place);
    yield += weight * weight * load_particle(state.particles + place).w;
  }
  if (!(yield > 0)) {
    return;
  }
  const Pushed<float> now = eased(between, touch.normal, way, inverse_h);
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    const Index place = touch.places[k];
    const float share = touch.weights[k] * load_particle(state.particles + place).w / yield;
    if (share != 0) {
      Velocity* const velocity = state.velocities + place;
      Velocity* const before = state.velocities_before + place;
      store_velocity(velocity, load_velocity(velocity) + share * (now.velocity - between.velocity));
      store_velocity(
          before, load_velocity(before) + share * (now.velocity_before - between.velocity_before));
    }
  }
}

/// Of BDF2: see ease_contacts(). One block a copy.
__global__ void __launch_bounds__(kMoveThreads)
    ease_all_touches(DeviceState state, ToolArrays tools, const StepInput* input) {
  wait_for_previous();
  state = of_copy(state);
  const TouchArrays touches = of_copy(tools.touches, state.capacity);
  input += copy_index();
  const Index count = contact_count(touches);
  const Index levels = __ldcg(touches.level_counts);
  for (Index level = 0; level < levels; ++level) {
    for (Index c = static_cast<Index>(threadIdx.x); c < count; c += kMoveThreads) {
      const TissueTouch& touch = touches.contacts[c];
      if (touches.levels[c] == level && touch.multiplier > 0 && !touch.is_eased) {
        ease_touch(state, touch, input->inverse_h);
      }
    }
    __syncthreads();
  }
}

void ease_touches(const DeviceState& state, const ToolArrays& tools, StepInput* input,
                  const Launch& how) {
  launch(how, "launching the easing of bodies", 1, kMoveThreads, ease_all_touches, state, tools,
         input);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
