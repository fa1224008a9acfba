// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
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

namespace {

// A slab between two jaws that press, on another body.
struct SqueezedSlab {
  World world{};
  ToolId upper, lower, gripper;
  Grip grip{.clamp_force = 2};

  SqueezedSlab() {
    constexpr float kHalf = 2e-3F, kTop = 2 * static_cast<float>(testing::kEdge);
    const BodyId slab = world.add_body("slab", testing::slab(0, {8, 4, 2}), tissues::liver());
    const BodyId other = world.add_body("other", testing::slab(-4.4e-3, {4, 4, 2}), tissues::fat());
    world.fix(slab, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
    world.fix(other, [](const Eigen::Vector3d&) { return true; });
    world.set_gravity({0, 0, -9.81F});
    world.set_contact(slab, other, {0.5e-3F, 0.2F});
    const std::vector<Capsule> jaw{{{10e-3F, 4e-3F, 0}, {14e-3F, 4e-3F, 0}, kHalf}};
    upper = world.add_tool(jaw, at(kTop + kHalf), {.friction = 0.3F});
    lower = world.add_tool(jaw, at(-kHalf), {.friction = 0.3F});
    gripper = world.add_tool({}, ToolPose(Eigen::Translation3f(12e-3F, 4e-3F, kTop / 2)));
    world.record();
    grip.pad.half_width = 5e-3F;
    for (int i = 1; i <= 60; ++i) {
      const float in = 1.4e-3F * static_cast<float>(i) / 60;
      world.move(upper, at(kTop + kHalf - in));
      world.move(lower, at(-kHalf + in));
      REQUIRE(world.step(kDt).ok());
    }
  }

  static ToolPose at(float z) { return ToolPose(Eigen::Translation3f(0, 0, z)); }

  // What can be told of contacts, and what jaws would take.
  void check_same(World& other) {
    const auto numbers_of = [&](World& each) {
      std::vector<float> numbers;
      const auto add = [&](const auto& values) {
        numbers.insert(numbers.end(), values.begin(), values.end());
      };
      for (const BodyContact& contact : each.solver().body_contacts()) {
        add(contact.weights);
        add(contact.point);
        add(contact.force);
        numbers.push_back(contact.distance);
      }
      for (const ToolId jaw : {upper, lower}) {
        for (const ToolContact& contact : each.solver().tool_contacts(jaw)) {
          add(contact.weights);
          add(contact.point);
          add(contact.normal);
          add(contact.force);
        }
      }
      return numbers;
    };
    CHECK(numbers_of(other) == numbers_of(world));
    CHECK(other.solver().body_contacts().size() == world.solver().body_contacts().size());
    CHECK(!world.solver().body_contacts().empty());
  }
};

}  // namespace

// Would catch jaws that close on nothing where a world was loaded or compacted while they press.
TEST_CASE("world contact: a world that was loaded or compacted knows what touches at once") {
  SqueezedSlab squeezed;
  World& world = squeezed.world;
  const std::array jaws{squeezed.upper, squeezed.lower};
  const testing::TemporaryFolder folder;
  const WorldState state = world.save();
  write_world(folder / "a.world", state);
  World loaded(state), read = read_world(folder / "a.world");
  World again(loaded.save());  // from one that has not stepped
  for (World* const each : {&loaded, &read, &again}) {
    squeezed.check_same(*each);
  }
  World compacted(state);
  compacted.compact();
  CHECK(compacted.solver().tool_contacts(jaws[0]).size() ==
        world.solver().tool_contacts(jaws[0]).size());
  CHECK(compacted.solver().body_contacts().size() == world.solver().body_contacts().size());

  const std::size_t held = world.close_jaws(squeezed.gripper, jaws, squeezed.grip);
  CHECK(held > 3);
  for (World* const each : {&loaded, &read, &again, &compacted}) {
    CHECK(each->close_jaws(squeezed.gripper, jaws, squeezed.grip) == held);
  }
  for (int i = 0; i < 10; ++i) {
    for (World* const each : {&world, &loaded, &read}) {
      each->step(kDt);
    }
    REQUIRE(loaded.solver().state_hash() == world.solver().state_hash());
    REQUIRE(read.solver().state_hash() == world.solver().state_hash());
  }
  world.solver().restore(world.solver().snapshot());
  CHECK(world.solver().tool_contacts(jaws[0]).empty());
}

// Would catch contacts of vertices that are gone, and those of a tool that was taken out.
TEST_CASE("world contact: what is gone is told of no more") {
  SqueezedSlab squeezed;
  World& world = squeezed.world;
  std::vector<Index> touched;
  for (const ToolContact& contact : world.solver().tool_contacts(squeezed.upper)) {
    touched.insert(touched.end(), contact.vertices.begin(), contact.vertices.end());
  }
  TopologyEdit edit;  // all tetrahedra at what the upper jaw touches
  const Tissue& tissue = world.solver().tissue();
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (std::ranges::any_of(tissue.tets()[t],
                            [&](Index v) { return std::ranges::count(touched, v) > 0; })) {
      edit.remove_tets.push_back(t);
    }
  }
  World other(world.save());
  other.solver().tissue().apply(edit);
  const std::size_t told = other.solver().tool_contacts(squeezed.upper).size();
  other.compact();
  CHECK(other.solver().tool_contacts(squeezed.upper).size() < told);
  for (const ToolContact& contact : other.solver().tool_contacts(squeezed.upper)) {
    for (int k = 0; k < 3 && contact.vertices[k] != kInvalidIndex; ++k) {
      CHECK(other.solver().tissue().has_tissue(contact.vertices[k]));
    }
  }
  World third(world.save());
  third.remove_tool(squeezed.lower);
  CHECK_THROWS_AS(third.solver().tool_contacts(squeezed.lower), InvalidArgument);
  CHECK(!third.solver().tool_contacts(squeezed.upper).empty());
  third.step(kDt);
  CHECK(!third.solver().tool_contacts(squeezed.upper).empty());
}

}  // namespace pbdsurg
