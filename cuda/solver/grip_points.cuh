// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Points that jaws hold with a limit, as sweeps read them.

#include "cuda/solver/kernel_support.cuh"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// What a grip of a copy has in a substep.
struct GripTables {
  GripInput& grip;
  GripPointInput* points;
  const GripCornerInput* corners;
  const GripPose& pose;
  float count;  ///< of points

  /// @param index  of the grip in its copy
  __device__ GripTables(StepInput* input, Index substep, Index index)
      : grip(table<GripInput>(input, input->grips)[index]),
        points(table<GripPointInput>(input, input->grip_points) + grip.first_point),
        corners(table<GripCornerInput>(input, input->grip_corners) + grip.first_corner),
        pose((table<GripPose>(input, input->grip_poses) +
              row_at(substep, input->grip_count))[index]),
        count(static_cast<float>(grip.point_count)) {}
};

/// Calls visit(place, weight) for the vertices of a point.
template <class Visit>
__device__ inline void for_each_corner(const GripPointInput& point, const Visit& visit) {
  for (int k = 0; k < 3; ++k) {
    if (point.places[k] != kInvalidIndex) {
      visit(point.places[k], point.weights[k]);
    }
  }
}

/// m, from where a point is now to where jaws want it.
__device__ inline Vec3<float> way_to_jaws(const DeviceState& state, const GripInput& grip,
                                          const GripPointInput& point) {
  Vec3<float> from_base = point.target + grip.slide;
  Vec3<float> displacement;
  for_each_corner(point, [&](Index place, float weight) {
    from_base = from_base - weight * base_of(state, place);
    displacement = displacement + weight * position_of(load_particle(moving_of(state) + place));
  });
  return from_base - displacement;
}

/// A corner of a point that jaws draw, as HeldVertex has them on the host.
struct GripDraw {
  Vec3<float> way;
  float own_compliance;

  __device__ GripDraw(const DeviceState& state, StepInput* input, Index hold) {
    const GripHold own = table<GripHold>(input, input->grip_holds)[hold];
    const GripInput& grip = table<GripInput>(input, input->grips)[own.grip];
    const GripPointInput& point = table<GripPointInput>(input, input->grip_points)[own.point];
    const float share = 1 / point.weights[own.corner];
    way = share * way_to_jaws(state, grip, point);
    own_compliance = share * share * grip.compliance;
  }

  [[nodiscard]] __device__ Vec3<float> target() const { return way; }
  [[nodiscard]] __device__ float compliance() const { return own_compliance; }
  __device__ void set_multiplier(const Vec3<float>& /*multiplier*/) const {}
};

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
