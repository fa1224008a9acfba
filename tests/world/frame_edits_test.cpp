// SPDX-License-Identifier: Apache-2.0
// The edits of a frame: those of heat, strands and program, which become one.
#include <algorithm>
#include <utility>

#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/world/world.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/watcher.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::check_refused;
using testing::ContainsSubstring;
using testing::count_events;
using testing::kBadEdit;
using testing::kDt;
using testing::SlabWorld;
using testing::Watcher;

// Burns until heat takes tissue, and gives the step in which it does, and what it takes.
std::pair<int, std::vector<Index>> find_first_loss() {
  SlabWorld slabs;
  slabs.burn();
  for (int step = 0; step < 100; ++step) {
    if (slabs.world.step(kDt).removed_tets > 0) {
      return {step, slabs.world.tissue().last_change().removed_tets};
    }
  }
  FAIL("nothing was burnt");
  return {};
}

}  // namespace

// Would catch followers that follow a frame piece by piece, or a source that is asked too early.
TEST_CASE("world: heat, strands and program become one edit, in this order", "[unit]") {
  const auto [step, burnt] = find_first_loss();
  SlabWorld slabs;
  World& world = slabs.world;
  Watcher watcher;
  world.tissue().add_follower(watcher);
  slabs.burn();
  for (int i = 0; i < step; ++i) {
    world.step(kDt);
  }
  watcher.follows = 0;
  // what heat takes, too, and what the blade cuts, too
  std::vector<Index> named = burnt;
  const Index corner = world.tissue().tets_of(1).back();
  named.push_back(corner);
  const Index cut = world.strands().strands()[0].first_link;
  world.edit({.remove_tets = named, .remove_links = {cut}});
  world.edit({.remove_tets = {corner}});
  slabs.cut_strands();
  const Index whole = world.strands().whole_count();
  const Frame frame = world.step(kDt);

  CHECK(frame.ok());
  CHECK(frame.why().empty());
  CHECK(watcher.follows == 1);
  CHECK(watcher.last.edit.remove_tets == named);  // heat's, then the program's
  CHECK(frame.removed_tets == static_cast<Index>(named.size()));
  CHECK(frame.parted_strands == whole);
  CHECK(count_events(world, StrandLoss::blade) == whole);  // the first too: strands are first
  CHECK(world.cautery(slabs.burner).removal_energy() > 0);
  CHECK(world.step(kDt).parted_strands == 0);  // a blade cuts once
}

// Would catch a bad source that takes the good ones with it, forgets why strands parted, or counts
// as done what was not.
TEST_CASE("world: a refused source is reported, the others go through", "[unit]") {
  const auto first_loss = find_first_loss();
  const int step = first_loss.first;
  const std::vector<Index>& burnt = first_loss.second;
  for (const EditSource refused : {EditSource::program, EditSource::strands, EditSource::heat}) {
    SlabWorld slabs;
    World& world = slabs.world;
    Watcher watcher;
    world.tissue().add_follower(watcher);
    slabs.burn();
    for (int i = 0; i < step; ++i) {
      world.step(kDt);
    }
    const Index corner = world.tissue().tets_of(1).back();
    watcher.refuses = [&](const TopologyEdit& edit) {
      switch (refused) {
        case EditSource::heat:
          return std::ranges::count(edit.remove_tets, burnt[0]) > 0;
        case EditSource::strands:
          return !edit.remove_links.empty();
        case EditSource::program:
          return false;
      }
      return false;
    };
    if (refused == EditSource::program) {
      world.edit(kBadEdit);
    }
    std::vector<Index> named{corner};
    if (refused != EditSource::heat) {
      named.insert(named.end(), burnt.begin(), burnt.end());  // gone when its turn comes
    }
    world.edit({.remove_tets = named});
    slabs.cut_strands();
    const Index whole = world.strands().whole_count();
    const Frame frame = world.step(kDt);

    CHECK_FALSE(frame.ok());
    REQUIRE(frame.refused.size() == 1);
    CHECK(frame.refused[0].source == refused);
    CHECK_THAT(frame.refused[0].why,
               ContainsSubstring(refused == EditSource::program ? "tet -1" : "not now"));
    CHECK_THAT(frame.why(), ContainsSubstring(name_of(refused)));
    CHECK_FALSE(world.tissue().is_tet_alive(corner));
    CHECK(world.tissue().is_tet_alive(burnt[0]) == (refused == EditSource::heat));
    CHECK((world.cautery(slabs.burner).removal_energy() == 0) == (refused == EditSource::heat));
    CHECK(frame.parted_strands == (refused == EditSource::strands ? 0 : whole));
    CHECK(count_events(world, StrandLoss::blade) == frame.parted_strands);

    watcher.refuses = {};
    CHECK(world.step(kDt).ok());  // what was refused is not asked for again, but for heat
    CHECK_FALSE(world.tissue().is_tet_alive(burnt[0]));
  }
}

// Would catch energy that an undo takes away twice, or gives back.
TEST_CASE("world: undoing the last part of a frame leaves what heat did in it", "[unit]") {
  const auto [step, burnt] = find_first_loss();
  SlabWorld slabs;
  slabs.burn();
  for (int i = 0; i < step; ++i) {
    slabs.world.step(kDt);
  }
  slabs.world.edit({.remove_tets = {slabs.world.tissue().tets_of(1).back()}});
  slabs.world.edit({.remove_tets = {-1}});
  CHECK(slabs.world.step(kDt).refused.size() == 1);
  const double spent = slabs.world.cautery(slabs.burner).removal_energy();
  CHECK(spent > 0);
  slabs.world.undo();
  CHECK(slabs.world.cautery(slabs.burner).removal_energy() == spent);
}

// Would catch ids of what comes that are another's by then.
TEST_CASE("world: several edits of a frame may bring vertices", "[unit]") {
  const bool one_is_refused = GENERATE(false, true);
  SlabWorld slabs;
  World& world = slabs.world;
  world.step(kDt);
  const LivePieces pieces(world.tissue());
  const Index before = pieces.count();
  double mass = 0;
  for (const double each : world.tissue().masses()) {
    mass += each;
  }
  const auto tets = static_cast<Index>(world.tissue().tets().size());
  if (one_is_refused) {
    world.edit(kBadEdit);
  }
  world.edit(plan_cut(world.solver(), testing::cut_at(5e-3F, -0.01F, 5e-3F)).edit);
  world.edit(plan_cut(world.solver(), testing::cut_at(7e-3F, 6e-3F, 0.02F)).edit);
  // a bead that hangs from the edit's own vertex, whatever numbers others took
  TopologyEdit bead;
  bead.new_bodies.add_particles("bead", std::vector<Eigen::Vector3d>{{0.1, 0.2, 0.3}}, 1e-6);
  bead.new_links = {{world.tissue().body(0).first_vertex, world.tissue().vertex_count(), 1, {}}};
  world.edit(bead);
  const BodyId guest = world.add_body("guest", testing::slab(0.1, {1, 1, 1}), tissues::fat());
  const Frame frame = world.step(kDt);

  CHECK(frame.refused.size() == (one_is_refused ? 1 : 0));
  CHECK(pieces.count() == before + 3);
  double mass_after = 0;
  for (const double each : world.tissue().masses()) {
    mass_after += each;
  }
  CHECK(mass_after - mass ==
        testing::Approx(1e-6 + 8e-9 * tissues::fat().mechanics.density).epsilon(1e-6));
  CHECK(static_cast<Index>(world.tissue().tets().size()) > tets + 20);
  const Link& link = world.tissue().links().back();
  CHECK(world.tissue().bodies()[world.tissue().body_of_vertex(link.second)].name == "bead");
  CHECK(world.tissue().body(world.body_in_tissue(guest)).name == "guest");
  CHECK(frame.report.inverted_tets == 0);
  check_refused([&] { (void)world.find_body("bead"); }, "bead");  // it has no BodyId
}

TEST_CASE("world: an edit for a topology that has changed since is refused", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  world.step(kDt);
  world.edit({.remove_tets = {3}});
  world.compact();
  const Frame frame = world.step(kDt);
  REQUIRE(frame.refused.size() == 1);
  CHECK_THAT(frame.refused[0].why, ContainsSubstring("topology version"));
  CHECK(frame.removed_tets == 0);
}

// Would catch a follower that is called after its end, and an undo that half happens.
TEST_CASE("world: followers of a program's own come and go", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  {
    Watcher brief;
    world.tissue().add_follower(brief);
    world.edit({.remove_tets = {1}});
    world.step(kDt);
    CHECK(brief.follows == 1);
  }
  world.edit({.remove_tets = {2}});
  CHECK(world.step(kDt).ok());
  Watcher late;
  world.tissue().add_follower(late);
  const std::uint64_t before = slabs.hash();
  check_refused([&] { world.undo(); }, "came after the last edit");
  CHECK_FALSE(world.tissue().is_tet_alive(2));
  CHECK(slabs.hash() == before);
  world.edit({.remove_tets = {4}});
  world.step(kDt);
  world.undo();
  CHECK(world.tissue().is_tet_alive(4));

  late.refuses = [](const TopologyEdit&) { return true; };
  world.edit({.remove_tets = {4}});
  slabs.cut_strands();
  const Frame frame = world.step(kDt);
  REQUIRE(frame.refused.size() == 2);
  CHECK(frame.refused[0].source == EditSource::strands);
  CHECK(frame.parted_strands == 0);
  CHECK(world.strands().events().empty());
  CHECK(world.tissue().is_tet_alive(4));
}

// Would catch a step that did not happen and a frame that does not tell.
TEST_CASE("frame: of a step that was given up it says so") {
  Frame frame;
  CHECK(frame.ok());
  frame.report.stalled = true;
  CHECK_FALSE(frame.ok());
  CHECK_THAT(frame.why(), ContainsSubstring("gave the step up"));
}

}  // namespace pbdsurg
