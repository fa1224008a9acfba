// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

Scene make_soft_block() {
  const TetMesh mesh = testing::make_box({2, 1, 1}, 1e-2);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 2e4));
  return scene;
}

std::vector<Executor> all_executors() {
  return {{}, executor::serial(), executor::threads(2), testing::fake_device()};
}

}  // namespace

// Would catch an option that is taken without a word where nothing reads it.
TEST_CASE("solver options: what nothing would read is refused by name", "[unit]") {
  const Scene scene = make_soft_block();
  const auto refuse = [&](const SolverOptions& options, const std::string& why) {
    INFO(why);
    CHECK_THROWS_AS(Solver(scene, options), InvalidArgument);
    CHECK_THROWS_WITH(Solver(scene, options), ContainsSubstring(why));
  };
  const auto vertices = SolverMethod::vertex_block;

  refuse({.method = SolverMethod::projection, .iterations = 4, .over_relaxation = 1.5F},
         "over_relaxation is 1.5");
  refuse({.method = SolverMethod::projection, .iterations = 4, .over_relaxation = 1.5F},
         "needs the vertex-block method");
  refuse({.method = SolverMethod::projection,
          .iterations = 4,
          .coarse_correction = CoarseCorrection::on},
         "coarse_correction is on");
  refuse({.method = SolverMethod::explicit_steps, .coarse_correction = CoarseCorrection::on},
         "needs the vertex-block method");
  refuse({.method = vertices, .iterations = 1, .coarse_correction = CoarseCorrection::on},
         "iterations is 1");
  for (const Executor& executor : {Executor(), executor::serial(), executor::threads(2)}) {
    refuse({.executor = executor, .device_strategy = DeviceStrategy::stream}, "strategy is stream");
    refuse({.executor = executor, .device_strategy = DeviceStrategy::graph}, "strategy is graph");
    refuse({.executor = executor, .device_strategy = DeviceStrategy::cluster},
           "strategy is cluster");
  }
  refuse({.method = vertices,
          .executor = testing::fake_device(),
          .device_strategy = DeviceStrategy::cluster},
         "vertex-block");
  refuse({.method = SolverMethod::projection,
          .executor = testing::fake_device(),
          .device_strategy = DeviceStrategy::cooperative},
         "strategy is cooperative");
  refuse({.method = vertices, .mode = ProjectionMode::fraction}, "fraction");
  refuse({.method = vertices, .composition = PlanComposition::joint}, "joint");
  refuse({.method = vertices, .coloring = {.max_colors = 3}}, "max_colors is 3");
  refuse({.coloring = {.algorithm = ColoringAlgorithm::luby, .order = GreedyOrder::saturation}},
         "order is saturation");
  refuse({.coloring = {.disc = {.palette = Palette::conflicts}}}, "palette is conflicts");
  refuse({.coloring = {.algorithm = ColoringAlgorithm::random_disc, .disc = {.shrink = 3}}},
         "shrink is 3");
}

// Would catch a rule that refuses who has set nothing, a preset, or what a solver says of itself.
TEST_CASE("solver options: defaults and presets are taken by every executor", "[unit]") {
  const Scene scene = make_soft_block();
  for (const Executor& executor : all_executors()) {
    for (const SolverMethod method : {SolverMethod::projection, SolverMethod::vertex_block}) {
      INFO((executor ? executor.name() : "nobody") << ", method " << static_cast<int>(method));
      SolverOptions options = testing::small_steps();
      options.executor = executor;
      options.method = method;
      const Solver solver(scene, options);
      CHECK_NOTHROW(Solver(scene, solver.options()));
    }
    SolverOptions paper = SolverOptions::paper();
    paper.executor = executor;
    CHECK_NOTHROW(Solver(scene, paper));
  }
}

TEST_CASE("solver options: what has a reader is taken", "[unit]") {
  const Scene scene = make_soft_block();
  CHECK_NOTHROW(Solver(scene, testing::small_steps({.executor = testing::fake_device(),
                                                    .device_strategy = DeviceStrategy::cluster})));
  CHECK_NOTHROW(Solver(scene, testing::small_steps({.method = SolverMethod::vertex_block,
                                                    .iterations = 2,
                                                    .over_relaxation = 1.5F,
                                                    .composition = PlanComposition::nested})));
  CHECK_NOTHROW(Solver(
      scene, {.method = SolverMethod::vertex_block, .coarse_correction = CoarseCorrection::on}));
  CHECK_NOTHROW(
      Solver(scene, testing::small_steps({.method = SolverMethod::vertex_block,
                                          .coloring = {.algorithm = ColoringAlgorithm::luby}})));
}

}  // namespace pbdsurg
