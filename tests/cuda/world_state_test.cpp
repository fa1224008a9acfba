// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/world/world_state.h"

#include "pbdsurg/cuda/device.h"

#include "tests/support/catch.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {

using testing::at;
using testing::SlabWorld;

// Would catch what a state leaves on the device: rows and colours of edited tissue, motion, heat,
// what a tool holds, forces and gravity.
TEST_CASE("cuda world state: a world goes on as the one that was saved, to the bit", "[device]") {
  const SolverMethod method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  SlabWorld slabs(SolverOptions{.method = method, .damping = 20, .executor = cuda::device()});
  World& world = slabs.world;
  world.record();
  const auto pull = [&](World& each, float height) {
    each.move(slabs.grasper, at({6e-3F, 6e-3F, height}));
    return each.step(testing::kDt);
  };
  REQUIRE(world.grasp_near(slabs.grasper, slabs.upper, 5e-3F, 1e-4F).size() > 4);
  slabs.burn();
  world.set_gravity(slabs.upper, {0, 0, 1});
  world.set_forces(slabs.lower,
                   [](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f { return 1e-4F * x; });
  Index removed = 0;
  for (int step = 0; step < 60; ++step) {
    removed += pull(world, 11e-3F + 5e-5F * static_cast<float>(step)).removed_tets;
  }
  REQUIRE(removed > 2);
  world.energise(slabs.burner, off_settings());
  pull(world, 14e-3F);
  const WorldState state = world.save();
  World other(state);
  CHECK(slabs.hash() == other.solver().state_hash());
  Index parted = 0;
  for (int step = 0; step < 40; ++step) {
    const float height = 14e-3F + 1e-4F * static_cast<float>(step);
    parted += pull(world, height).removed_links;
    pull(other, height);
    REQUIRE(slabs.hash() == other.solver().state_hash());
  }
  CHECK(parted > 0);
  CHECK(world.force(slabs.grasper) == other.force(slabs.grasper));
  World again(state);  // though the world went on
  for (int step = 0; step < 40; ++step) {
    pull(again, 14e-3F + 1e-4F * static_cast<float>(step));
  }
  CHECK(slabs.hash() == again.solver().state_hash());
}

}  // namespace pbdsurg
