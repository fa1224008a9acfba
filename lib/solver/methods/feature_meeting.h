// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a vertex, an edge or a triangle meets a tool in a substep, and goes on meeting it while
/// sweeps move it, for one of them, on a CPU or a device.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/segment.h"
#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/outward.h"
#include "lib/solver/state/surface_contact.h"

namespace pbdsurg {

/// A capsule in the world through a substep.
struct SweptCapsule {
  PlacedCapsule before;  ///< at its start
  PlacedCapsule now;     ///< at its end

  /// @param way  m
  [[nodiscard]] PBDSURG_HOST_DEVICE SweptCapsule moved(const Vec3<float>& way) const {
    return {before.moved(way), now.moved(way)};
  }

  [[nodiscard]] PBDSURG_HOST_DEVICE PlacedCapsule at(float share) const {
    return {before.start + share * (now.start - before.start), now.radius,
            before.end + share * (now.end - before.end),
            before.across + share * (now.across - before.across)};
  }

  /// m, the longest of its corners.
  [[nodiscard]] PBDSURG_HOST_DEVICE float way() const {
    using std::sqrt;
    float longest = 0;
    now.for_each_corner([&](const CorePlace& place) {
      const Vec3<float> own = now.corner(place) - before.corner(place);
      const float square = dot(own, own);
      longest = longest < square ? square : longest;
    });
    return sqrt(longest);
  }
  /// The way in radii.
  [[nodiscard]] PBDSURG_HOST_DEVICE float relative_way() const { return way() / now.radius; }
};

/// A half space in the world through a substep.
struct SweptHalfSpace {
  Vec3<float> normal;   ///< out of it
  Vec3<float> point;    ///< m, of its plane
  Vec3<float> turn[3];  ///< rows of what the turn of its tool adds to a way from the centre
  Vec3<float> centre;   ///< m, of the tool's frame
  Vec3<float> shift;    ///< m, of that

  /// @param way  m
  [[nodiscard]] PBDSURG_HOST_DEVICE SweptHalfSpace moved(const Vec3<float>& way) const {
    return {normal, point + way, {turn[0], turn[1], turn[2]}, centre + way, shift};
  }
};

/// Corners of a feature through a substep.
struct FeatureCorners {
  int count = 0;
  Index places[3] = {kInvalidIndex, kInvalidIndex, kInvalidIndex};
  Vec3<float> start[3], end[3];  ///< m
  bool is_fixed[3] = {};

  /// A tool on a spring gives way in place of corners that do not.
  PBDSURG_HOST_DEVICE void take_as_free() { is_fixed[0] = is_fixed[1] = is_fixed[2] = false; }

  /// Calls visit(k) for each. A loop to three keeps corners in a device's registers.
  template <class Visit>
  PBDSURG_HOST_DEVICE void for_each(const Visit& visit) const {
    for (int k = 0; k < 3; ++k) {
      if (k < count) {
        visit(k);
      }
    }
  }
};

/// The plane that stands for a tool near a feature.
struct MetFeature {
  float gap = kInfinity;  ///< m, negative inside; infinite while there is no contact
  float weights[3] = {};
  Vec3<float> normal;             ///< out of the tool
  Vec3<float> point;              ///< m, of the tool's surface
  Vec3<float> way;                ///< m, of that point of the tool in the substep
  float height = 0;               ///< m, of the plane: normal . x of its points
  Index capsule = kInvalidIndex;  ///< of the tool; kInvalidIndex: a half space
};

PBDSURG_HOST_DEVICE inline ContactFeature feature_of(const FeatureCorners& corners) {
  return {{corners.places[0], corners.places[1], corners.places[2]}};
}

/// Where a corner is at a share of the substep.
PBDSURG_HOST_DEVICE inline Vec3<float> at_share(const Vec3<float>& start, const Vec3<float>& end,
                                                float share) {
  return share < 1 ? start + share * (end - start) : end;
}

/// m, how thick a capsule is for what touches it: a plate is as thick as its shorter side where its
/// flat does, and its rim is that of a rod, from a lean of 30 degrees on.
/// @param normal  unit, of the contact
PBDSURG_HOST_DEVICE inline float thickness_of(const PlacedCapsule& capsule,
                                              const Vec3<float>& normal) {
  using std::sqrt;
  constexpr float kSteep = 4;  // over the square of the sine
  if (!capsule.is_plate()) {
    return 2 * capsule.radius;
  }
  const Vec3<float> way = capsule.end - capsule.start;
  const float along = dot(way, way), across = dot(capsule.across, capsule.across);
  const float up_along = dot(normal, way), up_across = dot(normal, capsule.across);
  const float lean =
      (along > 0 ? up_along * up_along / along : 0.0F) + up_across * up_across / across;
  const float flat = 1 - kSteep * lean;
  return 2 * capsule.radius + (flat > 0 ? flat : 0.0F) * sqrt(along < across ? along : across);
}

/// That over the longest side of a feature: infinite for a vertex, which has none.
/// @param position_of  (place) -> m
template <class PositionOf>
PBDSURG_HOST_DEVICE inline float relative_thickness(const PlacedCapsule& capsule,
                                                    const ContactFeature& feature,
                                                    const Vec3<float>& normal,
                                                    const PositionOf& position_of) {
  using std::sqrt;
  float square = 0;
  for (int k = 1; k < 3; ++k) {
    for (int j = 0; j < k && feature.places[k] != kInvalidIndex; ++j) {
      const Vec3<float> side = position_of(feature.places[k]) - position_of(feature.places[j]);
      const float own = dot(side, side);
      square = square < own ? own : square;
    }
  }
  return square > 0 ? thickness_of(capsule, normal) / sqrt(square) : kInfinity;
}

/// What holds all corners of a feature through the substep.
PBDSURG_HOST_DEVICE inline ContactBox box_of(const FeatureCorners& corners) {
  ContactBox box;
  corners.for_each([&](int k) { box.add(corners.start[k], corners.end[k], 0); });
  return box;
}

namespace feature_meeting {

// An edge's ends are its vertices' business: shares of its length.
inline constexpr float kEnd = 0.02F;
// Of the radius, that tool and tissue may move against each other between two looks.
inline constexpr float kStride = 0.5F;
inline constexpr int kMostLooks = 64;
// Of the radius: nearer to the axis, as where it runs through a triangle, directions are rounding.
inline constexpr float kOnAxis = 0.01F;
inline constexpr float kPlaneMargin = 1e-3F;  // m, beside what a vertex moves in the substep

PBDSURG_HOST_DEVICE inline Vec3<float> between(const Vec3<float>& from, const Vec3<float>& to,
                                               float share) {
  return from + share * (to - from);
}

PBDSURG_HOST_DEVICE inline float length(const Vec3<float>& v) {
  using std::sqrt;
  return sqrt(dot(v, v));
}

PBDSURG_HOST_DEVICE inline float larger(float a, float b) {
  return a < b ? b : a;
}

// Where a feature is nearest to an axis, or to the rectangle of a plate.
struct Meeting {
  float weights[3] = {};
  CorePlace place;
  Vec3<float> away;  // m, from there to the feature
  float distance = kInfinity;
};

PBDSURG_HOST_DEVICE inline Meeting meet_vertex(const Vec3<float>& x, const PlacedCapsule& capsule) {
  const CorePlace place = capsule.closest(x);
  const Vec3<float> away = x - capsule.at(place);
  return {{1, 0, 0}, place, away, length(away)};
}

// On a side.
PBDSURG_HOST_DEVICE inline CorePlace between(const CorePlace& from, const CorePlace& to,
                                             float share) {
  return {from.along + share * (to.along - from.along),
          from.across + share * (to.across - from.across)};
}

// Where an edge goes through the rectangle of a plate.
PBDSURG_HOST_DEVICE inline Meeting pierce_plate(const Vec3<float> (&x)[3],
                                                const PlacedCapsule& plate) {
  const Vec3<float> normal = cross(plate.end - plate.start, plate.across);
  const float first = dot(x[0] - plate.start, normal), second = dot(x[1] - plate.start, normal);
  if (!(first * second < 0)) {
    return {};
  }
  const float share = first / (first - second);
  const Vec3<float> point = between(x[0], x[1], share);
  const CorePlace place = plate.closest(point);
  const Vec3<float> beside = point - plate.at(place);
  return dot(beside, beside) <= kOnAxis * kOnAxis * plate.radius * plate.radius
             ? Meeting{{1 - share, share, 0}, place, beside, length(beside)}
             : Meeting{};
}

PBDSURG_HOST_DEVICE inline Meeting meet_edge(const Vec3<float> (&x)[3],
                                             const PlacedCapsule& capsule) {
  Meeting best;
  capsule.for_each_side([&](const CorePlace& from, const CorePlace& to) {
    const Vec3<float> a = capsule.corner(from), b = capsule.corner(to);
    const SegmentPair pair = closest_of_segments(a, b, x[0], x[1]);
    const Vec3<float> away = between(x[0], x[1], pair.second) - between(a, b, pair.first);
    const float distance = length(away);
    if (distance < best.distance) {
      best = {{1 - pair.second, pair.second, 0}, between(from, to, pair.first), away, distance};
    }
  });
  if (capsule.is_plate()) {
    const Meeting inside = pierce_plate(x, capsule);
    best = inside.distance < best.distance ? inside : best;
    if (meet_vertex(x[0], capsule).distance <= best.distance ||
        meet_vertex(x[1], capsule).distance <= best.distance) {
      return {};
    }
  }
  return best.weights[1] < kEnd || best.weights[1] > 1 - kEnd ? Meeting{} : best;
}

// Takes the point of a triangle's plane below one of the axis, if that is within the triangle and
// nearer.
PBDSURG_HOST_DEVICE inline void consider(const Vec3<float> (&x)[3], const Vec3<float>& p,
                                         const CorePlace& place, Meeting& best) {
  const Vec3<float> first = x[1] - x[0], second = x[2] - x[0];
  const Vec3<float> normal = cross(first, second);
  const float square = dot(normal, normal);
  const Vec3<float> d = p - x[0];
  const float b = dot(cross(d, second), normal) / square;
  const float c = dot(cross(first, d), normal) / square;
  const float rest = 1 - b - c;
  if (!(rest > kEnd && b > kEnd && c > kEnd)) {
    return;
  }
  const Vec3<float> away = rest * x[0] + b * x[1] + c * x[2] - p;
  const float distance = length(away);
  if (distance < best.distance) {
    best = {{rest, b, c}, place, away, distance};
  }
}

PBDSURG_HOST_DEVICE inline Meeting meet_triangle(const Vec3<float> (&x)[3],
                                                 const PlacedCapsule& capsule) {
  Meeting best;
  capsule.for_each_corner(
      [&](const CorePlace& place) { consider(x, capsule.corner(place), place, best); });
  const Vec3<float> normal = cross(x[1] - x[0], x[2] - x[0]);
  capsule.for_each_side([&](const CorePlace& from, const CorePlace& to) {
    const Vec3<float> a = capsule.corner(from), b = capsule.corner(to);
    const float share = dot(x[0] - a, normal) / dot(b - a, normal);
    if (share > 0 && share < 1) {
      consider(x, between(a, b, share), between(from, to, share), best);
    }
  });
  return best;
}

PBDSURG_HOST_DEVICE inline Meeting meet(int count, const Vec3<float> (&x)[3],
                                        const PlacedCapsule& capsule) {
  return count == 1   ? meet_vertex(x[0], capsule)
         : count == 2 ? meet_edge(x, capsule)
                      : meet_triangle(x, capsule);
}

// At a share of the substep.
PBDSURG_HOST_DEVICE inline Meeting meet_at(const FeatureCorners& corners, float share,
                                           const SweptCapsule& capsule) {
  Vec3<float> x[3];
  corners.for_each([&](int k) { x[k] = at_share(corners.start[k], corners.end[k], share); });
  return meet(corners.count, x, share < 1 ? capsule.at(share) : capsule.now);
}

// The plane of a capsule where a feature meets it.
PBDSURG_HOST_DEVICE inline MetFeature plane_of(const SweptCapsule& capsule, const Meeting& hit,
                                               const Vec3<float>& normal, Index index) {
  const auto& [before, now] = capsule;
  const Vec3<float> centre = now.at(hit.place);
  MetFeature met;
  for (int k = 0; k < 3; ++k) {
    met.weights[k] = hit.weights[k];
  }
  met.normal = normal;
  met.point = centre + now.radius * normal;
  met.way = met.point - (before.at(hit.place) + now.radius * normal);
  met.height = dot(normal, centre) + now.radius;
  met.capsule = index;
  return met;
}

}  // namespace feature_meeting

/// Considers one capsule of a tool, and keeps the plane with the least gap. A feature is met where
/// it is within a quarter of the capsule's radius where the substep ends, on the side where it was;
/// else where it was near on its way, as it has gone through, perhaps up the shaft. One with a
/// fixed corner inside is not met, for no push gets it out; nor is one that is met first from
/// within its tissue, which a tool that heat has let in would blow up.
/// @param index    of the capsule
/// @param known    the normal that it had in the substep before, where the tool keeps it on the
///                 same side; null if there was none
/// @param outward  (share of the substep) -> Outward, of the feature then
template <class OutwardAt>
PBDSURG_HOST_DEVICE inline void meet_capsule(const FeatureCorners& corners,
                                             const SweptCapsule& capsule, Index index,
                                             const Vec3<float>* known, const OutwardAt& outward,
                                             MetFeature& deepest) {
  using namespace feature_meeting;
  using std::ceil;
  const PlacedCapsule& now = capsule.now;
  const float radius = now.radius;
  const float reach = (1 + kContactMargin) * radius, on_axis = kOnAxis * radius;
  bool is_fixed_inside = false;
  corners.for_each([&](int k) {
    is_fixed_inside |= corners.is_fixed[k] && meet_vertex(corners.end[k], now).distance < radius;
  });
  if (is_fixed_inside) {
    return;
  }
  const Meeting end = meet_at(corners, 1, capsule);
  bool has_side = known != nullptr;
  Vec3<float> side = has_side ? *known : Vec3<float>{};
  // where it ends, unless it is on its way through
  const auto is_met_at_end = [&] { return end.distance < reach && dot(end.away, side) > on_axis; };
  bool is_hit = has_side && is_met_at_end();
  Meeting hit = end;
  float travel = 0;
  corners.for_each(
      [&](int k) { travel = larger(travel, length(corners.end[k] - corners.start[k])); });
  travel = travel + capsule.way();
  const float strides = ceil(travel / (kStride * radius));
  const int looks = !(strides > 1)         ? 1
                    : strides < kMostLooks ? static_cast<int>(strides)
                                           : kMostLooks;
  // the first look is at the start: what was near then, sweeps may bring back
  bool is_early = false;
  for (int look = 0; look < (known != nullptr ? 1 : looks) && !is_hit; ++look) {
    const float share = static_cast<float>(look) / static_cast<float>(looks);
    const Meeting early = meet_at(corners, share, capsule);
    if (early.distance < reach && (has_side || early.distance > on_axis)) {
      if (!has_side && outward(share).is_along(early.away)) {
        return;
      }
      side = has_side ? side : (1 / early.distance) * early.away;
      has_side = true;
      is_hit = true;
      is_early = !(end.distance < kInfinity && dot(end.away, side) > on_axis);
      hit = is_early ? early : end;
    }
  }
  if (!is_hit && (!(end.distance < reach) || (!has_side && outward(1.0F).is_along(end.away)))) {
    return;
  }
  const Vec3<float> centre = now.at(hit.place);
  const Vec3<float> x = hit.weights[0] * corners.end[0] + hit.weights[1] * corners.end[1] +
                        hit.weights[2] * corners.end[2];
  const Vec3<float> away = x - centre;
  const float distance = length(away);
  Vec3<float> normal;
  if (is_early && (end.distance < kInfinity || distance < reach)) {
    normal = side;  // what was nearest then may have slid along the tool since
  } else if (distance > on_axis && (!has_side || dot(away, side) > 0)) {
    normal = (1 / distance) * away;
  } else if (has_side) {
    normal = distance > on_axis && !is_early ? (-1 / distance) * away : side;
  } else {
    return;  // it has no side to be pushed to
  }
  const float gap = dot(normal, away) - radius;
  if (gap < deepest.gap) {
    deepest = plane_of(capsule, hit, normal, index);
    deepest.gap = gap;
  }
}

/// Likewise a half space, with all vertices that are near its plane or come near in the substep.
PBDSURG_HOST_DEVICE inline void meet_half_space(const FeatureCorners& vertex,
                                                const SweptHalfSpace& half_space, MetFeature& met) {
  using namespace feature_meeting;
  const Vec3<float> x = vertex.end[0];
  const Vec3<float>& normal = half_space.normal;
  const float gap = dot(normal, x - half_space.point);
  if (!(gap < kPlaneMargin + length(x - vertex.start[0]))) {
    return;
  }
  met.gap = gap;
  met.weights[0] = 1;
  met.weights[1] = met.weights[2] = 0;
  met.normal = normal;
  met.point = x - gap * normal;
  const Vec3<float> arm = met.point - half_space.centre;
  met.way = Vec3<float>{dot(half_space.turn[0], arm), dot(half_space.turn[1], arm),
                        dot(half_space.turn[2], arm)} +
            half_space.shift;
  met.height = dot(normal, half_space.point);
}

/// The gap at which a contact pushes no more: none, but for the share of fixed corners that are
/// inside. No push moves these; for them, others would have to go the further the nearer to them
/// the contact is.
/// @return  m, <= 0
PBDSURG_HOST_DEVICE inline float gap_to_reach(const FeatureCorners& corners,
                                              const MetFeature& met) {
  float gap_of_fixed = 0;
  corners.for_each([&](int k) {
    const float gap = dot(met.normal, corners.end[k]) - met.height;
    if (gap < 0 && corners.is_fixed[k]) {
      gap_of_fixed += met.weights[k] * gap;
    }
  });
  return gap_of_fixed;
}

/// @param base   (place) -> m, from where displacements of a vertex count
/// @param start  (place) -> m, where it would be, as they count, had it not moved
template <class Base, class Start>
PBDSURG_HOST_DEVICE inline SurfaceContact contact_of(const FeatureCorners& corners,
                                                     const MetFeature& met, const Base& base,
                                                     const Start& start) {
  SurfaceContact contact;
  contact.feature = feature_of(corners);
  contact.capsule = met.capsule;
  contact.normal = met.normal;
  contact.point = met.point;
  contact.drift = met.way;
  contact.offset = met.height + gap_to_reach(corners, met);
  corners.for_each([&](int k) {
    const Index place = corners.places[k];
    contact.weights[k] = met.weights[k];
    contact.offset = contact.offset - met.weights[k] * dot(met.normal, base(place));
    contact.drift = contact.drift + met.weights[k] * start(place);
  });
  return contact;
}

/// Turns the plane of a contact to where sweeps have moved its feature. Without that, an edge along
/// a thin tool would be pushed at one end in a substep and at the other in the next, without end.
/// Its plane stays where the feature is met no more, as the nearest point has left its inside, or
/// is behind the axis as the plane sees it.
/// @param capsule  that it meets, where its spring has let it be
/// @param shift    m, of its tool: see ToolSpring
/// @param base     as of contact_of(), and start
template <class Base, class Start>
PBDSURG_HOST_DEVICE inline void turn_to(const FeatureCorners& corners, const SweptCapsule& capsule,
                                        const Vec3<float>& shift, const Base& base,
                                        const Start& start, SurfaceContact& contact) {
  using namespace feature_meeting;
  const Meeting now = meet_at(corners, 1, capsule);
  if (!(now.distance < kInfinity) ||
      !(dot(now.away, contact.normal) > kOnAxis * capsule.now.radius)) {
    return;
  }
  const MetFeature met = plane_of(capsule, now, (1 / now.distance) * now.away, contact.capsule);
  SurfaceContact turned = contact_of(corners, met, base, start);
  turned.offset = turned.offset - dot(met.normal, shift);
  turned.point = turned.point - shift;  // as those of the start
  // what has turned away of a force that others held against is lost: it would throw corners off
  turned.multiplier = dot(contact.normal, met.normal) * contact.multiplier;
  turned.friction = contact.friction - dot(contact.friction, met.normal) * met.normal;
  turned.stiffness = contact.stiffness;
  contact = turned;
}

/// What the next substep has to know; no force of a contact that is left inside, which would grow
/// without bound where contacts are against each other, as around a tool that is put into tissue.
PBDSURG_HOST_DEVICE inline RememberedContact remembered(const SurfaceContact& contact,
                                                        float inverse_dt_squared) {
  const float scale = contact.is_left_inside ? 0 : inverse_dt_squared;
  return {contact.feature, contact.normal, scale * contact.multiplier, scale * contact.friction};
}

/// Vertex blocks go on from the forces of the substep before.
PBDSURG_HOST_DEVICE inline void recall(const RememberedContact& known, float inverse_dt_squared,
                                       SurfaceContact& contact) {
  contact.multiplier = known.force / inverse_dt_squared;
  const Vec3<float> along = known.friction - dot(known.friction, contact.normal) * contact.normal;
  contact.friction = (1 / inverse_dt_squared) * along;
}

}  // namespace pbdsurg
