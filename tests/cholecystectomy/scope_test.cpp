// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/scope.h"

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

constexpr float kDegree = static_cast<float>(std::numbers::pi / 180);

Eigen::Vector3f view_of(const Camera& camera) {
  return (camera.target - camera.eye).normalized();
}

// Where a point comes to lie in the picture: right and up, in tangents.
Eigen::Vector2f project(const Camera& camera, const Eigen::Vector3f& point) {
  const Eigen::Vector3f ahead = view_of(camera);
  const Eigen::Vector3f right = ahead.cross(camera.up).normalized();
  const Eigen::Vector3f up = right.cross(ahead);
  const Eigen::Vector3f way = point - camera.eye;
  return {way.dot(right) / way.dot(ahead), way.dot(up) / way.dot(ahead)};
}

// How far the world's up leans in the picture, rad.
float lean_of(const Camera& camera, const Eigen::Vector3f& up) {
  const Eigen::Vector3f right = view_of(camera).cross(camera.up).normalized();
  return std::atan2(up.dot(right), up.dot(camera.up));
}

}  // namespace

// Would catch optics that bend where they should not, for any post.
TEST_CASE("scope: a straight one looks along its shaft, from its tip", "[unit]") {
  ScopeOptions options;
  options.angle = 0;
  Scope scope({0.1F, -0.2F, 0.05F}, {1, 2, -1}, options);
  scope.advance(0.05F);
  for (int i = 0; i < 5; ++i) {
    CHECK((scope.view() - Eigen::Vector3f(1, 2, -1).normalized()).norm() < 1e-5F);
    CHECK((scope.camera().eye - scope.tip()).norm() < 1e-6F);
    scope.turn_post(1.1F);
  }
}

// Would catch a post that turns the picture alone, and an angle that depends on it.
TEST_CASE("scope: view and shaft make the angle of the optics, whatever the post", "[unit]") {
  ScopeOptions options;
  options.angle = GENERATE(0.0F, 30.0F, 45.0F) * kDegree;
  Scope scope({0, 0, 0}, {0.3F, 1, -0.4F}, options);
  Eigen::Vector3f before = scope.view();
  for (int i = 0; i < 12; ++i) {
    scope.turn_post(30 * kDegree);
    CHECK(std::acos(std::min(1.0F, scope.view().dot(scope.shaft()))) ==
          Approx(options.angle).margin(1e-3));
    CHECK((view_of(scope.camera()) - scope.view()).norm() < 1e-5F);
    // about the shaft: the chord of 30 degrees on a circle of radius sin(angle)
    CHECK((scope.view() - before).norm() ==
          Approx(2 * std::sin(options.angle) * std::sin(15 * kDegree)).margin(1e-4));
    before = scope.view();
  }
}

// Would catch the sign of the post, and of the optics.
TEST_CASE("scope: with the post above it looks below its shaft, turned half round above",
          "[unit]") {
  Scope scope({0, 0, 0}, {1, 0, 0});
  CHECK(scope.view().z() == Approx(-0.5F));
  scope.turn_post(90 * kDegree);  // counter-clockwise for who looks along the shaft from outside
  CHECK(scope.view().z() == Approx(0).margin(1e-5));
  CHECK(scope.view().y() == Approx(-0.5F));
  scope.turn_post(90 * kDegree);
  CHECK(scope.view().z() == Approx(0.5F));
}

// Would catch a horizon that leans as the view sweeps, and a level head that does not move.
TEST_CASE("scope: a level one keeps its horizon while post and shaft turn", "[unit]") {
  ScopeOptions options;
  options.up = GENERATE(Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, -3, 0.5F));
  Scope scope({0, 0, 0}, {1, 0.4F, 0.3F}, options);
  for (int i = 0; i < 12; ++i) {
    scope.turn_post(30 * kDegree);
    scope.orbit(0.05F, i % 2 == 0 ? 0.1F : -0.1F);
    CHECK(lean_of(scope.camera(), options.up) == Approx(0).margin(1e-4));
  }
  scope.set_level(false);
  const float head = scope.head();
  scope.turn_post(60 * kDegree);
  CHECK(scope.head() == head);
  CHECK(std::abs(lean_of(scope.camera(), options.up)) > 0.05F);
}

// Would catch a head that turns the view, or the picture the wrong way.
TEST_CASE("scope: turning the head turns the picture about its middle", "[unit]") {
  Scope scope = Scope::looking_at({0, 0, 0}, {0.1F, 0.1F, -0.05F});
  const Eigen::Vector3f view = scope.view();
  scope.turn_head(0.4F);
  CHECK(!scope.is_level());
  CHECK((view_of(scope.camera()) - view).norm() < 1e-5F);
  // the head turns counter-clockwise, so what is up leans clockwise, to the right
  CHECK(lean_of(scope.camera(), {0, 0, 1}) == Approx(0.4F).margin(1e-4));
  scope.set_level(true);
  CHECK(lean_of(scope.camera(), {0, 0, 1}) == Approx(0).margin(1e-4));
}

// Would catch a shaft that points at the target, so that the oblique view misses it.
TEST_CASE("scope: looking_at() puts its target into the middle of a level picture", "[unit]") {
  ScopeOptions options;
  options.angle = GENERATE(0.0F, 30.0F, 45.0F) * kDegree;
  const Eigen::Vector3f target(0.02F, -0.01F, 0.005F);
  const Eigen::Vector3f pivot =
      target + GENERATE(Eigen::Vector3f(0.1F, 0.05F, 0.12F), Eigen::Vector3f(-0.2F, 0, 0),
                        Eigen::Vector3f(0, 0, 0.15F), Eigen::Vector3f(0, 0, -0.15F),
                        Eigen::Vector3f(0.01F, 0.02F, -0.2F), Eigen::Vector3f(0.03F, 0, 0),
                        Eigen::Vector3f(0.4F, -0.3F, 0.1F), Eigen::Vector3f(0.001F, 0, -0.3F));
  const Scope scope = Scope::looking_at(pivot, target, options);
  const Camera camera = scope.camera();
  CHECK(project(camera, target).norm() < 1e-4F);
  CHECK((camera.target - target).norm() < 1e-4F * (target - pivot).norm());
  CHECK((camera.eye - pivot).norm() == Approx(scope.insertion()).epsilon(1e-4));
  CHECK(scope.insertion() >= options.least_insertion);
  CHECK(scope.insertion() <= options.most_insertion);
  if (std::abs(scope.view().z()) < 0.999F) {
    CHECK(lean_of(camera, {0, 0, 1}) == Approx(0).margin(1e-4));
  }
}

// Would catch a shaft that is turned as if the post were above.
TEST_CASE("scope: look_at() puts its target into the middle, whatever the post", "[unit]") {
  ScopeOptions options;
  options.angle = GENERATE(0.0F, 30.0F, 45.0F) * kDegree;
  options.up = GENERATE(Eigen::Vector3f(0, 0, 1), Eigen::Vector3f(0, -3, 0.5F));
  options.widest_tilt = 3;
  const Eigen::Vector3f pivot(0.1F, -0.2F, 0.05F);
  for (int i = 0; i < 12; ++i) {
    Scope scope(pivot, {1, 2, -1}, options);
    scope.turn_post(30 * kDegree * static_cast<float>(i));
    const float post = scope.post();
    const float side = i % 2 == 0 ? 1.0F : -1.0F;
    const Eigen::Vector3f target = pivot + Eigen::Vector3f(side * 0.12F, 0.09F, side * 0.04F);
    scope.look_at(target, 0.07F);
    const Camera camera = scope.camera();
    CAPTURE(i);
    CHECK(project(camera, target).norm() < 1e-4F);
    CHECK((camera.eye - target).norm() == Approx(0.07F).epsilon(1e-3));
    CHECK(scope.focus() == Approx(0.07F).epsilon(1e-3));
    CHECK(lean_of(camera, options.up) == Approx(0).margin(1e-4));
    CHECK(scope.post() == post);
    scope.look_at(target, 5);  // as far as the port allows
    CHECK(scope.insertion() == options.least_insertion);
    CHECK(project(scope.camera(), target).norm() < 1e-4F);
  }
}

// Would catch a limit that one of the motions passes by.
TEST_CASE("scope: the shaft stays in the port's cone and range", "[unit]") {
  ScopeOptions options;
  options.widest_tilt = 0.5F;
  const Eigen::Vector3f axis = Eigen::Vector3f(0.2F, 1, -0.8F).normalized();
  Scope scope({0, 0, 0}, axis, options);
  float widest = 0;
  for (int i = 0; i < 200; ++i) {
    scope.orbit(0.3F * std::sin(0.7F * static_cast<float>(i)),
                0.4F * std::cos(1.1F * static_cast<float>(i)));
    const float tilt = std::acos(std::min(1.0F, scope.shaft().dot(axis)));
    widest = std::max(widest, tilt);
    REQUIRE(tilt < options.widest_tilt + 1e-3F);
  }
  CHECK(widest > 0.49F);
  for (const Eigen::Vector3f& target :
       {Eigen::Vector3f(0.1F, 0.1F, 0.1F), Eigen::Vector3f(-0.1F, -0.2F, 0.1F),
        Eigen::Vector3f(0, 0, 0.2F), Eigen::Vector3f(0, 0, -0.001F), Eigen::Vector3f(0, 0, 0)}) {
    scope.look_at(target, 0.05F);
    CAPTURE(target.transpose());
    CHECK(std::acos(std::min(1.0F, scope.shaft().dot(axis))) < options.widest_tilt + 1e-3F);
    CHECK(scope.camera().target.allFinite());
    CHECK(scope.focus() > 0);
  }
  scope.advance(10);
  CHECK(scope.insertion() == options.most_insertion);
  CHECK(scope.focus() > 0);
  scope.advance(-10);
  CHECK(scope.insertion() == options.least_insertion);
}

// Would catch a state that one bad event of a device spoils.
TEST_CASE("scope: motions that are not finite are ignored", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  Scope scope({0, 0, 0}, {1, 0, 0});
  const Camera before = scope.camera();
  scope.orbit(nan, nan);
  scope.advance(std::numeric_limits<float>::infinity());
  scope.turn_post(nan);
  scope.set_focus(nan);
  scope.look_at({nan, 0, 0}, 0.1F);
  scope.look_at({0.1F, 0, 0}, nan);
  const Camera after = scope.camera();
  CHECK(after.eye == before.eye);
  CHECK(after.target == before.target);
  CHECK(after.up == before.up);
}

// The round picture has a radius of 0.6 heights. Would catch 70 degrees that are taken upright.
TEST_CASE("scope: the field of view is that across the round picture", "[unit]") {
  const Camera camera = Scope({0, 0, 0}, {1, 0, 0}).camera();
  CHECK(0.6F * 2 * std::tan(camera.vertical_field_of_view / 2) == Approx(std::tan(35 * kDegree)));
}

// Would catch a lamp that stays where it is as the scope turns under its camera.
TEST_CASE("scope: the lamp is on the side of the post", "[unit]") {
  Scope scope({0, 0, 0}, {1, 0, 0});
  CHECK(scope.camera().light_offset.y() == Approx(scope.options().lamp_offset));
  scope.turn_post(180 * kDegree);
  CHECK(scope.camera().light_offset.y() == Approx(-scope.options().lamp_offset));
  CHECK(scope.camera().light_offset.x() == Approx(0).margin(1e-6));
}

TEST_CASE("scope: what has no direction and options out of range are refused", "[unit]") {
  const Eigen::Vector3f pivot(0.1F, 0, 0);
  CHECK_THROWS_AS(Scope::looking_at(pivot, pivot), pbdsurg::InvalidArgument);
  CHECK_THROWS_WITH(Scope::looking_at(pivot, {0.11F, 0, 0}), ContainsSubstring("least insertion"));
  CHECK_THROWS_AS(Scope::looking_at(pivot, {0, std::numeric_limits<float>::quiet_NaN(), 0}),
                  pbdsurg::InvalidArgument);
  CHECK_THROWS_WITH(Scope(pivot, {0, 0, 0}), ContainsSubstring("axis"));
  ScopeOptions options;
  options.angle = 2;
  CHECK_THROWS_WITH(Scope(pivot, {1, 0, 0}, options), ContainsSubstring("angle"));
  options = {};
  options.up = {0, 0, 0};
  CHECK_THROWS_WITH(Scope(pivot, {1, 0, 0}, options), ContainsSubstring("up"));
  options = {};
  options.most_insertion = 0.01F;
  CHECK_THROWS_WITH(Scope(pivot, {1, 0, 0}, options), ContainsSubstring("most insertion"));
}

}  // namespace cholecystectomy
