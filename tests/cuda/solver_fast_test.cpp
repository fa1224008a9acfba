// SPDX-License-Identifier: Apache-2.0
// Solvers on a device in fast mode, against strict ones.
#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/spring_block.h"

namespace pbdsurg {
namespace {

using testing::make_spring_block;

constexpr float kTimeStep = testing::kEventfulTimeStep;

// The largest distance of a vertex in one solver from where it is in the other, in edges.
float edges_apart(const Solver& a, const Solver& b) {
  const std::vector<Eigen::Vector3f> of_a = a.positions();
  const std::vector<Eigen::Vector3f> of_b = b.positions();
  float apart = 0;
  for (std::size_t v = 0; v < of_a.size(); ++v) {
    apart = std::max(apart, (of_a[v] - of_b[v]).norm());
  }
  return apart / static_cast<float>(testing::kEventfulEdge);
}

}  // namespace

TEST_CASE("cuda solver: fast has the same bits in every run, close to strict", "[device]") {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  Scene scene = make_spring_block();
  if (mode == ProjectionMode::compliance) {
    scene.add_body("solid", testing::make_box({4, 3, 3}, testing::kEventfulEdge, 0.1),
                   {.model = ElasticModel::neo_hookean});
    scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  }
  SolverOptions options{.mode = mode,
                        .damping = 5,
                        .executor = cuda::device(),
                        .math = MathMode::strict,
                        .composition = composition};
  Solver strict(scene, options);
  options.math = MathMode::fast;
  options.device_strategy =
      composition == PlanComposition::joint
          ? DeviceStrategy::graph
          : GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cluster);
  Solver fast(scene, options);
  Solver again(scene, options);
  for (int i = 0; i < 5; ++i) {
    for (Solver* solver : {&strict, &fast, &again}) {
      solver->step(kTimeStep);
    }
  }
  CHECK(again.state_hash() == fast.state_hash());
  CHECK(edges_apart(fast, strict) < 1e-4F);
}

TEST_CASE("cuda solver: fast vertex blocks have the same bits in every run, close to strict",
          "[device]") {
  const float damping = GENERATE(0.0F, 5e-3F);
  Scene scene = make_spring_block({6, 5, 5}, SolverMethod::vertex_block);
  scene.add_body("solid", testing::make_box({4, 3, 3}, testing::kEventfulEdge, 0.1),
                 {.model = ElasticModel::neo_hookean, .damping = damping});
  scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 3,
                        .damping = 5,
                        .executor = cuda::device(),
                        .math = MathMode::strict};
  Solver strict(scene, options);
  options.math = MathMode::fast;
  options.device_strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph);
  Solver fast(scene, options);
  Solver again(scene, options);
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.022F, 0.01F);
  for (Solver* solver : {&strict, &fast, &again}) {
    solver->add_tool({&capsule, 1}, pose);
    solver->add_tool({}, ToolPose::Identity());
    solver->grasp(ToolId{1}, std::array<Index, 2>{100, 101}, 1e-4F);
  }
  Index contacts = 0;
  for (int i = 0; i < 5; ++i) {
    for (Solver* solver : {&strict, &fast, &again}) {
      contacts += solver->step(kTimeStep).contacts;
    }
  }
  CHECK(contacts > 0);
  CHECK(again.state_hash() == fast.state_hash());
  CHECK(edges_apart(fast, strict) < 1e-3F);
}

}  // namespace pbdsurg
