// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/group_balance.h"

#include <cmath>
#include <vector>

#include "tests/solver/balanced_group.h"
#include "tests/solver/cube_of_masses.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kCubeMass;
using testing::kHalfCubeEdge;
using Vector = Vec3<double>;

constexpr double kStiffness = 100 * kCubeMass;

// Eight masses at the corners of a cube around the origin, all gone too far by the same.
RigidBody cube(double mass, const Vector& too_far) {
  MomentumSums sums;
  for (const double x : {-kHalfCubeEdge, kHalfCubeEdge}) {
    for (const double y : {-kHalfCubeEdge, kHalfCubeEdge}) {
      for (const double z : {-kHalfCubeEdge, kHalfCubeEdge}) {
        sums.add(mass / 8, {x, y, z}, too_far);
      }
    }
  }
  return RigidBody(sums);
}

RigidContact below(const Vector& arm, double gap, const Vector& slip, double push,
                   double friction) {
  return {arm, {0, 0, 1}, {gap, slip}, {push, {0, 0, 0}}, friction, kStiffness};
}

// Four at the corners between the first cube, which is above, and the second.
std::vector<GroupContact> between(double gap, const Vector& slip, double push, double friction) {
  std::vector<GroupContact> contacts;
  for (const double x : {-kHalfCubeEdge, kHalfCubeEdge}) {
    for (const double y : {-kHalfCubeEdge, kHalfCubeEdge}) {
      contacts.push_back(
          {below({x, y, -kHalfCubeEdge}, gap, slip, push, friction), 0, 1, {x, y, kHalfCubeEdge}});
    }
  }
  return contacts;
}

double norm(const Vector& v) {
  return std::sqrt(dot(v, v));
}

}  // namespace

// Would catch a force that acts on one of two, or twice: the springs between two masses that near
// each other have a closed form.
TEST_CASE("group balance: a contact gives to one what it takes from the other", "[unit]") {
  const double down = 2e-4, gap = -4e-4, push = 1e-5, other_mass = 3 * kCubeMass;
  const std::vector bodies{cube(kCubeMass, {0, 0, -down}), cube(other_mass, {0, 0, 0})};
  const std::vector<GroupContact> contacts = between(gap, {0, 0, 0}, push, 0);

  const GroupSpace twists = testing::balanced(bodies, contacts);

  const Vector upper = twists.twist_of(0).linear, lower = twists.twist_of(1).linear;
  // m1 (q1 - down) = f, m2 q2 = -f, f = 4 (push - k (gap + q1 - q2))
  const double yield = 1 / kCubeMass + 1 / other_mass;
  const double force = 4 * (push - kStiffness * (gap + down)) / (1 + 4 * kStiffness * yield);
  CHECK(force > 0);
  CHECK(upper.z == Approx(down + force / kCubeMass));
  CHECK(lower.z == Approx(-force / other_mass));
  CHECK(norm(twists.twist_of(0).angular) + norm(twists.twist_of(1).angular) < 1e-9);
}

// Would catch a contact that pulls.
TEST_CASE("group balance: what no contact pushes goes as it flies", "[unit]") {
  const std::vector bodies{cube(kCubeMass, {1e-3, 0, -2e-3}), cube(kCubeMass, {0, 3e-3, 0})};
  const std::vector<GroupContact> contacts = between(0.1, {0, 0, 0}, 0, 0.3);

  const GroupSpace twists = testing::balanced(bodies, contacts);

  CHECK(twists.twist_of(0).linear.x == Approx(-1e-3));
  CHECK(twists.twist_of(0).linear.z == Approx(2e-3));
  CHECK(twists.twist_of(1).linear.y == Approx(-3e-3));
}

// Would catch friction beyond its cone, on one of two alone, or of another direction.
TEST_CASE("group balance: what slides on another is slowed by the cone, and takes it along",
          "[unit]") {
  const double push = 1e-5, friction = 0.3, slip = 1e-2, heavy = 10 * kCubeMass;
  const std::vector bodies{cube(kCubeMass, {0, 0, 0}), cube(heavy, {0, 0, 0})};
  std::vector<GroupContact> contacts = between(0, {slip, 0, 0}, push, friction);
  // held from below and above, so that the pushes stay
  for (GroupContact& contact : contacts) {
    contact.contact.stiffness *= 1e-6;
  }

  const GroupSpace twists = testing::balanced(bodies, contacts);

  const double drag = kCubeMass * twists.twist_of(0).linear.x,
               other_drag = heavy * twists.twist_of(1).linear.x;
  CHECK(drag + other_drag == Approx(0).margin(1e-9 * push));
  CHECK(std::abs(drag) < 4 * friction * push * 1.01);
  CHECK(std::abs(drag) > 0.9 * 4 * kStiffness * 1e-6 * slip);
}

// Would catch a matrix, or a balance, that is not that of a piece by itself.
TEST_CASE("group balance: pieces that touch only what stands move as each by itself", "[unit]") {
  const auto sums_of = [](const Vector& too_far) {
    MomentumSums sums;
    for (int i = 0; i < 8; ++i) {
      sums.add(kCubeMass / 8,
               {i & 1 ? kHalfCubeEdge : -kHalfCubeEdge, i & 2 ? kHalfCubeEdge : -kHalfCubeEdge,
                i & 4 ? kHalfCubeEdge : -kHalfCubeEdge},
               too_far + Vector{0, 0, i * 1e-5});
    }
    return sums;
  };
  const std::vector sums{sums_of({1e-4, 0, 2e-4}), sums_of({0, -3e-4, -2e-4})};
  const std::vector bodies{RigidBody(sums[0]), RigidBody(sums[1])};
  std::vector<GroupContact> contacts;
  std::vector<RigidContact> alone;
  for (const double x : {-kHalfCubeEdge, 0.5 * kHalfCubeEdge, kHalfCubeEdge}) {
    alone.push_back(
        below({x, x * x / kHalfCubeEdge, -kHalfCubeEdge}, -1e-4, {1e-5, 0, 0}, 1e-5, 0.3));
    contacts.push_back({alone.back(), 0});
    contacts.push_back({alone.back(), 1});
  }

  const GroupSpace twists = testing::balanced(bodies, contacts);

  for (Index i = 0; i < 2; ++i) {
    std::vector<GroupContact> own_contacts;
    for (const RigidContact& contact : alone) {
      own_contacts.push_back({contact, 0});
    }
    const Screw own = testing::balanced({bodies[i]}, own_contacts).twist_of(0);
    CHECK(norm(twists.twist_of(i).linear - own.linear) < 1e-5 * norm(own.linear));
    CHECK(norm(twists.twist_of(i).angular - own.angular) < 1e-5 * norm(own.angular));
  }
}

}  // namespace pbdsurg
