// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/edits_within_steps.h"
#include "tests/support/eventful_program.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::equal;
using testing::fake_device_of;
using testing::FakeDevice;
using testing::kEventfulEdge;
using testing::kEventfulTimeStep;
using testing::Variant;

Scene make_named_block(const std::string& name, Index cells) {
  const TetMesh mesh = testing::make_box({cells, cells, cells}, kEventfulEdge, 0.1);
  Scene scene;
  scene.add_body(name, mesh, elastic_material(mesh, 1000, 20e3));
  return scene;
}

Index some_edge(const Solver& solver, std::uint64_t seed) {
  auto edge = static_cast<Index>(random_bits(seed, 7) % solver.tissue().edges().size());
  while (!solver.tissue().is_edge_alive(edge)) {
    edge = (edge + 1) % static_cast<Index>(solver.tissue().edges().size());
  }
  return edge;
}

// A serial solver and one on a device, to which the same is done.
struct Twins {
  Twins(const Scene& scene, SolverOptions options)
      : serial(scene, with(options, executor::serial())),
        device(scene, with(options, testing::fake_device())) {}

  static SolverOptions with(SolverOptions options, const Executor& executor) {
    options.executor = executor;
    return options;
  }

  template <class Act>
  void both(Act act) {
    act(serial);
    act(device);
  }

  void require_same_state(Index copy) {
    REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
    REQUIRE(device.snapshot(copy).falling == serial.snapshot(copy).falling);
    REQUIRE(device.snapshot(copy).roundings == serial.snapshot(copy).roundings);
  }

  void require_same_positions(std::span<const Index> vertices, Index copy) {
    std::vector<Eigen::Vector3f> expected(vertices.size()), read(vertices.size());
    serial.read_positions(vertices, expected, copy);
    device.read_positions(vertices, read, copy);
    REQUIRE(read == expected);
  }

  Solver serial, device;
};

// Applies random edits and takes the last back, on two solvers alike.
class RandomEdits {
 public:
  explicit RandomEdits(std::uint64_t seed) : seed_(seed) {}

  void act(Twins& twins, std::uint64_t round) {
    const std::uint64_t seed = random_bits(seed_, round);
    if (seed % 4 == 3 && can_undo_) {
      twins.both([&](Solver& solver) { solver.tissue().undo(); });
      can_undo_ = false;
      return;
    }
    const TopologyEdit edit = random_edit(twins.serial, seed);
    twins.both([&](Solver& solver) { solver.tissue().apply(edit); });
    can_undo_ = true;
  }

 private:
  static TopologyEdit random_edit(const Solver& solver, std::uint64_t seed) {
    const Index newest = solver.vertex_count() - 1;
    switch (seed / 4 % 6) {
      case 0:  // around a vertex that may be new
        return around(solver, solver.tissue().has_tissue(newest) ? newest : Index{0});
      case 1:
        return testing::split_edge(solver, some_edge(solver, seed), 0.25F);
      case 2: {  // at a new vertex, where there is one
        const Index last = static_cast<Index>(solver.tissue().edges().size()) - 1;
        return solver.tissue().is_edge_alive(last) ? testing::split_edge(solver, last, 0.5F)
                                                   : TopologyEdit{};
      }
      case 3:
        return solver.tissue().has_tissue(newest) ? testing::part_vertex(solver, newest, seed)
                                                  : TopologyEdit{};
      case 4:
        return {.new_bodies = make_named_block("guest " + std::to_string(seed), 1)};
      default: {
        const testing::Surroundings some = testing::some_surroundings(solver, seed);
        return {.remove_tets = some.tets};
      }
    }
  }

  static TopologyEdit around(const Solver& solver, Index vertex) {
    TopologyEdit edit;
    for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
      if (solver.tissue().is_tet_alive(t) &&
          testing::has_corner(solver.tissue().tets()[t], vertex)) {
        edit.remove_tets.push_back(t);
      }
    }
    return edit;
  }

  std::uint64_t seed_;
  bool can_undo_ = false;  // the last was not taken back
};

}  // namespace

// Would catch a new vertex whose motion comes from what the host no longer knows, one that is read
// from a device which has not heard of it or knows another at its place, and an old one that is
// lost on the way: between two steps there may be several edits and undos, reads and writes.
TEST_CASE("device growth: new vertices have the serial bits through all that comes between steps",
          "[equivalence]") {
  const Variant variant = GENERATE(
      Variant{}, Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
      Variant{.method = SolverMethod::vertex_block, .damping = 0.01F});
  const std::uint64_t seed = GENERATE(1, 2, 3);
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.copies = 3;
  options.spare.vertices = 20;
  Twins twins(scene, options);
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.018F, 0.006F);
  const std::vector<Eigen::Vector3f> drift(scene.positions().size(), {0.02F, -0.01F, 0});
  twins.both([&](Solver& solver) {
    solver.add_tool({&capsule, 1}, pose, {ContactFeatures::vertices});
    solver.add_tool({}, ToolPose::Identity());
    solver.write_velocities(drift, 1);
  });
  RandomEdits edits(seed);
  for (std::uint64_t round = 0; round < 80; ++round) {
    INFO("seed " << seed << ", round " << round);
    edits.act(twins, round);
    const std::uint64_t choice = random_bits(seed, round, 1);
    const auto copy = static_cast<Index>(choice % 3);
    const Index newest = twins.serial.vertex_count() - 1;
    const std::array<Index, 4> some{newest, 3, newest - 1, newest};
    switch (choice / 4 % 10) {
      case 0:
        twins.require_same_state(copy);
        break;
      case 1:
        twins.require_same_positions(some, copy);
        break;
      case 2:
        twins.both([&](Solver& solver) {
          std::vector<Eigen::Vector3f> positions = solver.positions(copy);
          positions[3].x() += 1e-4F;
          solver.write_positions(positions, copy);
        });
        break;
      case 3:
        twins.both([&](Solver& solver) {
          solver.write_velocities(solver.velocities((copy + 1) % 3), copy);
        });
        break;
      case 4:
        twins.both([&](Solver& solver) { solver.restore(solver.snapshot(copy), (copy + 1) % 3); });
        break;
      case 5:
        twins.both([&](Solver& solver) {
          solver.release(ToolId{1}, copy);
          if (solver.tissue().has_tissue(newest)) {
            solver.grasp(ToolId{1}, std::array{newest}, 1e-3F, copy);
          }
        });
        break;
      case 6:  // not the new ones: an undo of the edit that brought them would be refused
        twins.both([&](Solver& solver) { solver.watch(std::array<Index, 2>{3, 40}); });
        break;
      default: {
        const StepReport expected = twins.serial.step(kEventfulTimeStep);
        REQUIRE(equal(twins.device.step(kEventfulTimeStep), expected));
        REQUIRE(expected.non_finite_vertices == 0);
        for (Index i = 0; i < 3; ++i) {
          REQUIRE(std::ranges::equal(twins.device.watched_positions(i),
                                     twins.serial.watched_positions(i)));
          REQUIRE(twins.device.tool_force(ToolId{0}, i) == twins.serial.tool_force(ToolId{0}, i));
          REQUIRE(twins.device.tool_force(ToolId{1}, i) == twins.serial.tool_force(ToolId{1}, i));
        }
        break;
      }
    }
  }
  for (Index copy = 0; copy < 3; ++copy) {
    twins.require_same_state(copy);
  }
}

// Would catch an edit that takes the state of all vertices to the host and back, or an undo.
TEST_CASE("device growth: an edit reads the ends of new vertices, and no others", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(
      make_named_block("block", 3),
      testing::small_steps({.method = method, .copies = 2, .executor = testing::fake_device()}));
  solver.step(kEventfulTimeStep);
  const FakeDevice& device = fake_device_of(solver);
  const SolverData& data = testing::inspect(solver);
  const auto is_untouched = [&] {
    return device.fetch_count == 0 && !data.copy(0).is_state_current &&
           data.changes.state == std::vector<bool>{false, false};
  };
  TopologyEdit edit = testing::split_edge(solver, some_edge(solver, 1), 0.5F);
  solver.tissue().apply(edit);
  CHECK(device.asked_count == 2);
  solver.tissue().undo();
  solver.step(kEventfulTimeStep);
  solver.tissue().apply({.new_bodies = make_named_block("guest", 1)});
  CHECK(device.asked_count == 2);
  solver.step(kEventfulTimeStep);
  edit = {.remove_tets = testing::some_surroundings(solver, 1).tets};
  const std::size_t emptied = solver.tissue().apply(edit).emptied_vertices.size();
  solver.step(kEventfulTimeStep);
  solver.tissue().undo();
  CHECK(device.asked_count == 2 + emptied);
  CHECK(is_untouched());
  CHECK_FALSE(data.changes.tools);

  const Index last = solver.vertex_count() - 1;  // known, and stays so without a step
  solver.tissue().apply(testing::split_edge(solver, some_edge(solver, 2), 0.5F));
  std::array<Eigen::Vector3f, 2> read;
  solver.read_positions(std::array{last, last + 1}, read);
  CHECK(is_untouched());
  CHECK(read == std::array{solver.positions()[last], solver.positions()[last + 1]});
  CHECK(device.fetch_count == 1);
}

// Would catch room that is not used, or made anew at every edit.
TEST_CASE("device growth: vertices outgrow their room once in a while", "[unit]") {
  const Scene scene = make_named_block("block", 3);
  const SolverOptions options = testing::small_steps({.copies = 2, .spare = {.vertices = 30}});
  Twins twins(scene, options);
  twins.both([](Solver& solver) { solver.step(kEventfulTimeStep); });
  const auto add = [&](int count) {
    for (int i = 0; i < count; ++i) {
      const TopologyEdit edit =
          testing::split_edge(twins.serial, some_edge(twins.serial, 100 + i), 0.5F);
      twins.both([&](Solver& solver) { solver.tissue().apply(edit); });
      if (i % 10 == 9) {
        twins.both([](Solver& solver) { solver.step(kEventfulTimeStep); });
        twins.require_same_state(1);
      }
    }
  };
  add(30);
  CHECK(fake_device_of(twins.device).remade_count == 0);
  add(10);
  CHECK(fake_device_of(twins.device).remade_count == 1);
  add(200);
  CHECK(fake_device_of(twins.device).remade_count == 1);
  twins.require_same_state(0);
}

}  // namespace pbdsurg
