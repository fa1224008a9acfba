// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/force_gate.h"

#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/catch.h"

namespace rig {
namespace {

using pbdsurg::testing::Approx;

constexpr float kPeriod = 1e-3f;

ForceGate open_gate(const Eigen::Vector3f& force) {
  ForceGate gate({}, kPeriod);
  for (int tick = 0; tick < 1200; ++tick) {
    gate.pass(force);
  }
  return gate;
}

}  // namespace

// Catches a gate that begins open, or opens at once.
TEST_CASE("force gate: opens after a quiet time, by a ramp", "[unit]") {
  ForceGate gate({}, kPeriod);
  const Eigen::Vector3f force(0, 1, 0);
  for (int tick = 0; tick < 100; ++tick) {
    CHECK(gate.pass(force).norm() == 0);
  }
  for (int tick = 0; tick < 500; ++tick) {
    gate.pass(force);
  }
  CHECK(gate.force().y() == Approx(0.5).margin(0.01));
  for (int tick = 0; tick < 600; ++tick) {
    gate.pass(force);
  }
  CHECK(gate.force() == force);
}

// Catches forces that jump, are too great or no numbers, whatever comes in.
TEST_CASE("force gate: nothing that comes in leaves beyond clamp and slew", "[property]") {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> inputs = {
      {0, 0, 2.6f},      {100, 0, 0},           {-100, 100, 0}, {nan, 0, 0},  {0, infinity, 0},
      {0, 0, -infinity}, {3e38f, 3e38f, 3e38f}, {1e-38f, 0, 0}, {-2.6f, 0, 0}};
  ForceGate gate = open_gate({1, 1, 1});
  Eigen::Vector3f before = gate.force();
  for (int tick = 0; tick < 5000; ++tick) {
    const Eigen::Vector3f force = gate.pass(inputs[static_cast<std::size_t>(tick / 7 % 9)]);
    REQUIRE(force.allFinite());
    REQUIRE(force.norm() <= 2.6f * 1.0001f);
    REQUIRE((force - before).norm() <= 0.2f * 1.0001f);
    before = force;
  }
}

// Catches a gate that does not open at all, which the test above would not notice.
TEST_CASE("force gate: what obeys its limits passes unchanged", "[unit]") {
  ForceGate gate = open_gate({0, 0, 1});
  for (int tick = 0; tick < 100; ++tick) {
    const Eigen::Vector3f force(0, 0.5f * std::sin(0.05f * static_cast<float>(tick)), 1);
    REQUIRE(gate.pass(force) == force);
  }
  CHECK(gate.gain() == 1);
}

// Catches a zero that is not reached in time, or is jumped to.
TEST_CASE("force gate: a closed gate fades to zero in 13 ms", "[unit]") {
  ForceGate gate = open_gate({0, 0, 2.6f});
  REQUIRE(gate.force().norm() == Approx(2.6));
  gate.fade();
  CHECK(gate.force().norm() == Approx(2.4));
  for (int tick = 0; tick < 13; ++tick) {
    gate.fade();
  }
  CHECK(gate.force().norm() == 0);
}

}  // namespace rig
