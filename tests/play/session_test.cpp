// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/session.h"

#include <algorithm>

#include "tests/play/session_fixture.h"
#include "tests/support/catch.h"

namespace cholecystectomy {

using pbdsurg::Activation;
using pbdsurg::Triangle;

namespace {

// Brings the hook to the side of Calot's fat that faces the scope.
void go_to_fat(PlayedSession& play) {
  play.go(1, play.farthest(Organ::calot_fat, {0, -1, -1}), 60);
}

void apply(const SurfaceChange& change, Surface& surface) {
  surface.positions = change.positions;
  for (const SurfaceChange::Triangles& run : change.triangles) {
    surface.triangles.resize(std::max(surface.triangles.size(), run.first + run.values.size()));
    surface.is_inner.resize(surface.triangles.size());
    std::ranges::copy(run.values, surface.triangles.begin() + run.first);
    std::ranges::copy(run.is_inner, surface.is_inner.begin() + run.first);
  }
  for (const SurfaceChange::Burns& run : change.burns) {
    std::ranges::copy(run.values, surface.burn.begin() + run.first);
  }
}

}  // namespace

// Would catch jaws that hold nothing, hold for ever, or forces that do not come back.
TEST_CASE("session: a hand grasps, pulls and lets go", "[session]") {
  PlayedSession play;
  play.hands[0].set_jaw(0);
  play.step(1);
  CHECK(play.count(Event::missed) == 1);
  CHECK_FALSE(play.whole().grasper.is_holding);
  CHECK(play.whole().grasper.distance > 0.01F);
  play.hands[0].set_jaw(1);
  play.go(0, play.farthest(Organ::gallbladder, {-1, 0, -0.7F}), 40);
  play.hands[0].set_jaw(0.5F);  // between the two marks nothing changes
  play.step(1);
  CHECK_FALSE(play.whole().grasper.is_closed);
  play.hands[0].set_jaw(0);
  play.step(20);
  REQUIRE(play.count(Event::grasped) == 1);
  CHECK(play.whole().grasper.is_holding);
  const float before = play.whole().grasper.force.norm();
  play.go(0, play.hands[0].tip() + Eigen::Vector3f(-0.008F, -0.003F, -0.008F), 20);
  play.step(20);
  CHECK(play.whole().grasper.force.norm() > before + 0.5F);
  play.hands[0].set_jaw(0.5F);
  play.step(1);
  CHECK(play.whole().grasper.is_holding);
  play.hands[0].set_jaw(1);
  play.step(1);
  CHECK_FALSE(play.whole().grasper.is_holding);
}

// Would catch current with both pedals, without a pedal, or after one is up.
TEST_CASE("session: one pedal burns, both do not", "[session]") {
  PlayedSession play;
  go_to_fat(play);
  CHECK(play.whole().generator.energy == 0);
  play.hands[1].set_pedals({true, true});
  play.step(10);
  SceneState state = play.whole();
  CHECK(state.generator.is_refused);
  CHECK(state.generator.activation == Activation::none);
  CHECK(state.generator.energy == 0);
  play.hands[1].set_pedals({.coagulation = true});
  play.step(20);
  state = play.whole();
  CHECK(state.generator.activation == Activation::coagulation);
  CHECK(state.generator.is_touching);
  CHECK(state.generator.energy > 0.5);
  CHECK(state.generator.hottest > 60);
  play.hands[1].set_pedals({});
  play.step(1);
  const double energy = play.whole().generator.energy;
  play.step(10);
  CHECK(play.whole().generator.energy == energy);
  CHECK(play.whole().generator.activation == Activation::none);
}

// Would catch a window that shows another scene than the simulation's after states were lost.
TEST_CASE("session: changes since what was seen keep surfaces whole", "[session]") {
  PlayedSession play;
  go_to_fat(play);
  SceneState state;
  Seen seen;
  play.session.fill(state, seen);
  REQUIRE(state.generation == 1);
  std::vector<Surface> copy = state.whole;
  const auto take = [&] {
    seen = {0, state.generation, state.triangle_versions, state.burn_versions};
  };
  take();
  play.hands[1].set_pedals({.cut = true});
  bool has_burnt = false;
  for (int round = 0; round < 60; ++round) {
    play.step(5);
    play.session.fill(state, seen);
    REQUIRE(state.whole.empty());
    if (round % 3 == 1) {
      continue;  // the window missed it
    }
    for (std::size_t i = 0; i < kOrganCount; ++i) {
      apply(state.changes[i], copy[i]);
      has_burnt |= !state.changes[i].burns.empty();
    }
    take();
  }
  CHECK(has_burnt);
  REQUIRE(state.removed_tets > 0);
  CHECK(play.count(Event::tissue_removed) > 0);
  const SceneState whole = play.whole();
  for (std::size_t i = 0; i < kOrganCount; ++i) {
    CAPTURE(copy[i].name);
    CHECK(copy[i].positions == whole.whole[i].positions);
    CHECK(copy[i].triangles == whole.whole[i].triangles);
    CHECK(copy[i].is_inner == whole.whole[i].is_inner);
    CHECK(copy[i].burn == whole.whole[i].burn);
  }
  const auto& fat = whole.whole[static_cast<std::size_t>(Organ::calot_fat)];
  CHECK(std::ranges::count(fat.is_inner, 1) > 0);
  CHECK(std::ranges::count(fat.is_inner, 0) > 0);
}

// Would catch an undo without an edit that throws, or one that is not heard.
TEST_CASE("session: the last edit is taken back, where there is one", "[session]") {
  PlayedSession play;
  play.orders.undos = 1;
  play.step(1);
  CHECK(play.count(Event::no_undo) == 1);
  go_to_fat(play);
  play.hands[1].set_pedals({.cut = true});
  for (int i = 0; i < 400 && play.count(Event::tissue_removed) == 0; ++i) {
    play.step(1);
  }
  REQUIRE(play.count(Event::tissue_removed) == 1);
  play.hands[1].set_pedals({});
  play.orders.undos = 2;
  play.step(1);
  CHECK(play.count(Event::undone) == 1);
}

// Would catch a play that depends on anything but hands and orders.
TEST_CASE("session: the same hands give the same bits", "[session]") {
  const auto run = [] {
    PlayedSession play;
    go_to_fat(play);
    play.hands[1].set_pedals({.cut = true});
    play.step(30);
    return play.whole();
  };
  const SceneState one = run(), other = run();
  for (std::size_t i = 0; i < kOrganCount; ++i) {
    CHECK(one.whole[i].positions == other.whole[i].positions);
    CHECK(one.whole[i].burn == other.whole[i].burn);
  }
  CHECK(one.generator.energy == other.generator.energy);
}

// Would catch a trainee who has to hold the grasper in the wrong hand.
TEST_CASE("session: left-handed, the left hand has the hook", "[session]") {
  PlayedSession play;
  play.orders.is_left_handed = true;
  play.step(60);
  const SceneState state = play.whole();
  CHECK((state.hook.pose.translation() - play.hands[0].tip()).norm() < 1e-5F);
  CHECK((state.grasper.pose.translation() - play.hands[1].tip()).norm() < 1e-5F);
}

}  // namespace cholecystectomy
