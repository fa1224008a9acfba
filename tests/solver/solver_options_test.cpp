// SPDX-License-Identifier: Apache-2.0
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "solver/fake_device.h"
#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::HookGuard;
using testing::kFakeDeviceHook;

constexpr double kEdge = 1e-2;

Scene make_soft_block() {
  const TetMesh mesh = testing::make_box({2, 1, 1}, kEdge);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 2e4));
  return scene;
}

constexpr BackendKind kBackends[]{BackendKind::automatic, BackendKind::serial,
                                  BackendKind::threaded, BackendKind::cuda};

}  // namespace

// Would catch an option that is taken without a word where nothing reads it.
TEST_CASE("solver options: what nothing would read is refused by name", "[unit]") {
  const HookGuard guard(&kFakeDeviceHook);
  const Scene scene = make_soft_block();
  const auto refuse = [&](const SolverOptions& options, const std::string& why) {
    INFO(why);
    CHECK_THROWS_AS(Solver(scene, options), InvalidArgument);
    CHECK_THROWS_WITH(Solver(scene, options), ContainsSubstring(why));
  };
  const auto vertices = SolverMethod::vertex_block;

  refuse({.iterations = 4, .over_relaxation = 1.5F}, "over_relaxation is 1.5");
  refuse({.iterations = 4, .over_relaxation = 1.5F}, "needs the vertex-block method");
  for (const BackendKind backend : {BackendKind::serial, BackendKind::cuda}) {
    refuse({.backend = backend, .threads = 2}, "threads is 2");
    refuse({.backend = backend, .wait = ThreadWait::spin}, "wait is spin");
    refuse({.backend = backend, .wait = ThreadWait::block}, "wait is block");
  }
  for (const BackendKind backend : {BackendKind::serial, BackendKind::threaded}) {
    refuse({.backend = backend, .device_strategy = DeviceStrategy::stream}, "strategy is stream");
    refuse({.backend = backend, .device_strategy = DeviceStrategy::graph}, "strategy is graph");
    refuse({.backend = backend, .device_strategy = DeviceStrategy::cluster}, "strategy is cluster");
  }
  for (const BackendKind backend : {BackendKind::automatic, BackendKind::cuda}) {
    refuse({.method = vertices, .backend = backend, .device_strategy = DeviceStrategy::cluster},
           "vertex-block");
  }
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
TEST_CASE("solver options: defaults and presets are taken on every backend", "[unit]") {
  const HookGuard guard(&kFakeDeviceHook);
  const Scene scene = make_soft_block();
  for (const BackendKind backend : kBackends) {
    for (const SolverMethod method : {SolverMethod::projection, SolverMethod::vertex_block}) {
      INFO("backend " << static_cast<int>(backend) << ", method " << static_cast<int>(method));
      SolverOptions options;
      options.backend = backend;
      options.method = method;
      const Solver solver(scene, options);
      CHECK_NOTHROW(Solver(scene, solver.options()));
    }
    SolverOptions paper = SolverOptions::paper();
    paper.backend = backend;
    CHECK_NOTHROW(Solver(scene, paper));
  }
}

TEST_CASE("solver options: the automatic backend takes those of all, others their own", "[unit]") {
  const HookGuard guard(GENERATE(static_cast<const CudaHook*>(nullptr), &kFakeDeviceHook));
  const Scene scene = make_soft_block();
  CHECK_NOTHROW(Solver(
      scene,
      {.device_strategy = DeviceStrategy::cluster, .threads = 2, .wait = ThreadWait::block}));
  CHECK_NOTHROW(
      Solver(scene, {.backend = BackendKind::threaded, .threads = 2, .wait = ThreadWait::block}));
  CHECK_NOTHROW(Solver(scene, {.backend = BackendKind::serial, .threads = 1}));
  CHECK_NOTHROW(Solver(scene, {.method = SolverMethod::vertex_block,
                               .iterations = 2,
                               .over_relaxation = 1.5F,
                               .composition = PlanComposition::nested}));
  CHECK_NOTHROW(Solver(scene, {.method = SolverMethod::vertex_block,
                               .coloring = {.algorithm = ColoringAlgorithm::luby}}));
}

}  // namespace pbdsurg
