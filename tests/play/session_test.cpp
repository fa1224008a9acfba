// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/session.h"

#include <algorithm>
#include <array>
#include <span>
#include <vector>

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

// Cuts until so many tetrahedra have gone.
void burn(PlayedSession& play, int tets) {
  const std::int64_t before = play.whole().removed_tets;
  play.hands[1].set_pedals({.cut = true});
  for (int i = 0; i < 600 && play.whole().removed_tets < before + tets; ++i) {
    play.go(1, play.hands[1].tip() + Eigen::Vector3f(0, 2e-5F, 2e-5F), 1);
  }
  play.hands[1].set_pedals({});
  play.step(1);
  REQUIRE(play.whole().removed_tets >= before + tets);
}

// All of a moment: what there is, and what a window is shown of it.
struct Scene {
  explicit Scene(PlayedSession& play) : state(play.whole()) {
    const Simulation& simulation = play.session.simulation();
    const pbdsurg::Tissue& tissue = simulation.solver.tissue();
    const pbdsurg::HeatField& field = simulation.cautery.field();
    version = tissue.version();
    positions = simulation.solver.positions();
    for (pbdsurg::Index t = 0; t < static_cast<pbdsurg::Index>(tissue.tets().size()); ++t) {
      is_alive.push_back(tissue.is_tet_alive(t));
      rest_volumes.push_back(is_alive.back() ? simulation.solver.rest_volume(t) : 0);
    }
    for (pbdsurg::Index l = 0; l < static_cast<pbdsurg::Index>(tissue.links().size()); ++l) {
      is_alive.push_back(tissue.is_link_alive(l));
    }
    for (const std::span<const double> values :
         {field.temperatures(), field.peak_temperatures(), field.water(), field.survival(),
          field.collagen(), field.charred()}) {
      heat.insert(heat.end(), values.begin(), values.end());
    }
    energy = simulation.energy_in();
  }

  [[nodiscard]] bool is(const Scene& other) const {
    return version == other.version && positions == other.positions && is_alive == other.is_alive &&
           rest_volumes == other.rest_volumes && heat == other.heat && energy == other.energy &&
           state.time == other.state.time && state.removed_tets == other.state.removed_tets &&
           state.parted_strands == other.state.parted_strands;
  }

  // Slots of triangles may be others, and burns where no triangle is.
  [[nodiscard]] bool shows(const Scene& other) const {
    struct Shown {
      Triangle triangle;
      std::uint8_t is_inner;
      std::array<Eigen::Vector4f, 3> burns;
      bool operator==(const Shown&) const = default;
    };
    const auto shown = [](const Surface& surface) {
      std::vector<Shown> triangles;
      for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
        const Triangle& triangle = surface.triangles[t];
        const auto& [a, b, c] = triangle;
        if (a != b) {
          triangles.push_back(
              {triangle, surface.is_inner[t], {surface.burn[a], surface.burn[b], surface.burn[c]}});
        }
      }
      std::ranges::sort(triangles, {}, &Shown::triangle);
      return triangles;
    };
    for (std::size_t i = 0; i < kOrganCount; ++i) {
      const Surface& a = state.whole[i];
      const Surface& b = other.state.whole[i];
      if (a.positions != b.positions || shown(a) != shown(b)) {
        return false;
      }
    }
    for (std::size_t i = 0; i < state.sheets.size(); ++i) {
      if (state.sheets[i].positions != other.state.sheets[i].positions ||
          state.sheets[i].triangles != other.state.sheets[i].triangles ||
          state.sheets[i].colors != other.state.sheets[i].colors) {
        return false;
      }
    }
    return true;
  }

  SceneState state;
  std::uint64_t version;
  std::vector<Eigen::Vector3f> positions;
  std::vector<bool> is_alive;  // tetrahedra, then links
  std::vector<float> rest_volumes;
  std::vector<double> heat;
  double energy;
};

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

// Would catch jaws that find nothing because the hand is deeper than the skin goes along.
TEST_CASE("session: jaws that are pushed deep grasp", "[session]") {
  PlayedSession play;
  const Eigen::Vector3f skin = play.farthest(Organ::gallbladder, {0, 0, -1});
  play.go(0, skin, 20);
  play.go(0, skin + 0.015F * Eigen::Vector3f::UnitZ(), 30);
  play.hands[0].set_jaw(0);
  play.step(1);
  CHECK(play.count(Event::missed) == 0);
  CHECK(play.whole().grasper.is_holding);
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
    seen = {0, state.generation, state.triangle_versions, state.burn_versions, state.vertex_counts};
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

// Would catch an undo that forgets topology, heat, marks, links or energy, tissue that goes again,
// or a window that keeps what an undo took away.
TEST_CASE("session: an undo brings back the scene before the stroke", "[session]") {
  PlayedSession play;
  go_to_fat(play);
  burn(play, 3);  // so that there is something before the stroke
  play.step(20);
  const Scene before(play);
  burn(play, 8);
  play.step(30);
  REQUIRE(play.session.simulation().solver.tissue().version() > before.version + 1);
  SceneState state = play.whole();
  CHECK_FALSE(Scene(play).shows(before));
  const Seen seen{0, state.generation, state.triangle_versions, state.burn_versions,
                  state.vertex_counts};
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == 1);
  play.session.fill(state, seen);
  REQUIRE_FALSE(state.whole.empty());  // though the window had seen all before
  const Scene after(play);
  CHECK(after.is(before));
  CHECK(after.shows(before));
  play.step(100);
  CHECK(play.whole().removed_tets == before.state.removed_tets);
  CHECK(play.whole().parted_strands == before.state.parted_strands);
  float farthest = 0;
  const std::vector<Eigen::Vector3f> now = play.session.simulation().solver.positions();
  for (std::size_t v = 0; v < now.size(); ++v) {
    farthest = std::max(farthest, (now[v] - before.positions[v]).norm());
  }
  CHECK(farthest < 5e-3F);  // the hook pushes, as the hand has gone on meanwhile
  // it can be burnt again, and again be taken back
  burn(play, 4);
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == 2);
  CHECK(play.whole().removed_tets == before.state.removed_tets);
}

// Would catch undos that skip a stroke, take one twice, or know one that changed nothing; and
// memory without bounds.
TEST_CASE("session: strokes are taken back one by one, eight at most", "[session]") {
  PlayedSession play;
  play.session.undo(play.events);
  CHECK(play.count(Event::no_undo) == 1);
  play.hands[1].set_pedals({.cut = true});  // in the air
  play.step(2);
  play.hands[1].set_pedals({});
  play.step(2);
  play.session.undo(play.events);
  CHECK(play.count(Event::no_undo) == 2);
  go_to_fat(play);
  std::vector<Scene> scenes;
  for (std::size_t stroke = 0; stroke < Session::kMostStrokes + 2; ++stroke) {
    scenes.emplace_back(play);
    play.hands[1].set_pedals({.coagulation = true});
    play.step(stroke == 8 ? 60 : 8);
    play.hands[1].set_pedals({});
    play.step(3);
    play.hands[1].move({0, 0, -0.08F});
    play.step(40);
    play.hands[1].set_pedals({.cut = true});  // in the air again
    play.step(2);
    play.hands[1].set_pedals({});
    play.hands[1].move({0, 0, 0.08F});
    play.step(40);
  }
  for (std::size_t i = 0; i < Session::kMostStrokes; ++i) {
    play.session.undo(play.events);
    CAPTURE(i);
    CHECK(play.count(Event::undone) == i + 1);
    CHECK(Scene(play).is(scenes[scenes.size() - 1 - i]));
  }
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == Session::kMostStrokes);
  CHECK(play.count(Event::no_undo) == 3);
}

// Would catch a foot that burns on what an undo has just brought back.
TEST_CASE("session: an undo ends the stroke that goes on", "[session]") {
  PlayedSession play;
  go_to_fat(play);
  play.step(1);
  const Scene before(play);
  play.hands[1].set_pedals({.cut = true});
  play.step(60);
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == 1);
  CHECK(Scene(play).is(before));
  play.step(10);
  CHECK(play.whole().generator.activation == Activation::none);
  CHECK(play.whole().generator.energy == 0);
  play.hands[1].set_pedals({});
  play.step(1);
  play.hands[1].set_pedals({.cut = true});
  play.step(10);
  CHECK(play.whole().generator.energy > 0);
}

// Would catch strands that stay torn, jaws that leap, or hands that are taken back, too.
TEST_CASE("session: an undo of a pull brings strands back and leaves hands alone", "[session]") {
  PlayedSession play;
  play.go(0, play.farthest(Organ::gallbladder, {-1, 0, -0.7F}), 40);
  play.step(20);
  const Scene before(play);
  play.hands[0].set_jaw(0);
  play.step(1);
  REQUIRE(play.count(Event::grasped) == 1);
  for (int i = 0; i < 200 && play.count(Event::strand_parted) < 3; ++i) {
    play.go(0, play.hands[0].tip() + Eigen::Vector3f(-0.0003F, -0.0001F, -0.0004F), 1);
  }
  REQUIRE(play.count(Event::strand_parted) >= 3);
  REQUIRE(play.whole().grasper.is_holding);
  const Eigen::Vector3f tip = play.whole().grasper.pose.translation();
  play.session.undo(play.events);
  CHECK(play.count(Event::undone) == 1);
  const Scene after(play);
  CHECK(after.is(before));
  CHECK(after.shows(before));
  SceneState state = play.whole();
  CHECK(state.grasper.is_closed);
  CHECK_FALSE(state.grasper.is_holding);
  constexpr float kPushed = 2e-3F;  // m, at most, by tissue
  CHECK((state.grasper.pose.translation() - tip).norm() < kPushed);
  play.step(20);
  state = play.whole();
  CHECK(play.count(Event::grasped) == 1);  // jaws that are closed take nothing by themselves
  CHECK(play.count(Event::missed) == 0);
  CHECK((state.grasper.pose.translation() - tip).norm() < kPushed);
}

// Would catch jaws that lose what they held over a burn, or leap with it to a hand far away.
TEST_CASE("session: jaws hold on over an undo where their hand still is", "[session]") {
  PlayedSession play;
  go_to_fat(play);
  play.go(0, play.farthest(Organ::gallbladder, {-1, 0, -0.7F}), 40);
  play.hands[0].set_jaw(0);
  play.step(20);
  REQUIRE(play.whole().grasper.is_holding);
  const auto burn_a_bit = [&] {
    play.hands[1].set_pedals({.coagulation = true});
    play.step(10);
    play.hands[1].set_pedals({});
    play.step(2);
  };
  burn_a_bit();
  play.go(0, play.hands[0].tip() + Eigen::Vector3f(0, 0, -0.3F * Session::kSameHold), 5);
  play.session.undo(play.events);
  CHECK(play.whole().grasper.is_holding);
  play.step(20);
  CHECK(play.whole().grasper.is_holding);
  const Eigen::Vector3f offset = play.session.simulation().grasper.offset;
  CHECK(offset.norm() < 2e-3F);
  CHECK((play.whole().grasper.pose.translation() - play.hands[0].tip() - offset).norm() < 1e-5F);
  CHECK(play.whole().grasper.force.norm() > 0.05F);

  burn_a_bit();
  play.go(0, play.hands[0].tip() + Eigen::Vector3f(0, 0, -1.5F * Session::kSameHold), 40);
  play.session.undo(play.events);
  CHECK_FALSE(play.whole().grasper.is_holding);
  CHECK(play.whole().grasper.is_closed);

  play.hands[0].set_jaw(1);
  play.step(1);
  play.go(0, play.farthest(Organ::gallbladder, {-1, 0, -0.7F}), 40);
  play.hands[0].set_jaw(0);
  play.step(5);
  burn_a_bit();
  REQUIRE(play.whole().grasper.is_holding);
  play.hands[0].set_jaw(1);
  play.step(1);
  play.session.undo(play.events);
  CHECK_FALSE(play.whole().grasper.is_holding);
  CHECK_FALSE(play.whole().grasper.is_closed);
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
