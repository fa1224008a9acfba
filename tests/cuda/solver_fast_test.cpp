// SPDX-License-Identifier: Apache-2.0
// Solvers on a device in fast mode, against strict ones.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
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

// A ball with one vertex inside: that has 80 tetrahedra and 42 neighbours, more than sixteen
// threads hold in registers.
TetMesh make_fan() {
  constexpr Index kRings = 4, kSegments = 10;
  constexpr double kRadius = testing::kEventfulEdge, kPi = std::numbers::pi;
  std::vector<Eigen::Vector3d> points{{0, 0, 0}, {0, 0, kRadius}, {0, 0, -kRadius}};
  const auto on_ring = [](Index ring, Index segment) {
    return 3 + ring * kSegments + segment % kSegments;
  };
  for (Index ring = 0; ring < kRings; ++ring) {
    const double polar = kPi * (ring + 1) / (kRings + 1);
    for (Index segment = 0; segment < kSegments; ++segment) {
      const double around = 2 * kPi * segment / kSegments;
      points.emplace_back(kRadius * Eigen::Vector3d(std::sin(polar) * std::cos(around),
                                                    std::sin(polar) * std::sin(around),
                                                    std::cos(polar)));
    }
  }
  std::vector<Tet> tets;
  for (Index segment = 0; segment < kSegments; ++segment) {
    tets.push_back({0, 1, on_ring(0, segment), on_ring(0, segment + 1)});
    tets.push_back({0, 2, on_ring(kRings - 1, segment + 1), on_ring(kRings - 1, segment)});
    for (Index ring = 0; ring + 1 < kRings; ++ring) {
      const Index a = on_ring(ring, segment), b = on_ring(ring, segment + 1);
      const Index c = on_ring(ring + 1, segment), d = on_ring(ring + 1, segment + 1);
      tets.push_back({0, a, c, d});
      tets.push_back({0, a, d, b});
    }
  }
  return {std::move(points), std::move(tets)};
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
  SolverOptions options = pbdsurg::testing::small_steps({.mode = mode,
                                                         .damping = 5,
                                                         .executor = cuda::device(),
                                                         .math = MathMode::strict,
                                                         .composition = composition});
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
  options.device_strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  Solver fast(scene, options);
  Solver again(scene, options);
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.022F, 0.01F);
  for (Solver* solver : {&strict, &fast, &again}) {
    solver->add_tool({&capsule, 1}, pose, {ContactFeatures::vertices});
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

// Would catch rows that threads leave to a loop and forget, and a lost neighbour that takes others
// along.
TEST_CASE("cuda solver: fast vertex blocks move a vertex of many rows, and beside a lost one",
          "[device]") {
  Scene scene;
  scene.add_body("fan", make_fan(),
                 {.model = ElasticModel::neo_hookean, .damping = GENERATE(0.0F, 5e-3F)});
  scene.fix_vertices(0, std::array<Index, 3>{1, 3, 8});
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 3,
                        .damping = 5,
                        .executor = cuda::device(),
                        .math = MathMode::strict};
  Solver strict(scene, options);
  options.math = MathMode::fast;
  Solver fast(scene, options);
  const bool loses = GENERATE(false, true);
  std::vector<Eigen::Vector3f> positions = strict.positions();
  positions[0].x() += 1e-3F;  // something to do
  if (loses) {
    positions[2].setConstant(1e18F);
  }
  for (Solver* solver : {&strict, &fast}) {
    solver->write_positions(positions);
    for (int i = 0; i < 5; ++i) {
      solver->step(kTimeStep);
    }
  }
  const std::vector<Eigen::Vector3f> of_strict = strict.positions(), of_fast = fast.positions();
  for (std::size_t v = 0; v < of_strict.size(); ++v) {
    if (v != 2 || !loses) {
      CHECK((of_fast[v] - of_strict[v]).norm() < 1e-3 * testing::kEventfulEdge);
    }
  }
  CHECK((of_strict[0] - positions[0]).norm() > 0.01 * testing::kEventfulEdge);
}

}  // namespace pbdsurg
