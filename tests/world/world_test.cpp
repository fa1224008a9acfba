// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <stdexcept>
#include <utility>

#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/views/live_pieces.h"

#include "tests/support/bad_ids.h"
#include "tests/support/catch.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::ContainsSubstring;
using testing::kBadEdit;
using testing::kDt;
using testing::SlabWorld;

// Counts what it follows, and refuses what it is told to.
struct Watcher final : Follower {
  void validate(const Tissue&, const TopologyEdit& edit) const override {
    if (refuses && refuses(edit)) {
      throw std::runtime_error("not now");
    }
  }
  void follow(const Tissue&, const TissueChange& change) noexcept override {
    ++follows;
    last = change;
  }
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

  std::function<bool(const TopologyEdit&)> refuses;
  int follows = 0;
  TissueChange last;
};

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

Index count_events(World& world, StrandLoss cause) {
  return static_cast<Index>(
      std::ranges::count(world.strands().events(), cause, &StrandEvent::cause));
}

template <class Call>
void check_refused(Call call, const std::string& what) {
  CHECK_THROWS_AS(call(), InvalidArgument);
  CHECK_THROWS_WITH(call(), ContainsSubstring(what));
}

}  // namespace

// Would catch any other order of a frame, and electrodes, edits or forces one step late.
TEST_CASE("world: does what parts wired by hand do, to the bit", "[property]") {
  SlabWorld slabs;
  World& world = slabs.world;

  Scene scene;
  const TetMesh low = testing::slab(0), high = testing::slab(7e-3);
  scene.add_body("lower", low, tissues::fat().mechanics);
  scene.add_body("upper", high, tissues::fat().mechanics);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * testing::kEdge; });
  scene.set_gravity({0, 0, 0});
  ConnectiveTissue strands;
  strands.join(scene, 0, 1,
               scattered_links(low, high,
                               {.max_distance = testing::kJoin.max_distance,
                                .density = testing::kJoin.density}),
               testing::kJoin.strands);
  Solver solver(scene, {.damping = 20});
  solver.tissue().add_follower(strands, FollowerRank::surgery);
  const ToolId hook = solver.add_tool({}, at(testing::kTop));
  const ToolId grasper = solver.add_tool({}, at({6e-3F, 6e-3F, 11e-3F}));
  Cautery cautery(solver.tissue(), std::array{ThermalBody{0, tissues::fat().heat},
                                              ThermalBody{1, tissues::fat().heat}});

  const std::vector<Index> held = world.grasp_near(slabs.grasper, slabs.upper, 5e-3F, 1e-4F);
  REQUIRE(held.size() > 4);
  solver.grasp(grasper, held, 1e-4F);
  Index removed = 0, parted = 0;
  for (int step = 0; step < 60; ++step) {
    const float way = 1e-4F * static_cast<float>(step);
    const Eigen::Vector3f tip = testing::kTop + Eigen::Vector3f(way / 4, 0, -way / 10);
    const Eigen::Vector3f pulled(6e-3F, 6e-3F, 11e-3F + way);
    world.move(slabs.hook, at(tip));
    world.replica(ReplicaId(0)).move(slabs.grasper, at(pulled));  // the world's own is the first
    if (step == 10) {
      slabs.burn();
    }
    const Frame frame = world.step(kDt);
    REQUIRE(frame.ok());
    removed += frame.removed_tets;
    parted += frame.parted_strands;

    solver.move_tool(hook, at(tip));
    solver.move_tool(grasper, at(pulled));
    TopologyEdit edit;
    CauteryReport report =
        cautery.heat(solver, {tip, tip}, step < 10 ? off_settings() : cut_settings(60), kDt, edit);
    strands.find_parting(solver, {}, edit);
    if (!edit.remove_tets.empty() || !edit.remove_links.empty() || !edit.rest_lengths.empty() ||
        !edit.rest_volumes.empty()) {
      solver.tissue().apply(edit);
      cautery.commit(report);
    }
    const StepReport stepped = solver.step(static_cast<float>(kDt));

    REQUIRE(slabs.hash() == solver.state_hash());
    REQUIRE(world.force(slabs.grasper) == solver.tool_force(grasper));
    REQUIRE(frame.report.volume_residual == stepped.volume_residual);
    REQUIRE(frame.cauteries.at(0).energy == report.energy);
    REQUIRE(frame.cauteries.at(0).removed_volume == report.removed_volume);
    REQUIRE(world.cautery(slabs.burner).removal_energy() == cautery.removal_energy());
    REQUIRE(world.strands().whole_count() == strands.whole_count());
  }
  CHECK(removed > 5);
  CHECK(parted > 5);
  CHECK(count_events(world, StrandLoss::torn) > 0);
}

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
  const auto [step, burnt] = find_first_loss();
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

TEST_CASE("world: replicas are the copies of a solver", "[unit]") {
  const SolverOptions options{.executor = executor::serial()};
  SolverOptions three = options;
  three.copies = 3;
  World world(three);
  const BodyId body = world.add_body("body", testing::slab(0), tissues::fat());
  world.fix(body, {0, 1, 2});
  const ToolId tool = world.add_tool({{{0, 0, 0}, {0.02F, 0, 0}, 1e-3F}}, at({0, 6e-3F, 6e-3F}));
  Scene scene;
  scene.add_body("body", testing::slab(0), tissues::fat().mechanics);
  scene.fix_vertices(0, std::vector<Index>{0, 1, 2});
  Solver solver(scene, three);
  solver.add_tool(std::vector<Capsule>{{{0, 0, 0}, {0.02F, 0, 0}, 1e-3F}}, at({0, 6e-3F, 6e-3F}));

  const Snapshot start = world.replica(ReplicaId(2)).snapshot();
  const std::vector<Index> held{140, 141};
  for (int step = 0; step < 10; ++step) {
    for (Index i = 0; i < 3; ++i) {
      Replica replica = world.replica(ReplicaId(i));
      const ToolPose pose = at({0, 6e-3F, 6e-3F - 1e-4F * static_cast<float>(i * step)});
      replica.move(tool, pose);
      solver.move_tool(tool, pose, i);
      if (step == 3 * i) {
        replica.grasp(tool, held, 1e-3F);
        solver.grasp(tool, held, 1e-3F, i);
      }
      if (step == 8) {
        replica.release(tool);
        solver.release(tool, i);
      }
    }
    world.step(kDt);
    solver.step(static_cast<float>(kDt));
    for (Index i = 0; i < 3; ++i) {
      const Replica replica = world.replica(ReplicaId(i));
      REQUIRE(replica.state_hash() == solver.state_hash(i));
      REQUIRE(replica.force(tool) == solver.tool_force(tool, i));
      REQUIRE(replica.positions() == solver.positions(i));
      REQUIRE(replica.velocities() == solver.velocities(i));
      REQUIRE(replica.report().contacts == solver.last_report(i).contacts);
    }
  }
  CHECK(world.replica(ReplicaId(0)).state_hash() != world.replica(ReplicaId(2)).state_hash());
  world.replica(ReplicaId(1)).restore(start);
  CHECK(world.replica(ReplicaId(1)).positions() == start.positions);
  world.replica(ReplicaId(0)).restore(start);
  CHECK(world.pose(tool).isApprox(at({0, 6e-3F, 6e-3F})));  // the world's tools went back, too
  for (const Index bad : testing::bad_ids(3)) {
    check_refused([&] { (void)world.replica(ReplicaId(bad)); },
                  "no replica " + std::to_string(bad) + "; the world has 3");
  }
}

TEST_CASE("world: ids that are not there are named", "[unit]") {
  SlabWorld slabs;
  World& world = slabs.world;
  const std::uint64_t before = slabs.hash();
  const auto bodies = [](Index id) {
    return "no body " + std::to_string(id) + "; the world has 2";
  };
  const auto tools = [](Index id) {
    return "no tool " + std::to_string(id) + "; the solver has 2";
  };
  for (const Index id : testing::bad_ids(2)) {
    const BodyId body(id);
    check_refused([&] { world.remove_body(body); }, bodies(id));
    check_refused([&] { (void)world.surface(body); }, bodies(id));
    check_refused([&] { (void)world.tissue_of(body); }, bodies(id));
    check_refused([&] { (void)world.body_in_tissue(body); }, bodies(id));
    check_refused([&] { (void)world.grasp_near(slabs.grasper, body, 1e-3F); }, bodies(id));
    check_refused([&] { world.add_cautery(slabs.hook, {body}); }, bodies(id));
    const ToolId tool(id);
    check_refused([&] { world.move(tool, ToolPose::Identity()); }, tools(id));
    check_refused([&] { world.grasp(tool, {}); }, tools(id));
    check_refused([&] { (void)world.grasp_near(tool, slabs.lower, 1e-3F); }, tools(id));
    check_refused([&] { world.release(tool); }, tools(id));
    check_refused([&] { (void)world.pose(tool); }, tools(id));
    check_refused([&] { (void)world.force(tool); }, tools(id));
    check_refused([&] { world.add_cautery(tool, {slabs.lower}); }, tools(id));
  }
  for (const Index id : testing::bad_ids(1)) {
    const std::string why = "no cautery " + std::to_string(id) + "; the world has 1";
    check_refused([&] { world.energise(CauteryId(id), {}); }, why);
    check_refused([&] { (void)world.cautery(CauteryId(id)); }, why);
  }
  check_refused([&] { (void)world.find_body("spleen"); }, "'spleen'; the world has: lower, upper");
  CHECK(slabs.hash() == before);
  CHECK_FALSE(std::is_convertible_v<Index, ToolId>);  // nor a tool for a replica or a body
  CHECK_FALSE(std::is_convertible_v<BodyId, ToolId>);
  CHECK_FALSE(std::is_invocable_v<decltype(&Solver::tool_force), Solver&, Index, Index>);

  World scene;  // and before there is a solver
  const BodyId body = scene.add_body("body", testing::slab(0), tissues::fat());
  for (const Index id : testing::bad_ids(1)) {
    const std::string why = "no body " + std::to_string(id) + "; the world has 1";
    check_refused([&] { scene.fix(BodyId(id), {0}); }, why);
    check_refused([&] { scene.fix(BodyId(id), [](const auto&) { return true; }); }, why);
    check_refused([&] { scene.join(body, BodyId(id)); }, why);
    check_refused([&] { scene.join(BodyId(id), body); }, why);
    check_refused([&] { (void)scene.surface(BodyId(id)); }, why);
    check_refused([&] { scene.remove_body(BodyId(id)); }, why);
    check_refused([&] { scene.move(ToolId(id), ToolPose::Identity()); },
                  "no tool " + std::to_string(id) + "; the world has 0");
    check_refused([&] { scene.add_cautery(ToolId(id), {body}); }, "no tool");
    check_refused([&] { (void)scene.replica(ReplicaId(id)); }, "the world has 1");
  }
  check_refused([&] { scene.undo(); }, "no edit to undo");
  scene.fix(body, std::vector<Index>{0});  // none of these made the solver
}

TEST_CASE("world: values out of range are refused and change nothing", "[unit]") {
  SlabWorld slabs, other;
  World& world = slabs.world;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  for (SlabWorld* each : {&slabs, &other}) {
    each->burn();
    each->cut_strands();
    each->world.edit({.remove_tets = {3}});
    each->world.add_body("guest", testing::slab(0.1, {1, 1, 1}), tissues::fat());
  }
  const HeatLedger before = world.cautery(slabs.burner).field().ledger();
  for (const double dt : {0.0, -1.0, 1e-60, 1e-14, 1e60, std::numeric_limits<double>::infinity(),
                          std::numeric_limits<double>::quiet_NaN()}) {
    CHECK_THROWS_AS(world.step(dt), InvalidArgument);
  }
  CHECK(world.cautery(slabs.burner).field().ledger().in == before.in);
  CHECK_THROWS_AS(world.sweep({{{kNan, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}}),
                  InvalidArgument);
  CHECK_THROWS_AS(world.energise(slabs.burner, cut_settings(-1)), InvalidArgument);
  CHECK_THROWS_AS(world.move(slabs.hook, at({kNan, 0, 0})), InvalidArgument);
  CHECK_THROWS_AS(world.grasp_near(slabs.grasper, slabs.upper, kNan), InvalidArgument);
  CHECK_THROWS_AS(world.add_tool({{{0, 0, 0}, {0, 0, 0}, -1}}), InvalidArgument);
  CHECK_THROWS_AS(world.add_cautery(slabs.hook, {slabs.lower}), InvalidArgument);
  for (SlabWorld* each : {&slabs, &other}) {
    const Frame frame = each->world.step(kDt);
    CHECK(frame.ok());
    CHECK(frame.removed_tets >= 1);
    CHECK(frame.parted_strands == slabs.strand_count);
    CHECK(each->world.surface(each->world.find_body("guest")).vertices().size() == 8);
  }
  CHECK(slabs.hash() == other.hash());
  CHECK(world.cautery(slabs.burner).field().ledger().in ==
        other.world.cautery(other.burner).field().ledger().in);
}

TEST_CASE("world: one that was moved from says so, and what it was goes on", "[unit]") {
  SlabWorld slabs, twin;
  const Surface& skin = slabs.world.surface(slabs.lower);
  static_cast<void>(twin.world.surface(twin.lower));
  Replica replica = slabs.world.replica(ReplicaId(0));
  slabs.burn();
  twin.burn();
  slabs.world.step(kDt);
  twin.world.step(kDt);
  World there = std::move(slabs.world);
  World& gone = slabs.world;
  const BodyId body = slabs.lower;
  const ToolId tool = slabs.hook;
  const TetMesh mesh = testing::slab(0, {1, 1, 1});
  const std::vector<std::function<void()>> calls{
      [&] { gone.add_body("x", mesh, tissues::fat()); },
      [&] { gone.fix(body, {0}); },
      [&] { gone.fix(body, [](const auto&) { return true; }); },
      [&] { gone.join(body, body); },
      [&] {
        gone.set_gravity({0, 0, 0});
      },
      [&] { gone.remove_body(body); },
      [&] { gone.add_tool({}); },
      [&] { gone.move(tool, ToolPose::Identity()); },
      [&] { gone.grasp(tool, {}); },
      [&] { (void)gone.grasp_near(tool, body, 1); },
      [&] { gone.release(tool); },
      [&] { (void)gone.pose(tool); },
      [&] { (void)gone.force(tool); },
      [&] { gone.add_cautery(tool, {body}); },
      [&] { gone.energise(slabs.burner, {}); },
      [&] {
        gone.sweep({{{0, 0, 0}, {0, 0, 0}}, {{0, 0, 0}, {0, 0, 0}}});
      },
      [&] { gone.step(kDt); },
      [&] { gone.edit({}); },
      [&] { gone.undo(); },
      [&] { gone.compact(); },
      [&] { (void)gone.surface(body); },
      [&] { (void)gone.pieces(); },
      [&] { gone.add_hinges(body, 1e-3F); },
      [&] { (void)gone.find_body("lower"); },
      [&] { (void)gone.tissue_of(body); },
      [&] { (void)gone.body_in_tissue(body); },
      [&] { (void)gone.replica(ReplicaId(0)); },
      [&] { (void)gone.tissue(); },
      [&] { (void)gone.solver(); },
      [&] { (void)gone.strands(); },
      [&] { (void)gone.cautery(slabs.burner); },
  };
  for (const auto& call : calls) {
    check_refused(call, "a world was moved from");
  }
  for (int step = 0; step < 10; ++step) {
    there.step(kDt);
    twin.world.step(kDt);
    REQUIRE(there.solver().state_hash() == twin.hash());
  }
  CHECK(replica.state_hash() == twin.hash());
  CHECK(&there.surface(body) == &skin);
  CHECK(std::ranges::equal(skin.positions(), twin.world.surface(body).positions()));
  CHECK(there.strands().whole_count() == twin.world.strands().whole_count());
  gone = std::move(there);
  gone.step(kDt);
  twin.world.step(kDt);
  CHECK(slabs.hash() == twin.hash());
  gone = World();  // which lets go of all
  CHECK(gone.step(kDt).ok());
}

TEST_CASE("world: cauteries may come late, and share no body", "[unit]") {
  World world({.damping = 20});
  const BodyId lower = world.add_body("lower", testing::slab(0), tissues::fat());
  const BodyId upper = world.add_body("upper", testing::slab(7e-3), tissues::fat());
  world.set_gravity({0, 0, 0});
  world.step(kDt);
  const CutPlan plan = plan_cut(world.solver(), testing::cut_at(9e-3F, 2e-3F, 5e-3F));
  REQUIRE_FALSE(plan.edit.new_tets.empty());
  world.edit(plan.edit);
  CHECK(world.step(kDt).ok());
  const Surface& skin = world.surface(lower);
  CHECK(skin.marks().empty());

  const ToolId hook = world.add_tool({}, at({4e-3F, 6e-3F, 4.2e-3F}));
  const ToolId other = world.add_tool({}, at({4e-3F, 6e-3F, 11.2e-3F}));
  check_refused([&] { world.add_cautery(hook, {lower, lower}); }, "twice");
  const CauteryId burner = world.add_cautery(hook, {lower});
  CHECK(skin.marks().size() == skin.vertices().size());
  check_refused([&] { world.undo(); }, "came after the last edit");
  check_refused(
      [&] {
        world.add_cautery(other, {upper, lower});
      },
      "body 'lower' is burnt by another cautery");
  CHECK(world.surface(upper).marks().empty());
  const CauteryId second = world.add_cautery(other, std::vector<BodyId>{upper});
  world.energise(burner, cut_settings(60));
  world.energise(second, cut_settings(60));
  Index removed = 0;
  for (int step = 0; step < 60; ++step) {
    const Frame frame = world.step(kDt);
    REQUIRE(frame.ok());
    REQUIRE(frame.cauteries.size() == 2);
    removed += frame.removed_tets;
    CHECK(frame.cauteries[0].energy > 0);
  }
  CHECK(removed > 0);
  CHECK(world.cautery(burner).removal_energy() > 0);
  CHECK(world.cautery(second).removal_energy() > 0);
  CHECK(std::ranges::max(world.surface(upper).temperatures()) > 60);
  world.energise(burner, off_settings());
  CHECK(world.step(kDt).cauteries[0].energy == 0);
}

TEST_CASE("world: the scene comes before the solver", "[unit]") {
  World world;
  const BodyId first = world.add_body("first", testing::slab(0), tissues::fat());
  const BodyId second = world.add_body("second", testing::slab(7e-3), tissues::fat());
  CHECK(world.fix(first, [](const Eigen::Vector3d& x) { return x.z() < 1e-3; }) == 49);
  check_refused([&] { world.fix(first, {147}); }, "no vertex 147");
  check_refused([&] { world.join(first, first); }, "linked to itself");
  check_refused([&] { world.join(first, second, {.density = -1}); }, "density");
  CHECK(world.join(first, second, testing::kJoin) > 0);
  check_refused([&] { world.add_body("third", testing::slab(0), TissueRecord{}); }, "density");
  check_refused([&] { world.add_hinges(first, -1); }, "rigidity");
  CHECK(world.add_hinges(first, 1e-6F) > 0);
  check_refused([&] { world.add_hinges(first, 1e-6F); }, "have a hinge already");
  world.add_tool({});
  const char* const rule = "comes before the solver is made";
  check_refused([&] { world.fix(first, {0}); }, rule);
  check_refused([&] { world.fix(first, [](const auto&) { return true; }); }, rule);
  check_refused([&] { world.join(first, second); }, rule);
  check_refused([&] { world.add_hinges(first, 1e-6F); }, rule);
  check_refused([&] { world.set_gravity({0, 0, 0}); }, rule);
  CHECK(world.step(kDt).ok());
}

TEST_CASE("world: an empty one steps, and takes bodies in", "[unit]") {
  World world;
  CHECK(world.step(kDt).ok());
  world.compact();
  CHECK(world.step(kDt).ok());
  const BodyId body = world.add_body("body", testing::slab(0), tissues::fat());
  const ToolId tool = world.add_tool({});
  CHECK(world.step(kDt).ok());
  CHECK(world.surface(body).vertices().size() == 147);
  world.move(tool, at({1e-3F, 0, 0}));
  CHECK(world.pose(tool).translation().x() == 1e-3F);
  CHECK(world.step(kDt).ok());

  World tools;  // a tool before any body
  tools.add_tool({{{0, 0, 0}, {0, 0, 0}, 1e-3F}});
  CHECK(tools.step(kDt).ok());
  tools.energise(tools.add_cautery(ToolId{0}, {}), cut_settings(30));  // nothing to burn
  CHECK(tools.step(kDt).cauteries.at(0).energy == 0);
}

TEST_CASE("world: of a whole scene, there is one tissue a body", "[unit]") {
  Scene scene;
  scene.add_body("a", testing::slab(0), tissues::fat().mechanics);
  scene.add_body("b", testing::slab(7e-3), tissues::fat().mechanics);
  ConnectiveTissue strands;
  Scene joined = scene;
  strands.join(joined, 0, 1,
               scattered_links(testing::slab(0), testing::slab(7e-3), {.max_distance = 6e-3}));
  check_refused([&] { World(scene, std::array{tissues::fat()}); }, "1 tissues for 2 bodies");
  check_refused(
      [&] {
        World(scene, std::array{tissues::fat(), tissues::fat()}, strands);
      },
      "the scene has 0 links");
  World world(joined, std::array{tissues::fat(), tissues::liver()}, strands);
  CHECK(world.tissue_of(world.find_body("b")).name == "liver");
  CHECK(world.step(kDt).ok());
  CHECK(world.strands().whole_count() == strands.whole_count());
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

// Would catch defaults that a newcomer's first program explodes with.
TEST_CASE("world: with defaults, each tissue hangs, is grasped and let go in good shape",
          "[unit]") {
  for (const TissueRecord& tissue : tissues::all()) {
    INFO(tissue.name);
    World world;
    const BodyId body = world.add_body("organ", testing::slab(0), tissue);
    world.fix(body, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
    const ToolId grasper = world.add_tool({}, at({12e-3F, 6e-3F, 2e-3F}));
    CHECK_FALSE(world.grasp_near(grasper, body, 5e-3F).empty());
    for (int step = 0; step < 60; ++step) {
      const float way = 2e-4F * static_cast<float>(std::min(step, 20));
      world.move(grasper, at({12e-3F + way / 4, 6e-3F + way, 2e-3F}));
      if (step == 40) {
        world.release(grasper);
      }
      const Frame frame = world.step(1.0 / 60);
      REQUIRE(frame.ok());
      REQUIRE(frame.report.inverted_tets == 0);
    }
  }
}

}  // namespace pbdsurg
