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

/// @tparam Corners  see contact_projection.cuh; the root of a corner is its number in the grip
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
    Vec3<float> pull;     // of all points
    float stiffness = 0;  // likewise
    for_each_point([&](DrawnPoint& point, Index count) {
      take_turns(count, [&] {
        push(point, draw_of(way_to_jaws(point), point.own.multiplier, point.yield, alpha_));
      });
      for (Index turn = 0; turn < count; ++turn) {
        stiffness += __shfl_sync(~0U, 1 / point.yield, turn);
        pull = pull + Vec3<float>{__shfl_sync(~0U, point.own.multiplier.x, turn),
                                  __shfl_sync(~0U, point.own.multiplier.y, turn),
                                  __shfl_sync(~0U, point.own.multiplier.z, turn)};
      }
    });
    const GripSlide next(along_pad(tables_.pose.normal, pull), slid_, stiffness, limit_);
    if (!next.moves()) {
      return;
    }
    if (lane() == 0) {
      tables_.grip.slide = next.slide;
    }
    for_each_point([&](DrawnPoint& point, Index count) {
      take_turns(count, [&] { push(point, (1 / point.yield) * next.way); });
    });
  }

 private:
  /// A point, near at hand.
  struct DrawnPoint {
    GripPointInput own;
    Vec3<float> bases[3];
    float yield;  ///< 1/kg, to what draws it
  };

  [[nodiscard]] __device__ static Index lane() { return static_cast<Index>(threadIdx.x) % kWarp; }

  /// Calls visit(point, count), of as many points as there are threads, until all had their turn.
  template <class Visit>
  __device__ void for_each_point(const Visit& visit) const {
    for (Index first = 0; first < tables_.grip.point_count; first += kWarp) {
      const Index left = tables_.grip.point_count - first;
      const Index count = left < kWarp ? left : kWarp;
      GripPointInput& stored = tables_.points[first + (lane() < count ? lane() : 0)];
      DrawnPoint point{stored, {}, 0};
      for (int k = 0; k < 3 && point.own.places[k] != kInvalidIndex; ++k) {
        const Index place = point.own.places[k];
        const float weight = point.own.weights[k];
        point.bases[k] = base_of(state_, place);
        point.yield += weight * weight * corners_.load(place, point.own.corners[k]).w;
      }
      point.yield += alpha_;
      visit(point, count);
      if (lane() < count) {
        stored.multiplier = point.own.multiplier;
      }
      __syncwarp();
    }
  }

  /// One thread after another.
  template <class Visit>
  __device__ static void take_turns(Index count, const Visit& visit) {
    for (Index turn = 0; turn < count; ++turn) {
      if (lane() == turn) {
        visit();
      }
      __syncwarp();
    }
  }

  /// m, from where a point is now to where jaws want it.
  [[nodiscard]] __device__ Vec3<float> way_to_jaws(const DrawnPoint& point) const {
    Vec3<float> from_base = point.own.target + slid_, displacement;
    for (int k = 0; k < 3 && point.own.places[k] != kInvalidIndex; ++k) {
      const float weight = point.own.weights[k];
      from_base = from_base - weight * point.bases[k];
      displacement = displacement +
                     weight * position_of(corners_.load(point.own.places[k], point.own.corners[k]));
    }
    return from_base - displacement;
  }

  /// Corners go where they are somewhere.
  __device__ void push(DrawnPoint& point, const Vec3<float>& change) const {
    if (!is_finite_way(change)) {
      return;
    }
    point.own.multiplier = point.own.multiplier + change;
    for (int k = 0; k < 3 && point.own.places[k] != kInvalidIndex; ++k) {
      const Particle p = corners_.load(point.own.places[k], point.own.corners[k]);
      const Vec3<float> after = position_of(p) + (point.own.weights[k] * p.w) * change;
      corners_.store_if(is_finite_way(after), point.own.places[k], point.own.corners[k],
                        {after.x, after.y, after.z, p.w});
    }
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
