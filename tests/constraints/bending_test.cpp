// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/constraints/bending.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "pbdsurg/constraints/vertex_block.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"
#include "tests/support/constraint_checks.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::Hinge;
using testing::kNotANumber;
using testing::kPi;
using testing::turn_of;

constexpr double kInfinite = std::numeric_limits<double>::infinity();

template <class Scalar>
double largest_move(const Hinge<Scalar>& a, const Hinge<Scalar>& b) {
  double square = 0;
  for (int i = 0; i < 4; ++i) {
    const Vec3<Scalar> d = a.x[i] - b.x[i];
    square = std::max<double>(square, dot(d, d));
  }
  return std::sqrt(square);
}

// To (-pi, pi].
double wrapped(double angle) {
  return angle - 2 * kPi * std::ceil(angle / (2 * kPi) - 0.5);
}

}  // namespace

TEST_CASE("bending constraint: gradient, scale, momentum, frame and compliance", "[property]") {
  testing::check_all<BendingConstraint>();
}

// Would catch a wrong sign, a range of half the circle only, and a rest angle that is taken off
// where it must be turned off.
TEST_CASE("bending constraint: its value is the turn from rest, the shorter way", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double angle = GENERATE(-3.1, -2.0, -0.5, -1e-7, 0.0, 1e-7, 0.1, 1.0, 2.5, 3.1);
  const double rest = GENERATE(-3.1, -1.2, 0.0, 0.4, 2.0, 3.1);
  const Hinge hinge(edge, angle);

  CHECK(hinge.value(turn_of(rest)) ==
        Approx(turn_of(wrapped(angle - rest))).epsilon(1e-9).margin(1e-12));
  // in single precision the angle of normals is as exact as the normals
  CHECK(Hinge<float>(edge, angle).value(turn_of(rest)) ==
        Approx(turn_of(wrapped(angle - rest))).margin(1e-5));
}

TEST_CASE("bending constraint: convex towards the normals is positive", "[unit]") {
  const Vec3<double> ridge[4] = {{0, 0, 0}, {0, 1, 0}, {-1, 0, -1}, {1, 0, -1}};
  CHECK(BendingConstraint::value(ridge, 0.0) == Approx(turn_of(kPi / 2)));
}

TEST_CASE("bending constraint: gradients are those of the value at any angle and rest",
          "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double angle = GENERATE(-3.0, -1.0, 0.0, 0.7, 3.0);
  const double rest = turn_of(GENERATE(-2.9, 0.0, 1.0));
  const Hinge hinge(edge, angle);
  const auto turn = BendingConstraint::turn(hinge.x, rest);
  const double step = 1e-5 * edge;
  for (int i = 0; i < 4; ++i) {
    for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
      Hinge low = hinge, high = hinge;
      low.x[i].*axis -= step;
      high.x[i].*axis += step;
      CHECK(edge * turn.gradient[i].*axis ==
            Approx(edge * (high.value(rest) - low.value(rest)) / (2 * step)).margin(1e-7));
    }
  }
}

TEST_CASE("bending constraint: a hinge at rest stays, whatever its angle", "[property]") {
  const double edge = GENERATE(1e-1, 1e-4);
  const double angle = GENERATE(-3.14, -1.5, 0.0, 0.2, 3.0, kPi);
  Hinge hinge(edge, angle);
  const HingeAtRest rest = hinge_at_rest(hinge.x, 1e-6);
  CHECK(std::abs(hinge.value(rest.turn)) < 1e-14);
  const Hinge before = hinge;
  hinge.project<ProjectionMode::fraction>(rest.turn, 1);
  hinge.project<ProjectionMode::compliance>(rest.turn, 0);
  CHECK(largest_move(hinge, before) < 1e-14 * edge);

  Hinge<float> single(edge, angle);
  const Hinge<float> single_before = single;
  single.project<ProjectionMode::fraction>(rest.turn, 1);
  CHECK(largest_move(single, single_before) < 1e-6 * edge);
}

// Would catch a gradient that vanishes or explodes where the triangles meet, and a hinge that a
// turn through itself leaves there.
TEST_CASE("bending constraint: a folded hinge opens", "[property]") {
  const double edge = GENERATE(1e-2, 1e-4);
  const double angle = GENERATE(-kPi, -3.141, 3.0, 3.14159, kPi);
  const double rest = turn_of(GENERATE(-0.5, 0.0, 0.5));
  const double fraction = GENERATE(0.1, 1.0);
  Hinge<float> hinge(edge, angle);
  for (int i = 0; i < 200; ++i) {
    const Hinge<float> before = hinge;
    hinge.project<ProjectionMode::fraction>(rest, fraction);
    REQUIRE(largest_move(hinge, before) < 5 * edge);
  }
  CHECK(std::abs(hinge.value(rest)) < 1e-4);
}

TEST_CASE("bending constraint: triangles without area are not pushed", "[unit]") {
  const auto check = [](auto zero) {
    using Scalar = decltype(zero);
    const auto shape = GENERATE(0, 1, 2, 3, 4);
    Hinge<Scalar> hinge(1e-3, 0.5);
    if (shape == 0) {
      hinge.x[2] = hinge.x[0];
    } else if (shape == 1) {
      hinge.x[3] = hinge.x[1];
    } else if (shape == 2) {  // on the line through the edge
      hinge.x[0] = {0, 0, 0};
      hinge.x[1] = {1, 0, 0};
      hinge.x[3] = {Scalar(0.25), 0, 0};
    } else if (shape == 3) {
      hinge.x[1] = hinge.x[0];
    } else {
      hinge.x[1] = hinge.x[2] = hinge.x[3] = hinge.x[0];
    }
    const Hinge<Scalar> before = hinge;
    CHECK(hinge.value(1) == 0);
    CHECK(hinge.template project<ProjectionMode::fraction>(1, 1) == 0);
    CHECK(hinge.template project<ProjectionMode::compliance>(1, 0) == 0);
    CHECK(hinge.is_same_as(before));

    VertexEnergy<Scalar> energy;
    energy.add_hinge(Scalar(1), Scalar(1), hinge.x, shape % 2 == 0);
    CHECK(energy.isotropic == 0);
    CHECK(energy.xx + energy.yy + energy.zz == 0);
    CHECK(dot(energy.force, energy.force) == 0);
  };
  SECTION("float") {
    check(0.0F);
  }
  SECTION("double") {
    check(0.0);
  }
}

// Would catch a push of a nearly straight triangle that grows as its height shrinks.
TEST_CASE("bending constraint: a sliver moves by no more than its size", "[property]") {
  const double height = GENERATE(1e-2, 1e-4, 1e-6);
  Hinge<float> hinge(1e-3, 0.5);
  const Vec3<float> foot = hinge.x[0] + 0.4F * (hinge.x[1] - hinge.x[0]);
  hinge.x[2] = foot + static_cast<float>(height) * (hinge.x[2] - foot);
  const Hinge<float> before = hinge;
  hinge.project<ProjectionMode::fraction>(turn_of(-2), 1);
  CHECK(largest_move(hinge, before) < 5e-3 * height);
}

TEST_CASE("bending constraint: what is fixed or not finite moves nothing", "[unit]") {
  Hinge<float> fixed(1e-3, 0.5);
  fixed.w[1] = fixed.w[2] = 0;
  const Hinge<float> before = fixed;
  fixed.project<ProjectionMode::compliance>(0, 0);
  CHECK(fixed.x[1].x == before.x[1].x);
  CHECK(fixed.x[2].y == before.x[2].y);
  CHECK(fixed.x[3].y != before.x[3].y);

  const double bad = GENERATE(as<double>(), kNotANumber, kInfinite);
  const int which = GENERATE(0, 1, 2, 3);
  Hinge<float> broken(1e-3, 0.5);
  broken.x[which].y = static_cast<float>(bad);
  const Hinge<float> broken_before = broken;
  CHECK(broken.project<ProjectionMode::fraction>(0, 1) == 0);
  CHECK(std::isnan(broken.value()));
  VertexEnergy<float> energy;
  energy.add_hinge(1.0F, 0.0F, broken.x, which % 2 == 0);
  CHECK(energy.isotropic == 0);
  CHECK(dot(energy.force, energy.force) == 0);
  for (int i = 0; i < 4; ++i) {
    if (i != which) {
      CHECK(dot(broken.x[i] - broken_before.x[i], broken.x[i] - broken_before.x[i]) == 0);
    }
  }
}

// Would catch a friction that resists a rigid motion, or another rate than that of the angle.
TEST_CASE("bending constraint: its turning is the rate of the angle", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double angle = GENERATE(-1.5, -0.4, 0.0, 0.3, 1.5);
  const Hinge hinge(edge, angle);
  const auto turning = BendingConstraint::turning(hinge.x);
  const auto turn = [&](const Vec3<double>(&way)[4]) {
    double sum = 0;
    for (int i = 0; i < 4; ++i) {
      sum += turning.shares[i] * dot(turning.across, way[i]);
    }
    return sum;
  };
  const double step = 1e-4;
  const Hinge after(edge, angle + step), before(edge, angle - step);
  Vec3<double> folds[4], shifts[4], spins[4];
  const Vec3<double> axis{0.3, -0.8, 0.5};
  for (int i = 0; i < 4; ++i) {
    folds[i] = after.x[i] - before.x[i];
    shifts[i] = edge * axis;
    spins[i] = cross(axis, hinge.x[i]);
  }
  CHECK(turn(folds) == Approx(2 * step).epsilon(1e-6));
  CHECK(std::abs(turn(shifts)) < 1e-12);
  CHECK(std::abs(turn(spins)) < 1e-12);
}

// Would catch a turning without bounds, or none, where a hinge is folded or has no area.
TEST_CASE("bending constraint: the turning of a folded hinge is bounded", "[unit]") {
  const double angle = GENERATE(2.0, 3.1, kPi);
  const auto turning = BendingConstraint::turning(Hinge(1e-3, angle).x);
  CHECK(dot(turning.across, turning.across) <= 2 + 1e-12);
  Hinge<float> flat(1e-3, 0.5);
  flat.x[2] = flat.x[0];
  const auto none = BendingConstraint::turning(flat.x);
  CHECK(dot(none.across, none.across) == 0);
  CHECK(none.shares[2] == 0);
  CHECK(none.shares[3] == 0);
}

// Rigid and at its rest angle, but turning: friction takes the share c / (1 + c) of the turn back.
TEST_CASE("bending constraint: damping resists the rate of the angle", "[unit]") {
  const double c = GENERATE(0.1, 1.0, 10.0);
  const double dt = 1e-3;
  Hinge start(1e-3, 0.8);
  Hinge hinge(1e-3, 0.8 + 1e-5);
  const double parameters[] = {hinge.value(), 0, c * dt};
  double multiplier[] = {0};
  Damped<double, 4> damping;
  std::copy(std::begin(start.x), std::end(start.x), damping.start);
  const double rest = hinge.value();
  const double turned = -start.value(rest);

  BendingConstraint::project<ProjectionMode::compliance>(
      hinge.x, hinge.w, parameters, Substep<double>{1 / dt, 1 / (dt * dt)}, multiplier, damping);

  CHECK(hinge.value(rest) == Approx(-c / (1 + c) * turned).epsilon(1e-3));
}

TEST_CASE("bending constraint: a rest shape that is not a hinge is refused", "[unit]") {
  const Hinge good(1e-3, 0.3);
  CHECK_NOTHROW(hinge_at_rest(good.x, 1e-9));
  const double rigidity = GENERATE(as<double>(), 0, -1, kNotANumber, kInfinite);
  CHECK_THROWS_AS(hinge_at_rest(good.x, rigidity), InvalidArgument);
  CHECK_THROWS_WITH(
      hinge_at_rest(good.x, -2),
      ContainsSubstring("flexural rigidity of a hinge is -2 N m") && ContainsSubstring("positive"));

  Hinge broken = good;
  broken.x[3].z = kNotANumber;
  CHECK_THROWS_WITH(hinge_at_rest(broken.x, 1), ContainsSubstring("vertex 3"));
  Hinge flat = good;
  flat.x[2] = flat.x[0] + 0.3 * (flat.x[1] - flat.x[0]);
  CHECK_THROWS_WITH(hinge_at_rest(flat.x, 1),
                    ContainsSubstring("height of vertex 2") && ContainsSubstring("1e-6"));
  Hinge closed = good;
  closed.x[1] = closed.x[0];
  CHECK_THROWS_WITH(hinge_at_rest(closed.x, 1), ContainsSubstring("edge of a hinge is 0 m"));
  // any size is as good as another
  for (const double scale : {1e-120, 1e120}) {
    Hinge scaled = good;
    for (Vec3<double>& x : scaled.x) {
      x = scale * x;
    }
    CHECK(hinge_at_rest(scaled.x, 1).turn == Approx(hinge_at_rest(good.x, 1).turn));
    CHECK(hinge_at_rest(scaled.x, 1).stiffness == Approx(hinge_at_rest(good.x, 1).stiffness));
  }
}

TEST_CASE("bending constraint: the flexural rigidity of a plate", "[unit]") {
  CHECK(flexural_rigidity(12e6, 1e-3, 0) == Approx(1e-3));
  CHECK(flexural_rigidity(12e6, 1e-3, 0.5) == Approx(1e-3 / 0.75));
  CHECK_THROWS_WITH(flexural_rigidity(0, 1, 0), ContainsSubstring("Young's modulus is 0 Pa"));
  CHECK_THROWS_WITH(flexural_rigidity(1, -1, 0), ContainsSubstring("thickness"));
  CHECK_THROWS_WITH(flexural_rigidity(1, 1, 0.51), ContainsSubstring("(-1, 0.5]"));
  CHECK_THROWS_AS(flexural_rigidity(1, 1, -1), InvalidArgument);
  CHECK_THROWS_AS(flexural_rigidity(1, 1, kNotANumber), InvalidArgument);
}

}  // namespace pbdsurg
