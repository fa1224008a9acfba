// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "pbdsurg/surgery/cut.h"

#include "tests/support/bad_ids.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::check_refused;
using testing::count_events;
using testing::kDt;
using testing::SlabWorld;

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
  CHECK(parted > 1);
  CHECK(count_events(world, StrandLoss::torn) > 0);
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

// Would catch points that are held without a face, and faces that an undo brings back unheld.
TEST_CASE("world: jaws let go of faces that a cut parts, and hold them again after its undo",
          "[property]") {
  for (const SolverMethod method : {SolverMethod::vertex_block, SolverMethod::projection}) {
    SlabWorld slabs({.method = method, .damping = 20});
    World& world = slabs.world;
    const Grip grip{.pad = {.half_length = 8e-3F, .half_width = 8e-3F}, .clamp_force = 1};
    const std::size_t held = world.grasp_between(slabs.grasper, slabs.upper, 12e-3F, grip, 1e-3F);
    REQUIRE(held > 200);
    world.move(slabs.grasper, at({6e-3F, 6e-3F, 11.5e-3F}));
    REQUIRE(world.step(kDt).ok());
    const GripReport before = world.grip(slabs.grasper);
    CHECK(before.points.size() == held);
    world.edit(plan_cut(world.solver(), testing::cut_at(5.3e-3F, 6e-3F, 13e-3F)).edit);
    REQUIRE(world.step(kDt).ok());
    const GripReport cut = world.grip(slabs.grasper);
    CHECK(cut.state == GripState::holding);
    CHECK(cut.points.size() < held);
    for (const GraspedPoint& point : cut.points) {
      CHECK(world.tissue().has_tissue(point.point.vertices[0]));
    }
    // what only the cut made is let go of by its undo
    world.undo();
    REQUIRE(world.step(kDt).ok());
    const GripReport after = world.grip(slabs.grasper);
    REQUIRE(after.points.size() == held);
    for (std::size_t i = 0; i < held; ++i) {
      CHECK(after.points[i].point.vertices == before.points[i].point.vertices);
    }
  }
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

// Would catch a field on another body, one that new vertices of a cut or lost ones upset, and a
// gravity that waits for a scene.
TEST_CASE("world: forces and gravity move the body that they are for, at any time", "[unit]") {
  World world({.damping = 20});
  const BodyId low = world.add_body("lower", testing::slab(0), tissues::fat());
  const BodyId high = world.add_body("upper", testing::slab(7e-3), tissues::fat());
  world.fix(low, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * testing::kEdge; });
  world.set_gravity({0, 0, 0});
  world.step(kDt);
  const auto mean_of = [&](BodyId body) {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    const std::vector<Eigen::Vector3f> x = world.solver().positions();
    const Body& own = world.tissue().body(world.body_in_tissue(body));
    for (Index v = own.first_vertex; v < own.first_vertex + own.vertex_count; ++v) {
      sum += x[v] / static_cast<float>(own.vertex_count);
    }
    return sum;
  };
  const Eigen::Vector3f lower = mean_of(low), upper = mean_of(high);
  world.edit(plan_cut(world.solver(), testing::cut_at(5e-3F, -0.01F, 0.02F)).edit);
  world.step(kDt);
  world.set_forces(high, [&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
    return static_cast<float>(world.tissue().masses()[v]) * Eigen::Vector3f(0, 0, 4);
  });
  world.set_gravity(high, {3, 0, 0});
  const std::vector<Eigen::Vector3f> forces = world.solver().forces();
  for (Index v = 0; v < world.tissue().vertex_count(); ++v) {
    const bool is_pushed = world.tissue().body_of_vertex(v) == world.body_in_tissue(high) &&
                           world.tissue().has_tissue(v);
    REQUIRE((forces[v].z() > 0) == is_pushed);
  }
  for (int step = 0; step < 10; ++step) {
    REQUIRE(world.step(kDt).ok());
  }
  const Eigen::Vector3f way = mean_of(high) - upper;
  CHECK(way.z() == testing::Approx(way.x() * 4 / 3).epsilon(0.02));
  // a t^2 / 2 with a drag of 20/s: (t - (1 - exp(-20 t)) / 20) / 20
  CHECK(way.x() == testing::Approx(3 * (0.1 - (1 - std::exp(-2.0)) / 20) / 20).epsilon(0.15));
  CHECK((mean_of(low) - lower).norm() < 0.02F * way.norm());

  world.clear_forces();
  CHECK(world.solver().forces().empty());
  world.set_gravity({0, 0, -1});
  CHECK(world.solver().gravity(1) == Eigen::Vector3f(0, 0, -1));
  check_refused([&] { world.set_gravity(BodyId(7), {0, 0, 0}); }, "body 7");
  check_refused(
      [&] {
        world.set_forces(high, [](Index, const Eigen::Vector3f&) {
          return Eigen::Vector3f(std::nanf(""), 0, 0);
        });
      },
      "must be finite");
  CHECK(world.solver().forces().empty());
}

}  // namespace pbdsurg
