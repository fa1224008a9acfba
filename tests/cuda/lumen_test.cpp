// SPDX-License-Identifier: Apache-2.0
// A lumen on a device: strict against the serial backend, fast against strict, and what is refused.
#include "pbdsurg/surgery/lumen.h"

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

/// Two strict solvers, each with lumens of its own in the ball.
struct LumenPair : StrictPair {
  LumenPair(const SolverOptions& options, DeviceStrategy strategy)
      : StrictPair(scene(), options, strategy) {}

  void add(const LumenOptions& contents) {
    std::array<std::shared_ptr<Lumen>, 2>& added = lumens.emplace_back();
    for (const std::size_t i : {0, 1}) {
      Solver& solver = i == 0 ? serial : device;
      added[i] = std::make_shared<Lumen>(solver.tissue(), find_cavities(solver.tissue(), 0).at(0),
                                         contents);
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

 private:
  static Scene scene() {
    Scene ball = ball_scene();
    ball.set_gravity({0, -9.81F, 0});
    ball.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -0.022; });
    return ball;
  }
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
  INFO("gas " << is_gas << ", integration " << static_cast<int>(integration));
  SolverOptions options = kProjections;
  options.copies = 2;
  options.integration = integration;
  LumenPair pair(options, strategy);
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
  LumenPair pair(kProjections, DeviceStrategy::automatic);
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

// Would catch what fast kernels do otherwise than strict ones, beyond rounding.
TEST_CASE("cuda lumen: fast steps have the same bits in every run, close to strict", "[device]") {
  SolverOptions options = kProjections;
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
                      ContainsSubstring("'lumen' needs a CPU, or projections"));
    CHECK(solver.step(kLumenStep).non_finite_vertices == 0);
  };
  refuse({.method = SolverMethod::vertex_block});
  SolverOptions by_cluster = kProjections;
  by_cluster.device_strategy = DeviceStrategy::cluster;
  by_cluster.composition = PlanComposition::separate;
  refuse(by_cluster);
}

}  // namespace pbdsurg
