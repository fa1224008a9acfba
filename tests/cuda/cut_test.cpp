// SPDX-License-Identifier: Apache-2.0
// Cuts of what rows of vertices move: a device follows them row by row.
#include <array>
#include <cstdint>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/device_strategies.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

constexpr float kTimeStep = 1e-3F;  // s

Scene make_plate(float damping) {
  const TetMesh mesh = testing::make_box({12, 9, 2}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("plate", mesh, {.model = ElasticModel::neo_hookean, .damping = damping});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  return scene;
}

/// A solver on a device and one that is serial, to which the same is done.
struct Pair {
  Pair(const Scene& scene, SolverOptions options, DeviceStrategy strategy)
      : serial(scene, with(options, executor::serial(), DeviceStrategy::automatic)),
        device(scene, with(options, cuda::device(), strategy)) {}

  static SolverOptions with(SolverOptions options, Executor executor, DeviceStrategy strategy) {
    options.executor = std::move(executor);
    options.device_strategy = strategy;
    options.math = MathMode::strict;
    return options;
  }

  template <class Act>
  void both(const Act& act) {
    act(serial);
    act(device);
  }

  void apply(const TopologyEdit& edit) {
    both([&](Solver& solver) { solver.tissue().apply(edit); });
  }
  void undo() {
    both([](Solver& solver) { solver.tissue().undo(); });
  }

  void step_and_compare() {
    both([](Solver& solver) { solver.step(kTimeStep); });
    compare();
  }

  void compare() {
    for (Index copy = 0; copy < serial.options().copies; ++copy) {
      INFO("copy " << copy);
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
    }
  }

  Solver serial, device;
};

}  // namespace

// Would catch rows, lanes, tiles or records that a cut or its undo changes and nobody sends; what
// moves to larger arrays and is lost; a graph that goes on with what was before; and one copy's
// rows in another's place.
TEST_CASE("cuda cuts: many cuts and their undo have the serial bits", "[device]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const auto strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  const float damping = GENERATE(0.0F, 1e-3F);
  const auto copies = GENERATE(1, 3);
  const Index spare = GENERATE(0, 300);
  const auto correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  if (method == SolverMethod::explicit_steps &&
      (damping > 0 || correction == CoarseCorrection::on)) {
    return;  // has none
  }
  SolverOptions options{
      .method = method, .damping = 1, .coarse_correction = correction, .copies = copies};
  if (method == SolverMethod::vertex_block) {
    options.substeps = 2;
    options.iterations = 2;
  }
  options.spare = {spare, 6 * spare, 8 * spare, 0};
  Pair pair(make_plate(damping), options, strategy);
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : pair.serial.positions()) {
    velocities.push_back(Eigen::Vector3f(0.3F, -0.4F, 0.5F).cross(x));
  }
  pair.both([&](Solver& solver) { solver.write_velocities(velocities, copies - 1); });
  for (std::uint64_t round = 0; round < 60; ++round) {
    INFO(pair.device.backend_name() << ", damping " << damping << ", copies " << copies
                                    << ", spare " << spare << ", round " << round);
    pair.apply(testing::small_cut(pair.serial, round));
    if (round % 7 == 3) {  // another before the next step
      pair.apply({.remove_tets = {[&] {
                    Index tet = static_cast<Index>(random_bits(5, round) % 400);
                    while (!pair.serial.tissue().is_tet_alive(tet)) {
                      ++tet;
                    }
                    return tet;
                  }()}});
    }
    if (round % 5 == 4) {  // as if it had not been
      pair.undo();
    }
    pair.step_and_compare();
    if (round % 5 == 1) {
      pair.undo();
      pair.step_and_compare();
    }
  }
}

// Would catch a step that feels a cut which comes while it runs, and rows whose place edits within
// the same step change again.
TEST_CASE("cuda cuts: those that come while a step runs have the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  const float damping = GENERATE(0.0F, 1e-3F);
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 2,
                        .coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on)};
  Pair pair(make_plate(damping), options, strategy);
  for (std::uint64_t round = 0; round < 40; round += 2) {
    INFO(pair.device.backend_name() << ", damping " << damping << ", round " << round);
    pair.both([](Solver& solver) { solver.start_step(kTimeStep); });
    pair.apply(testing::small_cut(pair.serial, round));
    if (round % 3 == 0) {
      pair.undo();
    }
    pair.apply(testing::small_cut(pair.serial, round + 1));
    pair.both([](Solver& solver) { solver.finish_step(); });
    pair.step_and_compare();
  }
}

// Would catch what tools hold that goes by a block's index of before.
TEST_CASE("cuda cuts: tools at cut tissue have the serial bits", "[device]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  SolverOptions options{.method = method, .damping = 1, .copies = 2};
  if (method == SolverMethod::vertex_block) {
    options.substeps = 2;
    options.iterations = 2;
    options.coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  }
  Pair pair(make_plate(0), options, strategy);
  const Capsule ball{{0.03F, 0.02F, 0.012F}, {0.03F, 0.02F, 0.012F}, 0.006F};
  pair.both([&](Solver& solver) {
    solver.add_tool({&ball, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver.grasp(solver.add_tool({}, ToolPose::Identity()), std::array<Index, 2>{200, 230}, 1e-4F);
  });
  for (std::uint64_t round = 0; round < 40; ++round) {
    INFO(pair.device.backend_name() << ", round " << round);
    pair.apply(testing::small_cut(pair.serial, round));
    pair.step_and_compare();
    for (const Index tool : {0, 1}) {
      REQUIRE(pair.device.tool_force(ToolId{tool}) == pair.serial.tool_force(ToolId{tool}));
    }
    if (round % 3 == 2) {
      pair.undo();
      pair.step_and_compare();
    }
  }
}

}  // namespace pbdsurg
