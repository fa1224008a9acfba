// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/world/world.h"
#include "pbdsurg/world/world_file.h"

#include "tests/support/catch.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/slab_world.h"

namespace pbdsurg {
namespace {

using testing::kDt;

}  // namespace

// Would catch a saved world whose bodies pass through each other, or meet anew.
TEST_CASE("world contact: a saved world goes on to the bit where bodies lie on each other") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  World world(SolverOptions{.method = method, .damping = 5});
  const BodyId lower = world.add_body("lower", testing::slab(0), tissues::fat());
  const BodyId upper = world.add_body("upper", testing::slab(4.6e-3, {4, 4, 2}), tissues::fat());
  // across the upper one's sharp edges, with no vertex near
  constexpr double kOver = 10 * testing::kEdge, kHeight = 4.6e-3 + 2 * testing::kEdge + 0.3e-3;
  const BodyId strip =
      world.add_sheet("strip",
                      std::vector<Eigen::Vector3d>{{-kOver, testing::kEdge, kHeight},
                                                   {2 * kOver, testing::kEdge, kHeight},
                                                   {2 * kOver, 3 * testing::kEdge, kHeight},
                                                   {-kOver, 3 * testing::kEdge, kHeight}},
                      std::vector<Triangle>{{0, 1, 2}, {0, 2, 3}}, 1e-3F, tissues::fat());
  world.fix(lower, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * testing::kEdge; });
  world.set_gravity({0, 0, -9.81F});
  world.set_contact(upper, lower, {0.4e-3F, 0.2F});
  world.set_contact(strip, upper, {0.4e-3F, 0.2F});
  world.record();
  for (int i = 0; i < 15; ++i) {
    REQUIRE(world.step(kDt).ok());
  }
  const std::vector<BodyContact> contacts = world.solver().body_contacts();
  const auto pushes = [&](int corners) {
    return std::ranges::any_of(contacts, [&](const BodyContact& contact) {
      return contact.first_count == corners && contact.force.norm() > 0;
    });
  };
  REQUIRE(pushes(1));
  REQUIRE(pushes(2));

  const testing::TemporaryFolder folder;
  const WorldState state = world.save();
  write_world(folder / "a.world", state);
  World other(state), read = read_world(folder / "a.world");
  for (int i = 0; i < 10; ++i) {
    for (World* const each : {&world, &other, &read}) {
      each->step(kDt);
    }
    REQUIRE(other.solver().state_hash() == world.solver().state_hash());
    REQUIRE(read.solver().state_hash() == world.solver().state_hash());
  }
  world.clear_contact(lower, upper);
  world.clear_contact(strip, upper);
  for (int i = 0; i < 10; ++i) {
    world.step(kDt);
    other.step(kDt);
  }
  CHECK(world.solver().body_contacts().empty());
  CHECK(!other.solver().body_contacts().empty());
  CHECK_THROWS_AS(world.set_contact(lower, BodyId(7), {1e-3F, 0}), InvalidArgument);
}

}  // namespace pbdsurg
