// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a vertex meets a tool, for one vertex, on a CPU or a device.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Vertices this share of a radius away get a contact too, so that the sweeps cannot push them in.
inline constexpr float kContactMargin = 0.25F;

/// Where a point is on the axis of a capsule, or on the rectangle of a plate: shares of its ways.
struct CorePlace {
  float along = 0, across = 0;
};

/// A capsule in the world, or a plate.
struct alignas(16) PlacedCapsule {
  Vec3<float> start;     ///< m
  float radius;          ///< m
  Vec3<float> end;       ///< m
  Vec3<float> across{};  ///< m, see Capsule::across

  [[nodiscard]] PBDSURG_HOST_DEVICE bool is_plate() const { return dot(across, across) > 0; }

  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> at(const CorePlace& place) const {
    return start + place.along * (end - start) + place.across * across;
  }

  /// The place that is nearest to x.
  [[nodiscard]] PBDSURG_HOST_DEVICE CorePlace closest(const Vec3<float>& x) const {
    const auto share_of = [&](const Vec3<float>& way) {
      const float square = dot(way, way);
      const float share = square > 0 ? dot(x - start, way) / square : 0.0F;
      return share < 0 ? 0.0F : (share > 1 ? 1.0F : share);
    };
    return {share_of(end - start), is_plate() ? share_of(across) : 0.0F};
  }

  /// One of its corners, m: at(place) without rounding.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> corner(const CorePlace& place) const {
    const Vec3<float>& near = place.along > 0 ? end : start;
    return place.across > 0 ? near + across : near;
  }

  /// Calls visit(place) for its corners: the ends of a capsule.
  template <class Visit>
  PBDSURG_HOST_DEVICE void for_each_corner(const Visit& visit) const {
    visit(CorePlace{0, 0});
    visit(CorePlace{1, 0});
    if (is_plate()) {
      visit(CorePlace{0, 1});
      visit(CorePlace{1, 1});
    }
  }

  /// Calls visit(from, to), of corners, for its sides: the axis of a capsule.
  template <class Visit>
  PBDSURG_HOST_DEVICE void for_each_side(const Visit& visit) const {
    visit(CorePlace{0, 0}, CorePlace{1, 0});
    if (is_plate()) {
      visit(CorePlace{1, 0}, CorePlace{1, 1});
      visit(CorePlace{1, 1}, CorePlace{0, 1});
      visit(CorePlace{0, 1}, CorePlace{0, 0});
    }
  }

  /// @param way  m
  [[nodiscard]] PBDSURG_HOST_DEVICE PlacedCapsule moved(const Vec3<float>& way) const {
    return {start + way, radius, end + way, across};
  }
};

/// What holds all that touches a tool.
struct ContactBox {
  Vec3<float> low{kInfinity, kInfinity, kInfinity};      ///< m
  Vec3<float> high{-kInfinity, -kInfinity, -kInfinity};  ///< m

  /// Grows by a way.
  /// @param reach  m, around it
  PBDSURG_HOST_DEVICE void add(const Vec3<float>& start, const Vec3<float>& end, float reach) {
    const auto least = [](float a, float b) { return a < b ? a : b; };
    const auto most = [](float a, float b) { return a > b ? a : b; };
    low = {least(low.x, least(start.x, end.x) - reach), least(low.y, least(start.y, end.y) - reach),
           least(low.z, least(start.z, end.z) - reach)};
    high = {most(high.x, most(start.x, end.x) + reach), most(high.y, most(start.y, end.y) + reach),
            most(high.z, most(start.z, end.z) + reach)};
  }

  /// Grows by a capsule and its margin.
  PBDSURG_HOST_DEVICE void add(const PlacedCapsule& capsule) {
    const float reach = (1 + kContactMargin) * capsule.radius;
    add(capsule.start, capsule.end, reach);
    if (capsule.is_plate()) {
      add(capsule.start + capsule.across, capsule.end + capsule.across, reach);
    }
  }

  /// @param way  m
  [[nodiscard]] PBDSURG_HOST_DEVICE ContactBox moved(const Vec3<float>& way) const {
    return {low + way, high + way};
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool contains(const Vec3<float>& x) const {
    return x.x >= low.x && x.x <= high.x && x.y >= low.y && x.y <= high.y && x.z >= low.z &&
           x.z <= high.z;
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool meets(const ContactBox& other) const {
    return low.x <= other.high.x && other.low.x <= high.x && low.y <= other.high.y &&
           other.low.y <= high.y && low.z <= other.high.z && other.low.z <= high.z;
  }
};

/// The plane that stands for a tool's surface near a vertex.
struct alignas(16) CapsulePlane {
  Vec3<float> normal{};  ///< out of the tool
  float offset = 0;      ///< m
};

/// The deepest of a tool's capsules around a vertex, one after another.
struct ContactSearch {
  float deepest = kInfinity;  ///< m, negative inside; infinite while there is no contact
  CapsulePlane plane;

  /// @param x  m, the vertex
  PBDSURG_HOST_DEVICE void add(const PlacedCapsule& capsule, const Vec3<float>& x) {
    using std::sqrt;
    const Vec3<float> axis_point = capsule.at(capsule.closest(x));
    const Vec3<float> away = x - axis_point;
    const float distance = sqrt(dot(away, away));
    // a vertex on the axis, or in the rectangle, has no side to be pushed to
    if (distance > 0 && distance < (1 + kContactMargin) * capsule.radius &&
        distance - capsule.radius < deepest) {
      deepest = distance - capsule.radius;
      plane.normal = {away.x / distance, away.y / distance, away.z / distance};
      plane.offset = dot(plane.normal, axis_point) + capsule.radius;
    }
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE bool has_contact() const { return deepest < kInfinity; }
};

}  // namespace pbdsurg
