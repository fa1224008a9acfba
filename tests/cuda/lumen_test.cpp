// SPDX-License-Identifier: Apache-2.0
// A lumen on a device: strict against the serial backend, fast against strict, and what is refused.
#include "pbdsurg/surgery/lumen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/compaction.h"

#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/lumen_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ball_scene;
using testing::ContainsSubstring;
using testing::kLumenStep;
using testing::kWater;
using testing::LumenSolver;
using testing::StrictPair;

const SolverOptions kProjections{
    .method = SolverMethod::projection, .substeps = 2, .iterations = 5, .damping = 5};

const SolverOptions kBlocks{
    .method = SolverMethod::vertex_block, .substeps = 2, .iterations = 5, .damping = 5};

Scene held_ball() {
  Scene ball = ball_scene();
  ball.set_gravity({0, -9.81F, 0});
  ball.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -0.022; });
  return ball;
}

/// A ball that nothing holds, with inner friction, and a second one beside it.
Scene free_balls() {
  Scene balls;
  const Material material{
      .density = 1000, .youngs_modulus = 10e3F, .poissons_ratio = 0.3F, .damping = 2e-3F};
  balls.add_body("ball", testing::hollow_ball(), material);
  const TetMesh& ball = testing::hollow_ball();
  std::vector<Eigen::Vector3d> beside(ball.positions().begin(), ball.positions().end());
  for (Eigen::Vector3d& x : beside) {
    x.x() += 2.2 * testing::kOuter;
  }
  balls.add_body("other", {beside, {ball.tets().begin(), ball.tets().end()}}, material);
  balls.set_gravity(Eigen::Vector3f::Zero());
  return balls;
}

/// Takes a belt of tissue away, so that halves are left.
TopologyEdit halve(const Tissue& tissue) {
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    double least = kInfinity, most = -kInfinity;
    for (const Index v : tissue.tets()[t]) {
      least = std::min(least, tissue.rest_positions()[v].y());
      most = std::max(most, tissue.rest_positions()[v].y());
    }
    if (least < 1e-3 && most > 1e-3) {
      edit.remove_tets.push_back(t);
    }
  }
  return edit;
}

/// Two strict solvers, each with lumens of its own in the ball.
struct LumenPair : StrictPair {
  LumenPair(const Scene& scene, const SolverOptions& options, DeviceStrategy strategy)
      : StrictPair(scene, options, strategy) {}

  void add(const LumenOptions& contents, Index body = 0) {
    std::array<std::shared_ptr<Lumen>, 2>& added = lumens.emplace_back();
    for (const std::size_t i : {0, 1}) {
      Solver& solver = i == 0 ? serial : device;
      added[i] = std::make_shared<Lumen>(solver.tissue(),
                                         find_cavities(solver.tissue(), body).at(0), contents);
      solver.add_constraints(added[i]);
    }
  }

  template <class Act>
  void fill(const Act& act) {
    for (const auto& each : lumens) {
      act(*each[0]);
      act(*each[1]);
    }
  }

  void run(int steps) {
    for (int i = 0; i < steps; ++i) {
      step_and_compare(kLumenStep);
      for (Index copy = 0; copy < serial.options().copies; ++copy) {
        for (const auto& [here, there] : lumens) {
          REQUIRE(there->state(copy).amount == here->state(copy).amount);
          REQUIRE(there->state(copy).pressure == here->state(copy).pressure);
        }
      }
    }
  }

  std::vector<std::array<std::shared_ptr<Lumen>, 2>> lumens;
};

}  // namespace

// Would catch volumes, gradients or yields that a device sums in another order, flows and states
// that it does not hear of, one copy's contents in another's place, walls of before an edit, and
// lumens in another order.
TEST_CASE("cuda lumen: strict has the serial bits, through flow, holes, undo and compaction",
          "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph);
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const bool is_gas = GENERATE(true, false);
  SolverOptions options = GENERATE(kProjections, kBlocks);
  INFO("gas " << is_gas << ", integration " << static_cast<int>(integration) << ", method "
              << static_cast<int>(options.method));
  options.copies = 2;
  options.integration = integration;
  LumenPair pair(held_ball(), options, strategy);
  pair.add(is_gas ? LumenOptions{} : kWater);
  pair.fill([](Lumen& lumen) { lumen.set_reservoir(1e-5F, 300); });
  pair.run(10);
  CHECK(pair.lumens[0][0]->pressure() > 1);
  pair.fill([](Lumen& lumen) {
    lumen.set_reservoir(0, 0);
    lumen.set_inflow(2e-6F);
    lumen.set_leak(1e-7F);
    lumen.set_state({lumen.state(1).amount, 50}, 1);
  });
  pair.run(4);
  pair.both([](Solver& solver) { solver.tissue().apply(testing::puncture(solver.tissue(), 1)); });
  REQUIRE(pair.lumens[0][0]->cavity().hole_count() > 0);
  pair.run(5);
  pair.both([](Solver& solver) { solver.tissue().undo(); });
  REQUIRE(pair.lumens[0][0]->cavity().hole_count() == 0);
  pair.run(3);
  pair.both([](Solver& solver) { solver.tissue().apply(testing::puncture(solver.tissue(), 1)); });
  pair.run(2);
  pair.both([](Solver& solver) {
    Compaction compaction(solver);
    compaction.build();
    static_cast<void>(compaction.finish(solver));
  });
  pair.run(3);
}

// Would catch a strategy that was chosen without a lumen and leaves it out, and one that stays in
// the way of it.
TEST_CASE("cuda lumen: one that comes later is stepped, and leaves again", "[device]") {
  LumenPair pair(held_ball(), GENERATE(kProjections, kBlocks), DeviceStrategy::automatic);
  pair.run(2);
  pair.add({});
  pair.add(kWater);  // of the same hollow
  pair.fill([](Lumen& lumen) { lumen.set_inflow(2e-6F); });
  pair.run(3);
  INFO(pair.device.backend_name());
  CHECK(pair.lumens[0][1]->pressure() != 0);
  pair.serial.remove_constraints(*pair.lumens[0][0]);
  pair.device.remove_constraints(*pair.lumens[0][1]);
  pair.lumens.erase(pair.lumens.begin());
  pair.run(3);
}

// Would catch, of vertex blocks: pieces that a device does not move together as walls join them,
// with surfaces and friction in between or without; a coarse correction that knows nothing of
// walls, or not the same; and ends of tools that nothing settles.
TEST_CASE("cuda lumen: free balls under tools have the serial bits, whole and halved", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph);
  SolverOptions options = kBlocks;
  options.copies = 2;  // tools move in the first alone
  options.coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  options.integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const bool has_tools = GENERATE(false, true);
  INFO("correction " << static_cast<int>(options.coarse_correction) << ", integration "
                     << static_cast<int>(options.integration) << ", tools " << has_tools);
  LumenPair pair(free_balls(), options, strategy);
  pair.add({});
  pair.add(kWater, 1);
  pair.fill([](Lumen& lumen) { lumen.set_reservoir(1e-4F, 300); });
  const auto pose_at = [](float height) {
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0, height, 0);
    return pose;
  };
  std::array<ToolId, 2> rods{}, balls{};
  if (has_tools) {
    pair.both([&](Solver& solver) {
      const std::size_t i = &solver == &pair.device ? 1 : 0;
      const Capsule along{{-30e-3F, 0, 0}, {90e-3F, 0, 0}, 2e-3F};
      rods[i] = solver.add_tool({&along, 1}, pose_at(29e-3F),
                                {.features = ContactFeatures::all, .friction = 0.3F});
      const Capsule below{{0, 0, 0}, {0, 0, 0}, 3e-3F};
      balls[i] = solver.add_tool({&below, 1}, pose_at(-30e-3F), {ContactFeatures::vertices});
    });
  }
  for (int i = 0; i < 8; ++i) {
    if (has_tools) {
      pair.both([&](Solver& solver) {
        const std::size_t at = &solver == &pair.device ? 1 : 0;
        solver.move_tool(rods[at], pose_at(29e-3F - 5e-4F * static_cast<float>(i)));
        solver.move_tool(balls[at], pose_at(-30e-3F + (i < 4 ? 5e-4F * static_cast<float>(i) : 0)));
      });
    }
    pair.run(1);
    if (has_tools) {
      CHECK(pair.device.tool_force(rods[1]) == pair.serial.tool_force(rods[0]));
    }
    if (i == 4) {
      pair.both([](Solver& solver) { solver.tissue().apply(halve(solver.tissue())); });
    }
  }
  CHECK(pair.lumens[0][0]->cavity().hole_count() > 0);
  CHECK(pair.lumens[0][0]->pressure() != 0);
}

// Would catch walls that a correction knows nothing of, and moves all the same; shared vertices
// that are guarded once, or for ever.
TEST_CASE("cuda lumen: more than a correction knows have the serial bits", "[device]") {
  SolverOptions options = kBlocks;
  options.coarse_correction = CoarseCorrection::on;
  Scene balls = free_balls();
  balls.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -0.015; });  // within, too
  LumenPair pair(balls, options, DeviceStrategy::graph);
  for (int i = 0; i < 14; ++i) {
    pair.add(i % 2 == 0 ? LumenOptions{} : kWater, i % 3 == 0 ? 1 : 0);
  }
  pair.fill([](Lumen& lumen) { lumen.set_reservoir(1e-5F, 100); });
  pair.run(4);
  CHECK(pair.lumens[13][0]->pressure() != 0);
}

// Would catch what fast kernels do otherwise than strict ones, beyond rounding.
TEST_CASE("cuda lumen: fast steps have the same bits in every run, close to strict", "[device]") {
  SolverOptions options = GENERATE(kProjections, kBlocks);
  options.executor = cuda::device();
  options.math = MathMode::strict;
  LumenSolver strict(ball_scene(), options, {});
  options.math = MathMode::fast;
  LumenSolver fast(ball_scene(), options, {}), again(ball_scene(), options, {});
  for (LumenSolver* const each : {&strict, &fast, &again}) {
    each->lumen->set_reservoir(1e-5F, 300);
    each->run(20);
  }
  CHECK(again.solver.state_hash() == fast.solver.state_hash());
  CHECK(again.lumen->state().amount == fast.lumen->state().amount);
  CHECK(fast.lumen->pressure() == Approx(strict.lumen->pressure()).epsilon(1e-3));
  CHECK(fast.volume() == Approx(strict.volume()).epsilon(1e-5));
  CHECK(strict.volume() > 1.01 * 4.18879 * std::pow(testing::kInner, 3));
}

// Would catch a way of solving that takes a lumen in silence and leaves it out.
TEST_CASE("cuda lumen: who cannot step one says so", "[device]") {
  const auto refuse = [](SolverOptions options) {
    options.executor = cuda::device();
    Solver solver(ball_scene(), options);
    const auto lumen =
        std::make_shared<Lumen>(solver.tissue(), find_cavities(solver.tissue(), 0).at(0));
    CHECK_THROWS_AS(solver.add_constraints(lumen), BackendUnavailable);
    CHECK_THROWS_WITH(solver.add_constraints(lumen),
                      ContainsSubstring("'lumen' needs a CPU, or compliance mode"));
    CHECK(solver.step(kLumenStep).non_finite_vertices == 0);
  };
  refuse({.method = SolverMethod::vertex_block, .device_strategy = DeviceStrategy::cooperative});
  SolverOptions by_cluster = kProjections;
  by_cluster.device_strategy = DeviceStrategy::cluster;
  by_cluster.composition = PlanComposition::separate;
  refuse(by_cluster);
}

}  // namespace pbdsurg
