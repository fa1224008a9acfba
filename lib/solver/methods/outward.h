// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which way is out of tissue at a vertex, an edge or a triangle of its surface, on a CPU or a
/// device.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/surface_contact.h"

namespace pbdsurg {

/// @return  rad, within 7e-5 (Abramowitz and Stegun, "Handbook of Mathematical Functions", 1964,
///          4.4.45): the same bits wherever it is computed
PBDSURG_HOST_DEVICE inline float angle_of_cosine(float cosine) {
  using std::sqrt;
  constexpr float kPi = 3.14159265F;
  const float size = cosine < 0 ? -cosine : cosine;
  if (!(size < 1)) {
    return cosine < 0 ? kPi : 0.0F;
  }
  const float angle = sqrt(1 - size) *
                      (1.5707288F + size * (-0.2121144F + size * (0.0742610F - 0.0187293F * size)));
  return cosine < 0 ? kPi - angle : angle;
}

/// The normals of the triangles around a feature, at a vertex each by its angle there. Where the
/// feature is what a point's surface has nearest to it, the sum tells on which side the point is
/// (Baerentzen and Aanaes, "Signed distance computation using the angle weighted pseudonormal",
/// 2005, section 4).
class Outward {
 public:
  PBDSURG_HOST_DEVICE explicit Outward(const ContactFeature& feature) : feature_(feature) {}

  /// Takes a triangle, if the feature is of it; one without area tells nothing.
  /// @param places       [3] counterclockwise, seen from outside
  /// @param position_of  (place) -> m
  template <class PositionOf>
  PBDSURG_HOST_DEVICE void add(const Index* places, const PositionOf& position_of) {
    using std::sqrt;
    int corner = 0, shared = 0;
    for (int k = 0; k < 3; ++k) {
      for (const Index place : feature_.places) {
        if (place == places[k]) {
          corner = k;
          ++shared;
        }
      }
    }
    const int count = feature_.count();
    if (shared != count) {
      return;
    }
    const Vec3<float> x = position_of(places[corner]);
    const Vec3<float> first = position_of(places[(corner + 1) % 3]) - x;
    const Vec3<float> second = position_of(places[(corner + 2) % 3]) - x;
    const Vec3<float> normal = cross(first, second);
    const float square = dot(normal, normal);
    if (!(square > 0)) {
      return;
    }
    const float weight =
        count > 1
            ? 1
            : angle_of_cosine(dot(first, second) / sqrt(dot(first, first) * dot(second, second)));
    sum_ = sum_ + (weight / sqrt(square)) * normal;
    weight_ = weight_ + weight;
  }

  /// Whether a feature is seen from within tissue; not where its triangles' normals cancel, as
  /// those of a sheet's two sides, or it has none.
  /// @param away  from there to it
  [[nodiscard]] PBDSURG_HOST_DEVICE bool is_along(const Vec3<float>& away) const {
    constexpr float kCancelled = 1e-3F;  // of the weights: what rounding leaves
    const float least = kCancelled * weight_;
    return dot(away, sum_) > 0 && dot(sum_, sum_) > least * least;
  }

 private:
  ContactFeature feature_;
  Vec3<float> sum_{};
  float weight_ = 0;
};

}  // namespace pbdsurg
