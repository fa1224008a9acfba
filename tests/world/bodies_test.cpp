// SPDX-License-Identifier: Apache-2.0
// Bodies of a world that come and go, whole or in pieces.
#include <algorithm>

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
using testing::kDt;
using testing::SlabWorld;
using testing::Watcher;

}  // namespace

// Would catch ids of bodies that are those of others after a while.
TEST_CASE("world: bodies come and go, and keep their ids", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const BodyId clip = world.add_body("clip", testing::slab(0.05, {1, 1, 1}), tissues::artery());
  CHECK(world.find_body("clip") == clip);
  check_refused([&] { (void)world.surface(clip); }, "body 'clip' is not there yet");
  check_refused([&] { world.remove_body(clip); }, "not there yet");
  check_refused(
      [&] {
        (void)world.add_body("clip", testing::slab(0, {1, 1, 1}), tissues::fat());
      },
      "clip");
  check_refused(
      [&] {
        (void)world.add_body("lower", testing::slab(0, {1, 1, 1}), tissues::fat());
      },
      "lower");
  REQUIRE(world.step(kDt).ok());
  const Surface& skin = world.surface(clip);
  CHECK(skin.vertices().size() == 8);
  const BodyId second = world.add_body("second", testing::slab(0.06, {2, 1, 1}), tissues::fat());
  world.step(kDt);
  CHECK(world.surface(second).vertices().size() == 12);

  world.remove_body(slabs.lower);
  world.remove_body(slabs.lower);  // again is the same
  CHECK(world.step(kDt).ok());
  check_refused([&] { (void)world.surface(slabs.lower); }, "body 'lower' is not there any more");
  check_refused([&] { world.remove_body(slabs.lower); }, "not there any more");
  const Index before = world.body_in_tissue(second);
  world.compact();
  CHECK(world.body_in_tissue(second) < before);
  CHECK(world.tissue().body(world.body_in_tissue(second)).name == "second");
  CHECK(world.tissue().body(world.body_in_tissue(clip)).name == "clip");
  CHECK(world.surface(second).vertices().size() == 12);
  CHECK(&world.surface(clip) == &skin);
  CHECK(world.tissue_of(clip).name == tissues::artery().name);
  check_refused([&] { (void)world.body_in_tissue(slabs.lower); }, "any more");

  // a body waits over a compaction and an undo, and its name is free once it was refused
  Watcher watcher;
  world.tissue().add_follower(watcher);
  const BodyId late = world.add_body("late", testing::slab(0.08, {1, 1, 1}), tissues::fat());
  world.compact();
  watcher.refuses = [](const TopologyEdit& edit) { return !edit.new_bodies.bodies().empty(); };
  CHECK(world.step(kDt).refused.size() == 1);
  check_refused([&] { (void)world.surface(late); }, "refused");
  watcher.refuses = {};
  const BodyId again = world.add_body("late", testing::slab(0.08, {1, 1, 1}), tissues::fat());
  CHECK(again != late);
  CHECK(world.find_body("late") == again);
  CHECK(world.step(kDt).ok());
  CHECK(world.surface(again).vertices().size() == 8);
}

TEST_CASE("world: an undo takes bodies back", "[unit]") {
  World world;
  const BodyId first = world.add_body("first", testing::slab(0, {1, 1, 1}), tissues::fat());
  world.set_gravity({0, 0, 0});
  world.step(kDt);
  const BodyId second = world.add_body("second", testing::slab(1, {1, 1, 1}), tissues::fat());
  world.step(kDt);
  CHECK(world.body_in_tissue(second) == 1);
  world.undo();
  check_refused([&] { (void)world.body_in_tissue(second); }, "any more");
  world.remove_body(first);
  world.step(kDt);
  check_refused([&] { (void)world.surface(first); }, "any more");
  world.undo();
  CHECK(world.body_in_tissue(first) == 0);
  CHECK(world.surface(first).vertices().size() == 8);
  world.remove_body(first);
  world.edit({.remove_bodies = {0}});
  CHECK(world.step(kDt).ok());  // who asks twice gets it once
}

TEST_CASE("world: a body that goes in other ways is reported when it is to go", "[unit]") {
  World world;
  const BodyId body = world.add_body("body", testing::slab(0, {1, 1, 1}), tissues::fat());
  world.step(kDt);
  world.remove_body(body);
  world.tissue().apply({.remove_bodies = {0}});  // past the world
  const Frame frame = world.step(kDt);
  REQUIRE(frame.refused.size() == 1);
  CHECK_THAT(frame.refused[0].why, ContainsSubstring("'body' is not there any more"));
}

// Would catch pieces that stay behind, and a second follower for who asks again.
TEST_CASE("world: pieces follow edits, bodies, undo and compaction", "[unit]") {
  World world;
  const BodyId slab = world.add_body("slab", testing::slab(0), tissues::fat());
  world.fix(slab, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  const LivePieces& pieces = world.pieces();
  CHECK(pieces.count() == 1);
  CHECK(pieces.is_anchored(0));

  TopologyEdit divide;  // all tetrahedra at the middle
  const Tissue& tissue = world.tissue();
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    const auto x = [&](Index v) { return tissue.rest_positions()[v].x(); };
    const auto [low, high] = std::ranges::minmax(tissue.tets()[t], {}, x);
    if (x(low) < 3.5 * testing::kEdge && x(high) > 3.5 * testing::kEdge) {
      divide.remove_tets.push_back(t);
    }
  }
  world.edit(divide);
  REQUIRE(world.step(kDt).ok());
  REQUIRE(pieces.count() == 2);
  const Index freed = pieces.first_freed();
  CHECK(pieces.is_anchored(1 - freed) != pieces.is_anchored(freed));
  world.undo();
  CHECK(pieces.count() == 1);
  world.edit(divide);
  world.add_body("other", testing::slab(7e-3), tissues::fat());
  REQUIRE(world.step(kDt).ok());
  CHECK(pieces.count() == 3);
  world.compact();
  CHECK(&world.pieces() == &pieces);
  CHECK(pieces.tet_count(0) + pieces.tet_count(1) + pieces.tet_count(2) ==
        static_cast<Index>(world.tissue().tets().size()));
}

}  // namespace pbdsurg
