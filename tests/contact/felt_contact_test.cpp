// SPDX-License-Identifier: Apache-2.0
// What a hand feels through a servo of tissue that a solver simulates.
#include <algorithm>
#include <cmath>
#include <string>

#include "tests/haptics/simulated_tissue.h"
#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Case;
using testing::Pressed;
using testing::PressedScene;
using testing::Rig;
using testing::steps_of;

constexpr double kLargestStep = 0.1;      // N/ms, of computed force
constexpr double kLargestSlew = 0.2001;   // N/ms, of commanded force
constexpr double kLargestSurplus = 1e-4;  // J

void check_steps(const Rig& rig) {
  CHECK(steps_of(rig.computed).p999 < kLargestStep);
  CHECK(steps_of(rig.commanded).largest < kLargestSlew);
}

}  // namespace

// Would catch packets whose planes are not where tissue is, or are too stiff, so that a servo makes
// less of the force, or too soft, so that a hand trembles: of faces, edges and vertices alike, of
// four points that share a force, and of a sheet, which is soft however stiff its tissue.
TEST_CASE("felt contact: a hand feels what the simulation does, and rests", "[validation]") {
  const PressedScene scene = GENERATE(from_range(testing::pressed_scenes()));
  for (const Case& one : testing::simulated_grid()) {
    if (one.plant.mass < 0.05 || (!one.plant.has_hand && one.plant.damping < 0.5)) {
      continue;  // bench/haptics has all
    }
    CAPTURE(std::string(scene.name), one.plant.damping, one.plant.has_hand, one.delay);
    const Pressed pressed = testing::press(scene, one);
    CAPTURE(pressed.depth, pressed.felt, pressed.simulated);
    CHECK(testing::settles(pressed.rig));
    CHECK(pressed.rig.surplus < kLargestSurplus);
    check_steps(pressed.rig);
    CHECK(std::abs(pressed.felt / pressed.simulated - 1) < 0.02);
    if (scene.scene == testing::spring_block) {
      CHECK(std::abs(pressed.felt / testing::plate_force(pressed.depth) - 1) < 0.02);
    }
  }
}

// Would catch jaws that are felt to hold more than they do, a jump where they lose the tissue, and
// force that stays behind.
TEST_CASE("felt contact: jaws slip at their limit, and what tears is gone", "[validation]") {
  constexpr float kLimit = 0.4F;  // N
  Grip grip = testing::slab_grip();
  SECTION("slips") {
    grip.friction = 0.5F;
    grip.clamp_force = kLimit / (2 * grip.friction);
    const Rig rig = testing::pulled_slab(grip);
    check_steps(rig);
    float most = 0;
    for (const Eigen::Vector3f& force : rig.commanded) {
      most = std::max(most, force.norm());
    }
    CHECK(most > 0.95F * kLimit);
    CHECK(most < 1.05F * kLimit);
    CHECK(rig.commanded.back().norm() < 0.01F);
  }
  SECTION("tears") {
    grip.tear_strength = 30;  // N/m
    const Rig rig = testing::pulled_slab(grip);
    check_steps(rig);
    CHECK(rig.commanded.back().norm() < 0.01F);
  }
}

}  // namespace pbdsurg
