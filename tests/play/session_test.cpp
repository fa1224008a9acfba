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
  std::array<int, 2> count{};
  for (std::size_t t = 0; t < fat.triangles.size(); ++t) {
    count[fat.is_inner[t]] += fat.triangles[t][0] != fat.triangles[t][1] ? 1 : 0;
  }
  CHECK(count[0] > 100);
  CHECK(count[1] > 0);
}

// Would catch an undo without an edit that throws, or a window that keeps what an undo took away.
TEST_CASE("session: the last edit is taken back, where there is one", "[session]") {
  PlayedSession play;
  play.session.undo(play.events);
  CHECK(play.count(Event::no_undo) == 1);
  go_to_fat(play);
  play.step(1);
  play.hands[1].set_pedals({.cut = true});
  SceneState before;
  for (int i = 0; i < 400 && play.count(Event::tissue_removed) == 0; ++i) {
    before = play.whole();
    play.step(1);
  }
  REQUIRE(play.count(Event::tissue_removed) == 1);
  const auto triangles = [](const SceneState& state) {
    auto found = state.whole[static_cast<std::size_t>(Organ::calot_fat)].triangles;
    std::erase_if(found, [](const Triangle& t) { return t[0] == t[1]; });
    std::ranges::sort(found);
    return found;
  };
  CHECK(triangles(play.whole()) != triangles(before));
  SceneState state = play.whole();
  const Seen seen{0, state.generation, state.triangle_versions, state.burn_versions};
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == 1);
  play.session.fill(state, seen);
  REQUIRE_FALSE(state.whole.empty());  // though the window had seen all before
  CHECK(triangles(state) == triangles(before));
}

// Would catch a foot that was down before the scene began, or that nobody hears of any more.
TEST_CASE("session: pedals count once they were up, and while their hand is heard of",
          "[session]") {
  PlayedSession play;
  play.hands[1].set_pedals({.cut = true});
  play.step(2);
  CHECK(play.whole().generator.activation == Activation::none);
  play.hands[1].set_pedals({});
  play.step(1);
  play.hands[1].set_pedals({.cut = true});
  play.step(1);
  CHECK(play.whole().generator.activation == Activation::cut);
  play.clock.advance(Session::kSilence + 0.1);
  play.step(1);
  CHECK(play.whole().generator.activation == Activation::none);
  play.hands[1].refresh();
  play.step(1);
  CHECK(play.whole().generator.activation == Activation::cut);
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

}  // namespace cholecystectomy
