// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/feature_meeting.h"

#include <cmath>
#include <random>

#include "lib/solver/methods/contact_multipliers.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using FloatVector = Vec3<float>;

constexpr float kRodRadius = 0.5e-3F;

// At rest, around the origin, its normal in the plane of x and z.
FeatureCorners make_triangle(const FloatVector& normal) {
  const FloatVector across{0, 1, 0};
  const FloatVector along = cross(across, normal);
  FeatureCorners corners;
  corners.count = 3;
  const FloatVector places[3] = {-5e-3F * along - 5e-3F * across, 5e-3F * along - 5e-3F * across,
                                 5e-3F * across};
  for (int k = 0; k < 3; ++k) {
    corners.places[k] = k;
    corners.start[k] = corners.end[k] = places[k];
  }
  return corners;
}

// Does not move.
SweptCapsule make_rod(const FloatVector& start, const FloatVector& end) {
  const PlacedCapsule capsule{start, kRodRadius, end};
  return {capsule, capsule};
}

}  // namespace

// Would catch a rod that lies nearly along a triangle, and pushes it to where rounding says.
TEST_CASE("feature meeting: what a tool's axis runs through has no side of its own", "[unit]") {
  const float lean = GENERATE(0.01F, 0.1F, 0.7F);
  const float offset = GENERATE(-1e-3F, 1e-5F, 0.7e-3F);  // m, along the rod
  const FeatureCorners triangle = make_triangle({1, 0, lean});
  const SweptCapsule rod = make_rod({0, 0, offset - 1}, {0, 0, offset + 1});
  const auto unknown = [&](float) { return Outward(feature_of(triangle)); };
  MetFeature met;
  meet_capsule(triangle, rod, 0, nullptr, unknown, met);
  CHECK(!(met.gap < kInfinity));

  const FloatVector side{-1, 0, 0};
  meet_capsule(triangle, rod, 0, &side, unknown, met);
  CHECK(met.gap == Approx(-kRodRadius).epsilon(1e-2));
  CHECK(dot(met.normal, side) == Approx(1));
}

// Would catch a vertex that a fast tip has passed, and that is met at the shaft beside it.
TEST_CASE("feature meeting: what was before a tip goes back there", "[unit]") {
  const float beside = GENERATE(0.0F, 1e-3F, 0.5F);  // of the radius
  const bool was_met = GENERATE(false, true);
  FeatureCorners vertex;
  vertex.count = 1;
  vertex.places[0] = 0;
  vertex.start[0] = {0, 0, -kRodRadius};
  vertex.end[0] = {beside * kRodRadius, 0, 3 * kRodRadius};
  const FloatVector side{0, 0, -1};
  MetFeature met;
  meet_capsule(
      vertex, make_rod({0, 0, 0}, {0, 0, 1}), 0, was_met ? &side : nullptr,
      [&](float) { return Outward(feature_of(vertex)); }, met);
  CHECK(met.gap == Approx(-4 * kRodRadius));
  CHECK(met.normal.z == Approx(-1));
}

// Would catch a plane along the edge that it is of: a rod goes aslant through an edge, and ends on
// it, beside where it was near first.
TEST_CASE("feature meeting: an edge that a rod has come through keeps its side", "[unit]") {
  FeatureCorners edge;
  edge.count = 2;
  const FloatVector ends[2] = {{1.3e-3F, -5e-3F, 0}, {1.3e-3F, 5e-3F, 0}};
  for (int k = 0; k < 2; ++k) {
    edge.places[k] = k;
    edge.start[k] = edge.end[k] = ends[k];
  }
  SweptCapsule rod = make_rod({0, 0, -1}, {0, 0, 1});
  rod.now = rod.before.moved({1.298e-3F, -0.8e-3F, 0});  // short of it by a rounding
  MetFeature met;
  meet_capsule(
      edge, rod, 0, nullptr, [&](float) { return Outward(feature_of(edge)); }, met);
  CHECK(met.normal.x == Approx(1).epsilon(1e-3));
  CHECK(met.gap == Approx(-kRodRadius).epsilon(1e-2));
}

// Would catch a threshold that lets thin tools through: the tip of a rod just above a triangle.
TEST_CASE("feature meeting: a tip above a triangle pushes it down", "[unit]") {
  const float height = GENERATE(0.02F, 0.5F, 1.2F);  // of the radius
  const FeatureCorners triangle = make_triangle({0, 0, 1});
  const SweptCapsule rod = make_rod({0, 0, height * kRodRadius}, {0, 0, 1});
  const auto unknown = [&](float) { return Outward(feature_of(triangle)); };
  MetFeature met;
  meet_capsule(triangle, rod, 0, nullptr, unknown, met);
  CHECK(met.gap == Approx((height - 1) * kRodRadius).margin(1e-8));
  CHECK(met.normal.z == Approx(-1));
}

// Would catch tools that heat has let into tissue, and that blow it up from within.
TEST_CASE("feature meeting: from within its tissue a surface is met only by who knows it",
          "[unit]") {
  const bool is_swept = GENERATE(false, true);
  const FeatureCorners triangle = make_triangle({0, 0, -1});
  const PlacedCapsule far{{0, 0, 4 * kRodRadius}, kRodRadius, {0, 0, 1}};
  const PlacedCapsule near{{0, 0, 0.5F * kRodRadius}, kRodRadius, {0, 0, 1}};
  const SweptCapsule tip{is_swept ? far : near, near};
  const auto outward_of = [&](float way) {
    return [&triangle, way](float share) {
      CHECK((share >= 0 && share <= 1));
      Outward outward(feature_of(triangle));
      const Index places[3] = {0, way > 0 ? 1 : 2, way > 0 ? 2 : 1};
      outward.add(places, [&](Index place) { return triangle.end[place]; });
      return outward;
    };
  };
  const FloatVector side{0, 0, -1};
  MetFeature met;
  meet_capsule(triangle, tip, 0, nullptr, outward_of(1), met);
  CHECK(!(met.gap < kInfinity));
  SECTION("one that has met it before") {
    meet_capsule(triangle, tip, 0, &side, outward_of(1), met);
  }
  SECTION("one outside") {
    meet_capsule(triangle, tip, 0, nullptr, outward_of(-1), met);
  }
  CHECK(met.gap == Approx(-0.5F * kRodRadius));
  CHECK(met.normal.z == Approx(-1));
}

// Would catch a plane that stays where its feature was, counts the way of a spring twice or not,
// forgets how the tool moves or that a corner is fixed, turns to the other side, or turns all of a
// force with it; the truth is the distance from the axis.
TEST_CASE("feature meeting: the plane of a contact follows its feature", "[property]") {
  using namespace feature_meeting;
  std::mt19937 random(7);
  std::uniform_real_distribution<float> sign(-1, 1);
  const auto any = [&](float size) {
    return FloatVector{size * sign(random), size * sign(random), size * sign(random)};
  };
  const int count = GENERATE(1, 2, 3);
  int followed = 0, kept = 0, with_fixed = 0;
  for (int trial = 0; trial < 4000; ++trial) {
    SweptCapsule rod = make_rod({0, 0, -1e-3F}, {0, 0, 1e-3F});
    const FloatVector way_of_rod = any(0.2F * kRodRadius);
    rod.before = rod.now.moved(-1.0F * way_of_rod);
    FeatureCorners corners;
    corners.count = count;
    FloatVector bases[3], ways[3], starts[3];
    for (int k = 0; k < count; ++k) {
      corners.places[k] = k;
      corners.start[k] = corners.end[k] = bases[k] = any(2e-3F);
      ways[k] = any(1.2F * kRodRadius);
      starts[k] = any(kRodRadius);
    }
    const auto base = [&](Index place) { return bases[place]; };
    const auto start = [&](Index place) { return starts[place]; };
    MetFeature met;
    meet_capsule(
        corners, rod, 4, nullptr, [&](float) { return Outward(feature_of(corners)); }, met);
    if (!(met.gap < kInfinity)) {
      continue;
    }
    SurfaceContact contact = contact_of(corners, met, base, start);
    contact.multiplier = 2;
    contact.stiffness = 3;
    contact.friction = cross(met.normal, any(1));
    const SurfaceContact before = contact;
    corners.is_fixed[0] = trial % 2 == 0;
    for (int k = 0; k < count; ++k) {
      corners.end[k] = bases[k] + ways[k];
    }
    const FloatVector shift = any(0.2F * kRodRadius);
    const PlacedCapsule axis = rod.moved(shift).now;
    const Meeting nearest = meet(count, corners.end, axis);
    const float height = dot(nearest.away, met.normal);

    turn_to(corners, rod.moved(shift), shift, base, start, contact);

    CHECK(contact.capsule == 4);
    CHECK(contact.multiplier == Approx(2 * dot(before.normal, contact.normal)));
    CHECK(contact.stiffness == 3);
    CHECK(std::abs(dot(contact.friction, contact.normal)) < 1e-5F);
    if (nearest.distance < kInfinity && height > 2 * kOnAxis * kRodRadius) {
      ++followed;
      FloatVector sum, slip;
      float fixed_inside = 0;  // m, that others need not make good
      for (int k = 0; k < count; ++k) {
        sum = sum + contact.weights[k] * ways[k];
        slip = slip + contact.weights[k] * (ways[k] - starts[k]);
        const float gap =
            dot(contact.normal, corners.end[k] - shift) - dot(contact.normal, contact.point);
        fixed_inside += corners.is_fixed[k] && gap < 0 ? contact.weights[k] * gap : 0;
      }
      slip = slip - way_of_rod - shift;
      slip = slip - dot(slip, contact.normal) * contact.normal;
      const ContactReading<float> reading = read_plane(contact, sum - shift);
      CHECK(reading.gap == Approx(nearest.distance - kRodRadius - fixed_inside).margin(2e-8));
      CHECK(length(reading.slip - slip) < 2e-8F);
      const FloatVector centre = rod.now.at(nearest.place);
      CHECK(length(contact.point - centre) == Approx(kRodRadius));  // without the shift
      with_fixed += fixed_inside < 0 ? 1 : 0;
    } else if (!(nearest.distance < kInfinity) || height < 0) {
      ++kept;
      CHECK(contact.offset == before.offset);
      CHECK(dot(contact.normal, before.normal) == Approx(1));
    }
  }
  CHECK(followed > 100);
  CHECK(kept > 10);
  CHECK(with_fixed > 10);
}

}  // namespace pbdsurg
