// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/implicit_shape.h"

#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using Eigen::Vector4d;
using testing::Approx;
using testing::ContainsSubstring;

const std::array<Vector4d, 4> kKnots{Vector4d{0, 0, 0, 0.010}, Vector4d{0.02, 0, 0.005, 0.014},
                                     Vector4d{0.04, 0.01, 0, 0.006},
                                     Vector4d{0.05, 0.03, 0, 0.003}};

// A point of a box, `element` of many.
Vector3d random_point(const Eigen::AlignedBox3d& box, int element) {
  Vector3d unit;
  for (int axis = 0; axis < 3; ++axis) {
    unit[axis] = random_unit(1, static_cast<std::uint64_t>(element), axis);
  }
  return box.min() + unit.cwiseProduct(box.sizes());
}

Eigen::AlignedBox3d grown(const Eigen::AlignedBox3d& box) {
  return Eigen::AlignedBox3d(box.min() - 0.5 * box.sizes(), box.max() + 0.5 * box.sizes());
}

struct NamedShape {
  std::string name;
  ImplicitShape shape;
  double lipschitz;  // the tetrahedraliser needs 1.3 at most
};

std::vector<NamedShape> all_shapes() {
  const ImplicitShape ball = sphere_shape({0.01, 0, 0}, 0.01);
  const ImplicitShape box = rounded_box_shape({0, 0, 0}, {0.02, 0.01, 0.015}, 0.004);
  const ImplicitShape tube = tube_shape(kKnots);
  return {{"sphere", ball, 1},
          {"capsule", capsule_shape({0, 0, 0}, {0.03, 0.01, 0}, 0.005), 1},
          {"round cone", round_cone_shape({0, 0, 0}, 0.012, {0.03, 0.01, 0.01}, 0.004), 1},
          {"swallowed round cone", round_cone_shape({0, 0, 0}, 0.012, {0.003, 0, 0}, 0.004), 1},
          {"tube", tube, 1},
          {"ellipsoid", ellipsoid_shape({0, 0, 0}, {0.040, 0.010, 0.0095}), 1},
          {"box", box, 1},
          {"union", smooth_union(ball, box, 0.005), 1},
          {"intersection", smooth_intersection(ball, box, 0.005), 1},
          {"difference", smooth_difference(box, ball, 0.005), 1},
          {"cut box", smooth_intersection(box, half_space_shape({0, 0, 0}, {1, 1, 0}), 0), 1},
          {"offset", offset_shape(tube, 0.002), 1},
          {"shell", shell_shape(tube, 0.001), 1}};
}

}  // namespace

// Would catch a wrong normalisation, a jump between two regions of a distance, and a piece that is
// culled though it is the nearest.
TEST_CASE("implicit shape: values change no faster than distance", "[property]") {
  for (const auto& [name, shape, lipschitz] : all_shapes()) {
    CAPTURE(name);
    const Eigen::AlignedBox3d box = grown(shape.bounds());
    for (int i = 0; i < 2000; ++i) {
      const Vector3d a = random_point(box, 2 * i);
      // near and far pairs
      const double reach = std::pow(0.1, i % 4);
      const Vector3d b = a + reach * (random_point(box, 2 * i + 1) - a);
      REQUIRE(std::abs(shape(a) - shape(b)) <= lipschitz * (a - b).norm() * (1 + 1e-9) + 1e-15);
    }
  }
}

TEST_CASE("implicit shape: the box holds all of the inside", "[property]") {
  for (const auto& [name, shape, lipschitz] : all_shapes()) {
    CAPTURE(name);
    int inside = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vector3d point = random_point(grown(shape.bounds()), i);
      if (shape(point) < 0) {
        ++inside;
        REQUIRE(shape.bounds().contains(point));
      }
    }
    CHECK(inside > 20);
  }
}

// The hull of two spheres is the union of the spheres in between.
TEST_CASE("implicit shape: a round cone is the hull of its spheres", "[unit]") {
  const Vector3d from(0, 0, 0), to(0.03, 0.01, 0.01);
  const ImplicitShape cone = round_cone_shape(from, 0.012, to, 0.004);
  for (int i = 0; i < 200; ++i) {
    const Vector3d point = random_point(grown(cone.bounds()), i);
    double nearest = std::numeric_limits<double>::infinity();
    constexpr int kSpheres = 4000;
    for (int s = 0; s <= kSpheres; ++s) {
      const double t = static_cast<double>(s) / kSpheres;
      const Vector3d center = (1 - t) * from + t * to;
      nearest = std::min(nearest, (point - center).norm() - ((1 - t) * 0.012 + t * 0.004));
    }
    // the minimum over spheres is flat, so the sampling error is of second order
    CHECK(cone(point) == Approx(nearest).margin(1e-8));
  }
}

// Would catch culling that loses the nearest piece.
TEST_CASE("implicit shape: a tube is the union of its pieces", "[property]") {
  const ImplicitShape tube = tube_shape(kKnots, 8);
  // the same spline, evaluated here
  std::vector<Vector4d> path{kKnots[0]};
  for (std::size_t span = 0; span + 1 < kKnots.size(); ++span) {
    const Vector4d b = kKnots[span], c = kKnots[span + 1];
    const Vector4d a = span > 0 ? kKnots[span - 1] : Vector4d(2 * b - c);
    const Vector4d d = span + 2 < kKnots.size() ? kKnots[span + 2] : Vector4d(2 * c - b);
    for (int piece = 1; piece <= 8; ++piece) {
      const double t = piece / 8.0;
      path.push_back(b + 0.5 * t *
                             (c - a + t * (2 * a - 5 * b + 4 * c - d + t * (3 * (b - c) + d - a))));
    }
  }
  for (int i = 0; i < 500; ++i) {
    const Vector3d point = random_point(grown(tube.bounds()), i);
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k + 1 < path.size(); ++k) {
      const ImplicitShape cone =
          round_cone_shape(path[k].head<3>(), path[k].w(), path[k + 1].head<3>(), path[k + 1].w());
      nearest = std::min(nearest, cone(point));
    }
    REQUIRE(tube(point) == Approx(nearest).margin(1e-12));
  }
  CHECK(tube(kKnots[2].head<3>()) <= -kKnots[2].w() * 0.999);
}

TEST_CASE("implicit shape: known values", "[unit]") {
  const ImplicitShape ball = sphere_shape({0, 0, 0}, 2);
  CHECK(ball({5, 0, 0}) == Approx(3));
  CHECK(shell_shape(ball, 0.5)({0, 0, 0}) == Approx(1.5));
  CHECK(shell_shape(ball, 0.5)({1.75, 0, 0}) == Approx(-0.25));
  CHECK(offset_shape(ball, 0.5)({5, 0, 0}) == Approx(2.5));
  CHECK(half_space_shape({1, 0, 0}, {2, 0, 0})({4, 7, 7}) == Approx(3));
  CHECK(ellipsoid_shape({0, 0, 0}, {1, 2, 3})({0, 2, 0}) == Approx(0).margin(1e-6));
  CHECK(ellipsoid_shape({0, 0, 0}, {1, 2, 3})({0, 0, 0}) == Approx(-1).margin(1e-6));
  CHECK(ellipsoid_shape({0, 0, 0}, {1, 2, 3})({0, 0, 7}) == Approx(4).margin(1e-6));
  CHECK(ellipsoid_shape({0, 0, 0}, {2, 2, 2})({3, 4, 0}) == Approx(3).margin(1e-6));
  // equal values are lowered by a quarter of the blend radius
  CHECK(smooth_union(ball, ball, 0.4)({3, 0, 0}) == Approx(0.9));
  CHECK(smooth_intersection(ball, ball, 0.4)({3, 0, 0}) == Approx(1.1));
  CHECK(smooth_union(ball, offset_shape(ball, 0.4), 0.4)({3, 0, 0}) == Approx(0.6));
}

TEST_CASE("implicit shape: a point is projected onto the surface, but not from afar", "[unit]") {
  const ImplicitShape tube = tube_shape(kKnots);
  for (int i = 0; i < 500; ++i) {
    const Vector3d point = random_point(grown(tube.bounds()), i);
    constexpr double kReach = 1e-3;
    const Vector3d projected = tube.project(point, kReach);
    if (std::abs(tube(point)) < 0.5 * kReach) {
      CHECK(std::abs(tube(projected)) < 1e-3 * kReach);
    }
    CHECK((projected - point).norm() <= kReach);
  }
}

TEST_CASE("implicit shape: what makes no sense is refused by name", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ImplicitShape ball = sphere_shape({0, 0, 0}, 1);
  CHECK_THROWS_WITH(sphere_shape({0, 0, 0}, 0), ContainsSubstring("radius of a sphere is 0 m"));
  CHECK_THROWS_AS(sphere_shape({0, nan, 0}, 1), InvalidArgument);
  CHECK_THROWS_AS(ellipsoid_shape({0, 0, 0}, {1, -1, 1}), InvalidArgument);
  CHECK_THROWS_AS(rounded_box_shape({0, 0, 0}, {1, 1, 1}, 1.5), InvalidArgument);
  CHECK_THROWS_AS(half_space_shape({0, 0, 0}, {0, 0, 0}), InvalidArgument);
  CHECK_THROWS_AS(tube_shape(std::span(kKnots).first(1)), InvalidArgument);
  CHECK_THROWS_AS(tube_shape(kKnots, 0), InvalidArgument);
  CHECK_THROWS_AS(shell_shape(ball, 0), InvalidArgument);
  CHECK_THROWS_AS(offset_shape(ball, nan), InvalidArgument);
  CHECK_THROWS_AS(smooth_union(ball, ball, -1), InvalidArgument);
  CHECK_THROWS_WITH(smooth_intersection(ball, sphere_shape({9, 0, 0}, 1), 0),
                    ContainsSubstring("their boxes are apart"));
  CHECK_THROWS_AS(ImplicitShape(nullptr, ball.bounds()), InvalidArgument);
  CHECK_THROWS_AS(ImplicitShape([](const Vector3d&) { return 0.0; }, Eigen::AlignedBox3d()),
                  InvalidArgument);
}

}  // namespace pbdsurg
