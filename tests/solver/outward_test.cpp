// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/outward.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <random>
#include <vector>

#include "pbdsurg/constraints/projection.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using Places = std::array<Index, 3>;

// A pyramid over a star of five points, with another below that reaches into it or stands on its
// own: vertices and edges that are convex, concave and saddles.
struct Star {
  std::vector<Eigen::Vector3d> positions;
  std::vector<Places> triangles;
};

Star make_star(double depth) {
  Star star;
  constexpr Index kRim = 10;
  for (Index k = 0; k < kRim; ++k) {
    const double angle = 2 * M_PI * k / kRim, radius = k % 2 == 0 ? 1 : 0.4;
    star.positions.emplace_back(radius * std::cos(angle), radius * std::sin(angle), 0);
  }
  star.positions.emplace_back(0, 0, 1);
  star.positions.emplace_back(0, 0, -depth);
  for (Index k = 0; k < kRim; ++k) {
    const Index next = (k + 1) % kRim;
    star.triangles.push_back({k, next, kRim});
    star.triangles.push_back({next, k, kRim + 1});
  }
  return star;
}

// Of the solid angle's turns around a point (van Oosterom and Strackee 1983): 1 within, 0 outside.
double winding_number(const Star& star, const Eigen::Vector3d& p) {
  double sum = 0;
  for (const Places& t : star.triangles) {
    const Eigen::Vector3d a = star.positions[t[0]] - p, b = star.positions[t[1]] - p,
                          c = star.positions[t[2]] - p;
    const double la = a.norm(), lb = b.norm(), lc = c.norm();
    sum += 2 * std::atan2(a.dot(b.cross(c)),
                          la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (4 * M_PI);
}

ContactFeature feature_of(std::initializer_list<Index> places) {
  ContactFeature feature;
  std::ranges::copy(places, feature.places);
  feature.sort();
  return feature;
}

struct Nearest {
  double distance = kInfinity;
  ContactFeature feature{};
  Eigen::Vector3d away;
};

void consider(const Eigen::Vector3d& p, const Eigen::Vector3d& q, const ContactFeature& feature,
              Nearest& best) {
  if ((q - p).norm() < best.distance) {
    best = {(q - p).norm(), feature, q - p};
  }
}

// Vertices first, then edges and insides where they are nearer.
Nearest find_nearest(const Star& star, const Eigen::Vector3d& p) {
  Nearest best;
  for (Index v = 0; v < static_cast<Index>(star.positions.size()); ++v) {
    consider(p, star.positions[v], feature_of({v}), best);
  }
  for (const Places& t : star.triangles) {
    for (int k = 0; k < 3; ++k) {
      const Index from = t[k], to = t[(k + 1) % 3];
      const Eigen::Vector3d d = star.positions[to] - star.positions[from];
      const double share = (p - star.positions[from]).dot(d) / d.squaredNorm();
      if (share > 0 && share < 1) {
        consider(p, star.positions[from] + share * d, feature_of({from, to}), best);
      }
    }
  }
  for (const Places& t : star.triangles) {
    const Eigen::Vector3d x = star.positions[t[0]];
    Eigen::Matrix3d frame;
    frame << star.positions[t[1]] - x, star.positions[t[2]] - x,
        (star.positions[t[1]] - x).cross(star.positions[t[2]] - x).normalized();
    const Eigen::Vector3d share = frame.inverse() * (p - x);
    if (share.x() > 0 && share.y() > 0 && share.x() + share.y() < 1) {
      consider(p, p - share.z() * frame.col(2), feature_of({t[0], t[1], t[2]}), best);
    }
  }
  return best;
}

Vec3<float> to_float(const Eigen::Vector3d& v) {
  return {static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z())};
}

}  // namespace

// Would catch weights, or an order of corners, with which the sum is wrong at some kind of vertex
// or edge.
TEST_CASE("outward: tells within from outside at every kind of feature", "[unit]") {
  const double depth = GENERATE(1.0, 0.05, -0.6);  // the last: a bowl
  const Star star = make_star(depth);
  std::mt19937 random(7);
  std::uniform_real_distribution<double> at(-1.2, 1.2);
  std::array<int, 3> within{}, outside{};  // [feature's corners - 1]
  for (int n = 0; n < 40'000; ++n) {
    const Eigen::Vector3d p(at(random), at(random), at(random));
    const Nearest nearest = find_nearest(star, p);
    if (nearest.distance < 1e-3) {
      continue;
    }
    Outward outward(nearest.feature);
    for (const Places& t : star.triangles) {
      outward.add(t.data(), [&](Index place) { return to_float(star.positions[place]); });
    }
    const bool is_within = winding_number(star, p) > 0.5;
    ++(is_within ? within : outside)[nearest.feature.count() - 1];
    if (outward.is_along(to_float(nearest.away)) != is_within) {
      CAPTURE(p, nearest.feature.places, nearest.distance);
      FAIL_CHECK("the wrong side");
      return;
    }
  }
  CHECK(within[1] + within[2] > 100);
  for (const int count : outside) {
    CHECK(count > 100);
  }
}

// Would catch sheets that tools go through, as either side sees the other from within.
TEST_CASE("outward: two sides tell nothing, nor does what has no area", "[unit]") {
  const std::array<Vec3<float>, 4> x = {
      Vec3<float>{0, 0, 0}, {0.3F, 0.01F, 0.1F}, {-0.1F, 0.2F, -0.04F}, {0.7F, 0.1F, 0.3F}};
  const auto position_of = [&](Index place) { return x[place]; };
  const ContactFeature feature =
      GENERATE(feature_of({0}), feature_of({0, 2}), feature_of({0, 1, 2}));
  Outward outward(feature);
  for (const Places& places :
       {Places{0, 1, 2}, Places{1, 0, 2}, Places{3, 0, 2}, Places{0, 3, 2}}) {
    outward.add(places.data(), position_of);
  }
  for (const Places& places : {Places{0, 0, 1}, Places{0, 2, 2}}) {
    outward.add(places.data(), position_of);
  }
  for (const Vec3<float>& away : {x[1], x[2], Vec3<float>{0, 0, 1}}) {
    CHECK_FALSE(outward.is_along(away));
    CHECK_FALSE(outward.is_along(-1.0F * away));
  }
}

TEST_CASE("outward: angles", "[unit]") {
  for (const float angle : {0.0F, 0.1F, 1.0F, 1.5F, 1.6F, 2.5F, 3.1F, 3.14159265F}) {
    CHECK(angle_of_cosine(std::cos(angle)) == Approx(angle).margin(4e-4));
  }
  CHECK(angle_of_cosine(1.0001F) == 0);
  CHECK(angle_of_cosine(-1.0001F) == Approx(3.14159265F));
}

}  // namespace pbdsurg
