// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Jaws that hold with a limit, after a sweep of projections: a warp draws the points of a grip one
/// after another, for they share vertices, and then takes off what is beyond the limit.

#include "cuda/solver/grip_points.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/methods/grip_motion.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// @tparam Corners  has load(place, corner) and store(place, corner, particle), of what moves; a
///                  corner is a number among those of the grip
template <class Corners>
class GripProjection {
 public:
  __device__ GripProjection(const DeviceState& state, const StepInput* input,
                            const GripTables& tables, const Corners& corners)
      : state_(state),
        tables_(tables),
        corners_(corners),
        slid_(tables.grip.slide),
        alpha_(tables.grip.compliance * input->substep.inverse_dt_squared),
        limit_(tables.grip.limit / input->substep.inverse_dt_squared) {}

  /// All threads of a warp.
  __device__ void run() const {
    Vec3<float> pull;
    for (Index first = 0; first < tables_.grip.point_count; first += kWarp) {
      draw_points(first, pull);
    }
    slide_points(pull);
  }

 private:
  /// A point, while it is drawn.
  struct DrawnPoint {
    GripPointInput own;
    Vec3<float> bases[3];
  };

  [[nodiscard]] __device__ static Index lane() { return static_cast<Index>(threadIdx.x) % kWarp; }

  /// Adds what each of some threads has to a sum, in their order.
  __device__ static void add_up(Vec3<float>& sum, const Vec3<float>& own, Index count) {
    for (Index turn = 0; turn < count; ++turn) {
      sum = sum + Vec3<float>{__shfl_sync(~0U, own.x, turn), __shfl_sync(~0U, own.y, turn),
                              __shfl_sync(~0U, own.z, turn)};
    }
  }

  /// Each thread has one, and they take turns.
  /// @param pull  of all so far
  __device__ void draw_points(Index first, Vec3<float>& pull) const {
    const Index left = tables_.grip.point_count - first;
    const Index count = left < kWarp ? left : kWarp;
    GripPointInput* const point = tables_.points + first + (lane() < count ? lane() : 0);
    DrawnPoint drawn{*point, {}};
    for (int k = 0; k < 3 && drawn.own.places[k] != kInvalidIndex; ++k) {
      drawn.bases[k] = base_of(state_, drawn.own.places[k]);
    }
    for (Index turn = 0; turn < count; ++turn) {
      if (lane() == turn) {
        draw(drawn);
        point->multiplier = drawn.own.multiplier;
      }
      __syncwarp();
    }
    add_up(pull, drawn.own.multiplier, count);
  }

  __device__ void draw(DrawnPoint& drawn) const {
    GripPointInput& point = drawn.own;
    Particle particles[3];
    float yield = 0;
    Vec3<float> from_base = point.target + slid_, displacement;
    for (int k = 0; k < 3 && point.places[k] != kInvalidIndex; ++k) {
      const float weight = point.weights[k];
      particles[k] = corners_.load(point.places[k], point.corners[k]);
      yield += weight * weight * particles[k].w;
      from_base = from_base - weight * drawn.bases[k];
      displacement = displacement + weight * position_of(particles[k]);
    }
    const Vec3<float> change = draw_of(from_base - displacement, point.multiplier, yield, alpha_);
    if (!is_finite_way(change)) {
      return;
    }
    point.multiplier = point.multiplier + change;
    for (int k = 0; k < 3 && point.places[k] != kInvalidIndex; ++k) {
      go_on(point.places[k], point.corners[k], particles[k], point.weights[k], change);
    }
  }

  /// Moves a corner, if it then is somewhere.
  __device__ void go_on(Index place, Index corner, const Particle& p, float share,
                        const Vec3<float>& push) const {
    const Vec3<float> after = position_of(p) + (share * p.w) * push;
    if (is_finite_way(after)) {
      corners_.store(place, corner, {after.x, after.y, after.z, p.w});
    }
  }

  /// @param pull  of all points
  __device__ void slide_points(const Vec3<float>& pull) const {
    const GripSlide next(along_pad(tables_.pose.normal, pull), slid_, find_yield(), limit_);
    if (!next.moves()) {
      return;
    }
    if (lane() == 0) {
      tables_.grip.slide = next.slide;
    }
    for (Index i = lane(); i < tables_.grip.point_count; i += kWarp) {
      Vec3<float>& multiplier = tables_.points[i].multiplier;
      multiplier = multiplier + (1 / tables_.count) * next.push;
    }
    for (Index c = lane(); c < tables_.grip.corner_count; c += kWarp) {
      const auto [place, share] = tables_.corners[c];
      go_on(place, c, corners_.load(place, c), share, next.push);
    }
    __syncwarp();
  }

  /// 1/kg, of all points to one push on all: in the order of corners.
  [[nodiscard]] __device__ float find_yield() const {
    float yield = alpha_ / tables_.count;
    for (Index first = 0; first < tables_.grip.corner_count; first += kWarp) {
      const Index left = tables_.grip.corner_count - first;
      float own = 0;
      if (lane() < left) {
        const auto [place, share] = tables_.corners[first + lane()];
        own = share * share * corners_.load(place, first + lane()).w;
      }
      for (Index turn = 0; turn < left && turn < kWarp; ++turn) {
        yield += __shfl_sync(~0U, own, turn);
      }
    }
    return yield;
  }

  const DeviceState& state_;
  const GripTables& tables_;
  const Corners& corners_;
  Vec3<float> slid_;  // m, of anchors, before
  float alpha_;       // 1/kg
  float limit_;       // kg m
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
