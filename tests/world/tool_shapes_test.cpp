// SPDX-License-Identifier: Apache-2.0
// Joints, springs and removal of tools, in worlds and their files.
#include <array>
#include <utility>
#include <vector>

#include "pbdsurg/world/world_file.h"

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::at;
using testing::ContainsSubstring;
using testing::kDt;
using testing::SlabWorld;
using testing::TemporaryFolder;

// A world with jaws that close on the upper slab, a ball on a spring that presses the lower one,
// and a tool that has gone.
struct ShapesWorld {
  explicit ShapesWorld(const SolverOptions& options) : slabs(options) {
    World& world = slabs.world;
    const ToolSurface surface{ContactFeatures::all, 0.2F};
    gone = world.add_tool({{{0, 0, 0}, {0, 0, 0}, 1e-3F}}, at(testing::kTop));
    const float low = 7e-3F - 1e-3F, high = 11e-3F + 1e-3F;
    jaws = world.add_tool({{{0, 6e-3F, low}, {12e-3F, 6e-3F, low}, 1e-3F},
                           {{0, 6e-3F, high}, {12e-3F, 6e-3F, high}, 1e-3F}},
                          ToolPose::Identity(), surface,
                          std::array{ToolJoint{{-0.05F, 0, 9e-3F}, {0, 1, 0}, 0, 1},
                                     ToolJoint{{-0.05F, 0, 9e-3F}, {0, 1, 0}, 1, 1}});
    ball = world.add_tool({{{0, 0, 0}, {0, 0, 0}, 2e-3F}}, at({2e-3F, 6e-3F, 6.2e-3F}), surface);
    world.couple(ball, {300});
    world.step(kDt);
    world.remove_tool(gone);
  }

  void step(World& world, int step) const {
    const float share = static_cast<float>(step);
    world.set_joint(jaws, 0, -2e-4F * share);
    world.set_joint(jaws, 1, 2e-4F * share);
    world.replica(ReplicaId(1)).set_joint(jaws, 1, 1e-4F * share);
    world.move(ball, at({2e-3F, 6e-3F, 6.2e-3F - 1e-4F * share}));
    REQUIRE(world.step(kDt).ok());
  }

  SlabWorld slabs;
  ToolId jaws, ball, gone;
};

}  // namespace

// Would catch angles, springs, displacements or removals that a file or a saved world forgets.
TEST_CASE("tool shapes: a world in a file goes on with them, to the bit", "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  ShapesWorld shapes({.method = method, .damping = 20, .copies = 2});
  World& world = shapes.slabs.world;
  world.record();
  for (int i = 1; i <= 20; ++i) {
    shapes.step(world, i);
  }
  const auto tip = [&](World& of) {
    return Eigen::Vector3f(of.solver().tool_pose(shapes.ball).translation());
  };
  REQUIRE(world.force(shapes.ball).z() > 0);
  REQUIRE(tip(world).z() > world.pose(shapes.ball).translation().z());
  REQUIRE(!world.solver().tool_contacts(shapes.jaws).empty());
  const TemporaryFolder folder;
  write_world(folder / "a.world", world.save());
  World other = read_world(folder / "a.world");

  CHECK(other.joint_angle(shapes.jaws, 0) == world.joint_angle(shapes.jaws, 0));
  CHECK(other.solver().joint_angle(shapes.jaws, 1, 1) == 20 * 1e-4F);
  CHECK(tip(other) == tip(world));
  CHECK_THROWS_WITH(other.release(shapes.gone), ContainsSubstring("tool 2 was removed"));
  CHECK(other.add_tool({}, ToolPose::Identity()) != shapes.gone);
  world.add_tool({}, ToolPose::Identity());
  for (int i = 21; i <= 30; ++i) {
    shapes.step(world, i);
    shapes.step(other, i);
    for (const Index copy : {0, 1}) {
      REQUIRE(other.solver().state_hash(copy) == world.solver().state_hash(copy));
    }
    CHECK(other.force(shapes.ball) == world.force(shapes.ball));
    CHECK(tip(other) == tip(world));
  }
}

// Would catch a cautery that heats where its tool is to be: within the slab, which a soft spring
// keeps it out of.
TEST_CASE("tool shapes: a cautery heats where its tool is", "[unit]") {
  constexpr float kRadius = 2e-3F, kSurface = 2 * static_cast<float>(testing::kEdge);
  const bool is_below = GENERATE(false, true);  // the electrode, on the ball
  World world({.damping = 20});
  const BodyId slab = world.add_body("slab", testing::slab(0), tissues::fat());
  world.fix(slab, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * testing::kEdge; });
  world.set_gravity({0, 0, 0});
  const auto above = [](float height) { return at({6e-3F, 6e-3F, kSurface + kRadius + height}); };
  const ToolId ball = world.add_tool({{{0, 0, 0}, {0, 0, 0}, kRadius}}, above(1e-3F));
  world.couple(ball, {.stiffness = 1});
  const Eigen::Vector3f tip(0, 0, is_below ? -kRadius : kRadius);
  const CauteryId burner = world.add_cautery(ball, {slab}, {}, {tip, tip});
  world.energise(burner, cut_settings(10));
  Index touched = 0;
  for (int i = 0; i <= 50; ++i) {
    world.move(ball, above(1e-3F - 1e-4F * static_cast<float>(i)));
    touched += world.step(kDt).cauteries.front().contact_vertices;
  }
  CHECK(world.solver().tool_displacement(ball).z() > 3e-3F);
  CHECK((touched > 0) == is_below);
}

// Would catch a heat that looks for a tool that is not there.
TEST_CASE("tool shapes: a tool with a cautery stays", "[errors]") {
  SlabWorld slabs;
  CHECK_THROWS_WITH(slabs.world.remove_tool(slabs.hook),
                    ContainsSubstring("tool 0 has cautery 0, so it cannot be removed"));
  slabs.world.remove_tool(slabs.grasper);
  CHECK_THROWS_WITH(slabs.world.remove_tool(slabs.grasper), ContainsSubstring("was removed"));
  CHECK_THROWS_WITH(slabs.world.add_cautery(slabs.grasper, {}), ContainsSubstring("was removed"));
  CHECK(slabs.world.step(kDt).ok());
}

}  // namespace pbdsurg
