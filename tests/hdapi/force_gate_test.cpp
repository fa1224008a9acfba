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
constexpr float kMaxForce = 2.6f;

/// After so many periods with one force.
ForceGate gate_after(int ticks, const Eigen::Vector3f& force) {
  ForceGate gate(kMaxForce, kPeriod);
  for (int tick = 0; tick < ticks; ++tick) {
    gate.pass(force);
  }
  return gate;
}

}  // namespace

// Catches forces that jump, are too great or no numbers, whatever comes in.
TEST_CASE("force gate: nothing that comes in leaves beyond clamp and slew", "[property]") {
  const float infinity = std::numeric_limits<float>::infinity();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3f> inputs = {
      {0, 0, 2.6f},      {100, 0, 0},           {-100, 100, 0}, {nan, 0, 0},  {0, infinity, 0},
      {0, 0, -infinity}, {3e38f, 3e38f, 3e38f}, {1e-38f, 0, 0}, {-2.6f, 0, 0}};
  ForceGate gate = gate_after(100, {1, 1, 1});
  Eigen::Vector3f before = gate.force();
  for (int tick = 0; tick < 5000; ++tick) {
    const Eigen::Vector3f force = gate.pass(inputs[static_cast<std::size_t>(tick / 7 % 9)]);
    REQUIRE(force.allFinite());
    REQUIRE(force.norm() <= kMaxForce * 1.0001f);
    REQUIRE((force - before).norm() <= 0.2f * 1.0001f);
    before = force;
  }
}

// Catches a gate that lets nothing through, which the test above would not notice, and one with a
// ramp of its own.
TEST_CASE("force gate: what obeys its limits passes unchanged, from the first period on",
          "[unit]") {
  ForceGate gate(kMaxForce, kPeriod);
  for (int tick = 0; tick < 100; ++tick) {
    const Eigen::Vector3f force(0, 2 * std::sin(0.05f * static_cast<float>(tick)), 0);
    REQUIRE(gate.pass(force) == force);
  }
}

// Catches a zero that is not reached in time, or is jumped to.
TEST_CASE("force gate: force is nothing within 13 ms, where nothing or no number is asked for",
          "[unit]") {
  const float asked = GENERATE(0.0f, std::numeric_limits<float>::quiet_NaN());
  ForceGate gate = gate_after(20, {0, 0, kMaxForce});
  REQUIRE(gate.force().norm() == Approx(kMaxForce));
  CHECK(gate.pass({asked, 0, 0}).norm() == Approx(kMaxForce - 0.2));
  for (int tick = 0; tick < 13; ++tick) {
    gate.pass({asked, 0, 0});
  }
  CHECK(gate.force().norm() == 0);
}

}  // namespace rig
