// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a vertex meets a triangle or a link of another body, and how contacts between bodies
/// begin, for one of them, on a CPU or a device.
///
/// A Start knows the substep: position(place), way_from_start(place) and own_start(place) in m,
/// way(place), as nothing stops it, and mobility(place) in 1/kg; and whether vertices count from
/// the origin.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/triangle.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/state/tissue_touch.h"
#include "lib/solver/state/touch_features.h"

namespace pbdsurg {

/// In thicknesses: how far apart what does not move meets, how deep it may overlap, and the way of
/// a substep that counts.
inline constexpr float kTouchReach = 1.5F, kDeepestTouch = 3, kTouchWay = 8;

/// In thicknesses: how far vertices may move between two searches for what is near.
inline constexpr float kTouchSlack = 2;

/// m/s, at which surfaces that are too near part.
inline constexpr float kRecovery = 0.03F;

/// Of a distance, or of a cosine: what differs by less is as near, and faces a vertex as much.
inline constexpr float kAsNear = 1e-4F;

/// m, how far apart what meets in a substep may be.
/// @param way  m, of the fastest vertex in it
[[nodiscard]] PBDSURG_HOST_DEVICE inline float touch_limit(float thickness, float way) {
  const float most = kTouchWay * thickness;
  const float reach = kTouchReach * thickness + 2 * (way < most ? way : most);
  const float deepest = kDeepestTouch * thickness;
  return reach < deepest ? deepest : reach;
}

/// The vector of length 1, but for one without a length.
[[nodiscard]] PBDSURG_HOST_DEVICE inline Vec3<float> direction_of(const Vec3<float>& v) {
  const float square = dot(v, v);
  return square > 0 ? (1 / std::sqrt(square)) * v : v;
}

[[nodiscard]] PBDSURG_HOST_DEVICE inline bool is_finite_number(float value) {
  return value < kInfinity && value > -kInfinity;
}

/// Of a link, which has its second end twice. What is on it is nowhere beside it.
/// @param a  m, its ends from the vertex
/// @return   whether there is one
[[nodiscard]] PBDSURG_HOST_DEVICE inline bool find_near_of_link(const Vec3<float>& a,
                                                                const Vec3<float>& b,
                                                                NearPoint& near) {
  const Vec3<float> along = b - a;
  const float wanted = -dot(a, along) / dot(along, along);
  const float share = wanted < 0 ? 0.0F : (wanted > 1 ? 1.0F : wanted);
  near.away = -1.0F * (a + share * along);
  near.distance = std::sqrt(dot(near.away, near.away));
  near.weights[0] = 1 - share;
  near.weights[1] = share;
  near.weights[2] = 0;
  return near.distance > 0 && is_finite_number(near.distance);
}

/// Unit, out of a triangle.
/// @param corners  [3]
template <class Start>
[[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> outwards_of(const Start& start,
                                                          const Index* corners) {
  const Vec3<float> a = start.position(corners[0]);
  return direction_of(cross(start.position(corners[1]) - a, start.position(corners[2]) - a));
}

/// Finds how a point that was found faces the vertex.
template <class Start>
PBDSURG_HOST_DEVICE void face(const Start& start, NearPoint& near) {
  if (near.corners[1] == near.corners[2]) {
    near.outwards = (1 / near.distance) * near.away;
    near.alignment = 1;
    return;
  }
  near.outwards = outwards_of(start, near.corners);
  near.alignment = near.distance > 0 ? dot(near.outwards, near.away) / near.distance : 1.0F;
}

/// None of a triangle without a place, or of one that faces what the vertex left last.
/// @param corners  [3] of a triangle or a link
/// @param left     the normal where the vertex of a solid was in the last substep; may be null
/// @return         whether there is one
template <class Start>
[[nodiscard]] PBDSURG_HOST_DEVICE bool find_near(const Start& start, Index place,
                                                 const Index* corners, const Vec3<float>* left,
                                                 NearPoint& near) {
  // of cosines: beyond, it is on the other side of a thin wall
  constexpr float kOtherWall = -0.5F;
  const Vec3<float> x = start.position(place);
  const Vec3<float> a = start.position(corners[0]) - x, b = start.position(corners[1]) - x;
  for (int k = 0; k < 3; ++k) {
    near.corners[k] = corners[k];
  }
  if (corners[1] == corners[2]) {
    return find_near_of_link(a, b, near);
  }
  if (left != nullptr && dot(outwards_of(start, corners), *left) < kOtherWall) {
    return false;
  }
  const Vec3<float> c = start.position(corners[2]) - x;
  const Vec3<float> ab = b - a, ac = c - a;
  const auto [feature, b_weight, c_weight, sum] = closest_feature<float>(
      -dot(ab, a), -dot(ac, a), -dot(ab, b), -dot(ac, b), -dot(ab, c), -dot(ac, c));
  const float b_share = b_weight / sum, c_share = c_weight / sum;
  near.weights[0] = (feature & 0b001) != 0 ? 1 - b_share - c_share : 0.0F;
  near.weights[1] = b_share;
  near.weights[2] = c_share;
  near.away = -1.0F * (near.weights[0] * a + b_share * b + c_share * c);
  near.distance = std::sqrt(dot(near.away, near.away));
  return is_finite_number(near.distance);
}

/// @param least  m, the distance of the nearest
[[nodiscard]] PBDSURG_HOST_DEVICE inline bool is_as_near(const NearPoint& near, float least) {
  return near.distance <= (1 + kAsNear) * least;
}
/// Of triangles at a corner or an edge, the one that faces the vertex most, or turns away from it
/// most, tells the side; of those that do so as much, the first.
/// @param near  that face() was called for
/// @param most  of what is as near: the largest absolute alignment
[[nodiscard]] PBDSURG_HOST_DEVICE inline bool faces_as_much(const NearPoint& near, float most) {
  return std::fabs(near.alignment) >= most - kAsNear;
}

/// On which side of what is nearest a vertex is, and how far from it.
struct TouchSide {
  Vec3<float> normal;
  float distance;  ///< m, along it
};

/// @param is_two_sided  see ContactBodies
/// @param known         of the last substep; may be null
[[nodiscard]] PBDSURG_HOST_DEVICE inline TouchSide side_of(const NearPoint& near, bool is_two_sided,
                                                           const RememberedTouch* known) {
  // of cosines between where a vertex was and is: beyond, it is on the other side of a sheet
  constexpr float kOtherSide = -0.7F;
  if (!(near.distance > 0)) {
    return {known != nullptr ? known->normal : near.outwards, 0};
  }
  const Vec3<float> towards = (1 / near.distance) * near.away;
  bool is_inside = near.alignment < 0;
  if (is_two_sided) {
    is_inside = known != nullptr && dot(towards, known->normal) < kOtherSide;
  }
  const float side = is_inside ? -1.0F : 1.0F;
  return {side * towards, side * near.distance};
}

[[nodiscard]] PBDSURG_HOST_DEVICE inline TissueTouch touch_of(const TouchSlot& slot,
                                                              Index vertex_body,
                                                              const NearPoint& near,
                                                              const Vec3<float>& normal) {
  TissueTouch touch;
  touch.slot = slot;
  touch.bodies[0] = vertex_body;
  touch.bodies[1] = slot.body;
  touch.places[0] = slot.place;
  touch.weights[0] = 1;
  for (int k = 0; k < 3; ++k) {
    touch.places[k + 1] = near.corners[k];
    touch.weights[k + 1] = -near.weights[k];
  }
  touch.normal = normal;
  return touch;
}

/// What slides on a surface comes near edges of it, and is none the nearer for that: the plane of
/// an edge would stop it there. So where that would push in this substep and one face at the edge
/// would do so less, and is as far away as surfaces should be, it stands for the edge, beyond its
/// own triangle: of several the one that would do so least, and the first of those.
class PassedEdge {
 public:
  /// @param near  that the vertex has
  template <class Start>
  PBDSURG_HOST_DEVICE PassedEdge(const Start& start, Index place, const NearPoint& near,
                                 const Vec3<float>& normal, float thickness)
      : near_(near), place_(place), thickness_(thickness) {
    Vec3<float> way = start.way_from_start(place);
    for (int k = 0; k < 3; ++k) {
      way = way - near.weights[k] * start.way_from_start(near.corners[k]);
    }
    ahead_ = near.away + way;
    clear_ = dot(normal, ahead_);
  }

  /// Whether a face may stand for it.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool has_any() const {
    return near_.is_edge() && near_.distance > thickness_ && clear_ < thickness_;
  }
  /// m, how far away the vertex would be after the substep.
  [[nodiscard]] PBDSURG_HOST_DEVICE float clear() const { return clear_; }

  /// @param corners  [3] of a triangle
  /// @param face     where the vertex is near its plane
  /// @param clear    m, as above, then
  /// @return         whether it may stand for the edge
  template <class Start>
  [[nodiscard]] PBDSURG_HOST_DEVICE bool find_face(const Start& start, const Index* corners,
                                                   NearPoint& face, float& clear) const {
    constexpr float kRest = 0.9F;  // of the thickness, where surfaces lie on each other
    for (int k = 0; k < 3; ++k) {
      const Index own = near_.corners[k];
      if (near_.weights[k] != 0 && own != corners[0] && own != corners[1] && own != corners[2]) {
        return false;
      }
      face.corners[k] = corners[k];
    }
    const Vec3<float> at_first = start.position(corners[0]);
    const Vec3<float> a = at_first - start.position(place_);
    const Vec3<float> ab = start.position(corners[1]) - at_first;
    const Vec3<float> ac = start.position(corners[2]) - at_first;
    const Vec3<float> across = cross(ab, ac);
    face.outwards = direction_of(across);
    face.distance = dot(face.outwards, near_.away);
    face.away = face.distance * face.outwards;
    face.alignment = 1;
    clear = dot(face.outwards, ahead_);
    const Vec3<float> at = -1.0F * face.away - a;
    const float square = dot(across, across);
    const float b = dot(across, cross(at, ac)) / square, c = dot(across, cross(ab, at)) / square;
    face.weights[0] = 1 - b - c;
    face.weights[1] = b;
    face.weights[2] = c;
    return face.distance > kRest * thickness_ && clear > clear_;
  }

 private:
  const NearPoint& near_;
  Index place_;
  float thickness_;
  Vec3<float> ahead_;
  float clear_;
};

/// Whether corners, of which some can move, may touch each other in this substep.
/// @param distance  m, between the points that touch
template <class Start>
[[nodiscard]] PBDSURG_HOST_DEVICE bool is_within_reach(const Start& start, const TissueTouch& touch,
                                                       float thickness, float distance) {
  float mobility = 0, reach = kTouchReach * thickness;
  for (int side = 0; side < 2; ++side) {
    float ways = 0;
    for (int k = touch.first_of(side); k < touch.end_of(side); ++k) {
      const float way = start.way(touch.places[k]);
      ways = ways < way ? way : ways;
      mobility += start.mobility(touch.places[k]);
    }
    const float most = kTouchWay * thickness;
    reach += ways < most ? ways : most;
  }
  return mobility > 0 && distance < reach && distance > -kDeepestTouch * thickness;
}

/// Makes a contact of one that has slot, bodies, corners, weights and normal.
/// @param distance  m, along the normal
/// @param h         s, of the substep
/// @param known     whose forces it goes on from; may be null
template <class Start>
PBDSURG_HOST_DEVICE void begin_touch(const Start& start, float distance, float thickness,
                                     float friction, float h, float inverse_dt_squared,
                                     const RememberedTouch* known, TissueTouch& touch) {
  touch.mu = friction;
  const float parted = distance + kRecovery * h;
  const float wanted = thickness < parted ? thickness : parted;
  touch.offset = start.counts_from_origin() ? wanted : wanted - distance;
  for (int k = 0; k < TissueTouch::kCorners; ++k) {
    touch.drift = touch.drift + touch.weights[k] * start.own_start(touch.places[k]);
  }
  if (known != nullptr) {
    const Vec3<float>& normal = touch.normal;
    touch.multiplier = known->force / inverse_dt_squared;
    const Vec3<float> along = known->friction - dot(known->friction, normal) * normal;
    touch.friction = (1 / inverse_dt_squared) * along;
  }
}

}  // namespace pbdsurg
