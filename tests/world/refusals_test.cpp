// SPDX-License-Identifier: Apache-2.0
// Calls that a world refuses.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>

#include "pbdsurg/world/world.h"

#include "tests/support/bad_ids.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::check_refused;
using testing::kDt;
using testing::SlabWorld;

}  // namespace

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
    check_refused([&] { world.grasp_between(slabs.grasper, body, 1e-3F, {}); }, bodies(id));
    check_refused([&] { world.add_cautery(slabs.hook, {body}); }, bodies(id));
    const ToolId tool(id);
    check_refused([&] { world.move(tool, ToolPose::Identity()); }, tools(id));
    check_refused([&] { world.grasp(tool, {}); }, tools(id));
    check_refused([&] { (void)world.grasp_near(tool, slabs.lower, 1e-3F); }, tools(id));
    check_refused([&] { world.grasp(tool, {}, Grip{}); }, tools(id));
    check_refused([&] { world.grasp_between(tool, slabs.lower, 1e-3F, {}); }, tools(id));
    check_refused([&] { world.close_jaws(tool, {slabs.hook, slabs.hook}, {}); }, tools(id));
    check_refused([&] { world.set_clamp_force(tool, 1); }, tools(id));
    check_refused([&] { (void)world.grip(tool); }, tools(id));
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
      [&] { gone.grasp(tool, {}, Grip{}); },
      [&] { gone.grasp_between(tool, body, 1, {}); },
      [&] {
        gone.close_jaws(tool, {tool, tool}, {});
      },
      [&] { gone.set_clamp_force(tool, 1); },
      [&] { (void)gone.grip(tool); },
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
      [&] { gone.record(); },
      [&] { (void)gone.save(); },
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
  CHECK(world.step(kDt).ok());
}

// Would catch a call that is refused and yet ends the time in which the scene is made.
TEST_CASE("world: a refused force or gravity leaves the scene open", "[unit]") {
  World world;
  const BodyId body = world.add_body("body", testing::slab(0, {1, 1, 1}), tissues::fat());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  check_refused([&] { world.set_gravity(body, {0, nan, 0}); }, "gravity is");
  const std::array<Index, 1> vertex{0}, beyond{8};
  const std::array<Eigen::Vector3f, 1> force{{{1, 0, 0}}}, odd{{{nan, 0, 0}}};
  check_refused([&] { world.set_forces(vertex, odd); }, "the force at vertex 0");
  check_refused([&] { world.set_forces(beyond, force); }, "vertex 8");
  world.fix(body, {0});
  world.set_forces(vertex, force);
  CHECK(world.solver().forces()[0] == force[0]);
}

// Would catch a table by body that stays behind where no vertex has come yet.
TEST_CASE("world: a body without vertices has its gravity, and those that come have theirs",
          "[unit]") {
  World world(SolverOptions{.damping = 20});
  const BodyId empty = world.add_body("empty", TetMesh({}, {}), tissues::fat());
  world.set_gravity({0, 0, -9.81F});
  world.set_gravity(empty, {1, 0, 0});
  const BodyId body = world.add_body("body", testing::slab(0, {1, 1, 1}), tissues::fat());
  REQUIRE(world.step(kDt).ok());
  CHECK(world.solver().gravity(world.body_in_tissue(empty)) == Eigen::Vector3f(1, 0, 0));
  CHECK(world.solver().gravity(world.body_in_tissue(body)) == Eigen::Vector3f(0, 0, -9.81F));
  const Eigen::Vector3f speed = world.solver().velocities()[0];
  CHECK(std::abs(speed.x()) < 1e-3F);
  CHECK(speed.z() < -0.9F * 9.81F * static_cast<float>(kDt));
}

}  // namespace pbdsurg
