// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What of sheets and threads comes through a tool in a substep, for one triangle or link, on a CPU
/// or a device. Contacts keep features outside, but not always: sweeps may throw a light wall by
/// many radii, and contacts in a narrow fold may be against each other. An axis passes a surface
/// through an edge or at an end of its own, and the rectangle of a plate through vertices, too.
/// What has come through is taken along by the tool from where the substep began, instead: what a
/// tool takes along on all corners it does not pass. A tool on a spring that has come through what
/// is fixed stays where it was.
///
/// Solids have no such stop: their tetrahedra would be strained by it, again in each substep, and
/// what is within a tool because heat has let it in would be torn along.

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/crossing.h"
#include "lib/base/segment.h"
#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/feature_meeting.h"

namespace pbdsurg {

/// How often at most what passes is looked for: what has been taken along may take its neighbours
/// through.
inline constexpr int kStopPasses = 8;

/// m, the least way, of vertices and a capsule together, by which what it has not met may come
/// through it: features nearer than this are met.
[[nodiscard]] PBDSURG_HOST_DEVICE inline float way_through(const PlacedCapsule& capsule) {
  return (1 + kContactMargin) * capsule.radius;
}
/// Likewise of what it has met.
/// @param corners  of a feature that it meets, of which the start counts
[[nodiscard]] PBDSURG_HOST_DEVICE inline float way_through(const PlacedCapsule& capsule,
                                                           const FeatureCorners& corners) {
  return feature_meeting::meet(corners.count, corners.start, capsule).distance;
}

/// Where a vertex goes that a capsule takes along.
/// @param start  m, where it was as the substep began
[[nodiscard]] PBDSURG_HOST_DEVICE inline Vec3<float> taken_along(const SweptCapsule& capsule,
                                                                 const Vec3<float>& start) {
  const CorePlace place = capsule.before.closest(start);
  return start + (capsule.now.at(place) - capsule.before.at(place));
}

/// Gives a contact the side on which its feature is now, and no force.
/// @param corners  of the feature, of which the end counts
PBDSURG_HOST_DEVICE inline void take_side(const FeatureCorners& corners,
                                          const SweptCapsule& capsule, SurfaceContact& contact) {
  const feature_meeting::Meeting now = feature_meeting::meet_at(corners, 1, capsule);
  if (now.distance < kInfinity && now.distance > 0) {
    contact.normal = (1 / now.distance) * now.away;
  }
  contact.multiplier = 0;
  contact.friction = {};
}

/// What holds the axis of a capsule, or the rectangle of a plate, through the substep.
[[nodiscard]] PBDSURG_HOST_DEVICE inline ContactBox core_box(const SweptCapsule& capsule) {
  ContactBox box;
  capsule.now.for_each_corner([&](const CorePlace& place) {
    box.add(capsule.before.corner(place), capsule.now.corner(place), 0);
  });
  return box;
}

/// Which corners of a triangle, or of a link, bound what has come through a capsule: from whichever
/// side.
class Passing {
 public:
  /// @param corners  three, in the order of the triangle; of a link, the last is there twice
  PBDSURG_HOST_DEVICE Passing(const SweptCapsule& capsule, const FeatureCorners& corners)
      : capsule_(capsule), corners_(corners) {
    const PlacedCapsule& now = capsule.now;
    for (int k = 0; k < 3; ++k) {
      const int next = k == 2 ? 0 : k + 1;
      if (corners.places[k] != corners.places[next]) {
        now.for_each_side([&](const CorePlace& from, const CorePlace& to) {
          add(comes_through(k, next, from, to), (1 << k) | (1 << next));
        });
      }
      if (now.is_plate()) {
        add(comes_through(k), 1 << k);
      }
    }
    if (corners.places[1] != corners.places[2]) {
      now.for_each_corner([&](const CorePlace& place) { add(comes_through(place), 7); });
    }
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool has(int corner) const {
    return (bits_ >> corner & 1) != 0;
  }

 private:
  PBDSURG_HOST_DEVICE void add(bool passes, int bits) { bits_ |= passes ? bits : 0; }

  [[nodiscard]] PBDSURG_HOST_DEVICE CornerWay way(int corner) const {
    return {corners_.start[corner], corners_.end[corner]};
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE CornerWay way(const CorePlace& place) const {
    return {capsule_.before.corner(place), capsule_.now.corner(place)};
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool comes_through(int first, int second, const CorePlace& from,
                                                       const CorePlace& to) const {
    using feature_meeting::between;
    using feature_meeting::larger;
    using feature_meeting::length;
    const Vec3<float> a = capsule_.before.corner(from), b = capsule_.before.corner(to);
    const Vec3<float>&c = corners_.start[first], &d = corners_.start[second];
    const SegmentPair pair = closest_of_segments(a, b, c, d);
    const Vec3<float> away = between(c, d, pair.second) - between(a, b, pair.first);
    const float travel =
        larger(length(corners_.end[first] - c), length(corners_.end[second] - d)) +
        larger(length(capsule_.now.corner(from) - a), length(capsule_.now.corner(to) - b));
    return !(length(away) > travel) && segments_cross(way(from), way(to), way(first), way(second));
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool comes_through(const CorePlace& place) const {
    return point_crosses(way(place), way(0), way(1), way(2));
  }

  // A vertex, through a plate.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool comes_through(int corner) const {
    const CornerWay vertex = way(corner), a = way({0, 0}), b = way({1, 0}), c = way({1, 1}),
                    d = way({0, 1});
    return point_crosses(vertex, a, b, c) || point_crosses(vertex, a, c, d);
  }

  const SweptCapsule& capsule_;
  const FeatureCorners& corners_;
  int bits_ = 0;
};

}  // namespace pbdsurg
