// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/random.h"

#include "lib/solver/methods/group_balance.h"
#include "tests/solver/balanced_group.h"
#include "tests/solver/cube_of_masses.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kCubeMass;
using testing::kHalfCubeEdge;
using Vector = Vec3<double>;

// Eight equal masses at the corners of a cube around the origin, all gone too far by the same.
MomentumSums cube(const Vector& too_far) {
  MomentumSums sums;
  for (const double x : {-kHalfCubeEdge, kHalfCubeEdge}) {
    for (const double y : {-kHalfCubeEdge, kHalfCubeEdge}) {
      for (const double z : {-kHalfCubeEdge, kHalfCubeEdge}) {
        sums.add(kCubeMass / 8, {x, y, z}, too_far);
      }
    }
  }
  return sums;
}

// Below the centre, of a plane that looks up.
RigidContact contact_below(double gap, const Vector& slip, const ContactForce<double>& before) {
  return {{0, 0, -kHalfCubeEdge}, {0, 0, 1}, {gap, slip}, before, 0.3, 100 * kCubeMass};
}

Screw twist_of(const MomentumSums& sums, const std::vector<RigidContact>& contacts) {
  std::vector<GroupContact> of_group;
  for (const RigidContact& contact : contacts) {
    of_group.push_back({contact, 0});
  }
  return testing::balanced({RigidBody(sums)}, of_group).twist_of(0);
}

double uniform(std::uint64_t element, std::uint64_t number, double low, double high) {
  return low + (high - low) * random_unit(1, element, number);
}

}  // namespace

// Would catch a sign, and a contact that pulls.
TEST_CASE("rigid balance: what no contact pushes goes as it flies", "[unit]") {
  const Vector too_far{1e-3, -2e-3, 3e-3};
  for (const auto& contacts :
       {std::vector<RigidContact>{}, std::vector{contact_below(0.1, {0, 0, 0}, {0, {0, 0, 0}})}}) {
    const Screw twist = twist_of(cube(too_far), contacts);
    CHECK(twist.linear.x == Approx(-1e-3));
    CHECK(twist.linear.y == Approx(2e-3));
    CHECK(twist.linear.z == Approx(-3e-3));
    CHECK(std::sqrt(dot(twist.angular, twist.angular)) < 1e-12);
  }
}

// Would catch a spring that is left out of the balance, or counted twice.
TEST_CASE("rigid balance: one contact below the centre has a closed form", "[unit]") {
  const double up = 2e-4, gap = -1e-4, push = 1e-5;
  const RigidContact contact = contact_below(gap, {0, 0, 0}, {push, {0, 0, 0}});

  const Screw twist = twist_of(cube({0, 0, up}), {contact});

  const double k = contact.stiffness;
  CHECK(twist.linear.z == Approx((push - k * gap - kCubeMass * up) / (k + kCubeMass)));
  CHECK(std::fabs(twist.linear.x) < 1e-12);
}

// Would catch friction beyond its cone, and a matrix that holds what slides.
TEST_CASE("rigid balance: friction bears what its cone allows, no more", "[unit]") {
  const double push = 1e-4;
  // four contacts at the corners below, so that little turns
  const auto twist_for = [&](double along) {
    std::vector<RigidContact> contacts;
    for (const double x : {-kHalfCubeEdge, kHalfCubeEdge}) {
      for (const double y : {-kHalfCubeEdge, kHalfCubeEdge}) {
        contacts.push_back(contact_below(0, {0, 0, 0}, {push / 4, {0, 0, 0}}));
        contacts.back().arm = {x, y, 0};  // through the centre
      }
    }
    return twist_of(cube({along, 0, push / kCubeMass}), contacts);
  };
  const double limit = 0.3 * push / kCubeMass;  // m, that the cone bears
  const double k = 4 * 100 * kCubeMass;

  CHECK(twist_for(-0.5 * limit).linear.x == Approx(0.5 * limit * kCubeMass / (k + kCubeMass)));
  CHECK(twist_for(-5 * limit).linear.x == Approx(4 * limit));
  CHECK(twist_for(5 * limit).linear.x == Approx(-4 * limit));
}

// Would catch a method that swings between sticking and sliding, or pushing and not: what it finds
// is summed up here, apart from it.
TEST_CASE("rigid balance: random contacts are balanced", "[unit]") {
  for (std::uint64_t trial = 0; trial < 200; ++trial) {
    std::uint64_t number = 0;
    const auto random = [&](double low, double high) {
      return uniform(trial, number++, low, high);
    };
    const Vector too_far{random(-1e-3, 1e-3), random(-1e-3, 1e-3), random(-2e-3, 0)};
    const MomentumSums sums = cube(too_far);
    std::vector<RigidContact> contacts;
    for (int i = 0; i < 12; ++i) {
      contacts.push_back(contact_below(random(-1e-4, 1e-4), {random(-1e-4, 1e-4), 0, 0},
                                       {random(0, 1e-6), {0, 0, 0}}));
      contacts.back().arm = {random(-kHalfCubeEdge, kHalfCubeEdge),
                             random(-kHalfCubeEdge, kHalfCubeEdge), -kHalfCubeEdge};
      contacts.back().friction = random(0, 1);
      contacts.back().stiffness = random(1, 100) * kCubeMass;
    }
    CAPTURE(trial);

    const Screw twist = twist_of(sums, contacts);

    const double inertia = kCubeMass * 2 * kHalfCubeEdge * kHalfCubeEdge;
    Vector force = kCubeMass * (too_far + twist.linear), moment = inertia * twist.angular;
    double most = kCubeMass * std::sqrt(dot(too_far, too_far));
    for (const RigidContact& c : contacts) {
      const Vector move = twist.linear + cross(twist.angular, c.arm);
      const double pushed = std::max(0.0, c.force.push - c.stiffness * (c.reading.gap + move.z));
      Vector drag = c.force.drag - c.stiffness * (c.reading.slip + Vector{move.x, move.y, 0});
      const double size = std::hypot(drag.x, drag.y);
      drag = (size > c.friction * pushed ? c.friction * pushed / size : 1) * drag;
      const Vector sum = drag + Vector{0, 0, pushed};
      force = force - sum;
      moment = moment - cross(c.arm, sum);
    }
    CHECK(std::sqrt(dot(force, force)) < 1e-3 * most);
    CHECK(std::sqrt(dot(moment, moment)) < 1e-3 * most * kHalfCubeEdge);
  }
}

// Would catch a division by the inertia of what has none.
TEST_CASE("rigid balance: a single vertex does not turn", "[unit]") {
  MomentumSums sums;
  sums.add(kCubeMass, {0.1, 0.2, 0.3}, {0, 0, 1e-3});
  RigidContact contact = contact_below(-1e-4, {0, 0, 0}, {0, {0, 0, 0}});
  contact.arm = {0, 0, 0};

  const Screw twist = twist_of(sums, {contact});

  CHECK(twist.linear.z ==
        Approx((contact.stiffness * 1e-4 - kCubeMass * 1e-3) / (contact.stiffness + kCubeMass)));
  CHECK(dot(twist.angular, twist.angular) == 0);
}

}  // namespace pbdsurg
