// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/copies_program.h"
#include "tests/support/device_strategies.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::make_eventful_scene;
using testing::Variant;

constexpr float kTimeStep = testing::kEventfulTimeStep;

SolverOptions options_of(const Variant& variant, DeviceStrategy strategy) {
  SolverOptions options = testing::options_of(variant);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  return options;
}

}  // namespace

// Would catch a kernel that works on another copy's part of an array.
TEST_CASE("cuda copies: strict copies have the bits of serial solvers of one", "[device]") {
  const Variant variant = GENERATE(
      Variant{.contact_capacity = 20},
      Variant{.composition = PlanComposition::joint, .damping = 0.01F, .contact_capacity = 20},
      Variant{.composition = PlanComposition::joint,
              .max_colors = 9,
              .iterations = 1,
              .contact_capacity = 20},
      Variant{.max_colors = 5, .damping = 0.01F, .contact_capacity = 3},
      Variant{.mode = ProjectionMode::fraction,
              .composition = PlanComposition::nested,
              .contact_capacity = 20},
      Variant{.mode = ProjectionMode::fraction, .max_colors = 9},
      Variant{.method = SolverMethod::vertex_block, .contact_capacity = 3},
      Variant{.method = SolverMethod::vertex_block, .damping = 0.01F, .contact_capacity = 20},
      Variant{.method = SolverMethod::vertex_block,
              .contact_capacity = 20,
              .coarse_correction = CoarseCorrection::on});
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  if (!testing::suits(strategy, variant.method) ||
      (strategy == DeviceStrategy::cluster &&
       (variant.composition == PlanComposition::joint || variant.max_colors > 0))) {
    return;  // no plans for a cluster
  }
  const SolverOptions options = options_of(variant, strategy);
  SolverOptions alone = options;
  alone.executor = executor::serial();
  alone.device_strategy = DeviceStrategy::automatic;

  const testing::CopiesComparison result =
      testing::compare_copies(make_eventful_scene(variant.mode, variant.damping, {4, 4, 3},
                                                  strategy == DeviceStrategy::cooperative),
                              options, alone, 5, 40);

  INFO(result.difference);
  CHECK(result.difference.empty());
  CHECK(result.contacts > 0);
  CHECK(result.forces > 40);
}

// More copies than a device has multiprocessors, and blocks that are fewer for each. In fast mode a
// cooperative kernel then takes fewer threads a vertex, whose sums are others; in strict mode
// never.
TEST_CASE("cuda copies: many copies have the bits of solvers of one", "[device]") {
  const auto copies = GENERATE(3, 140);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  if (!testing::suits(strategy, method)) {
    return;
  }
  INFO("method " << static_cast<int>(method) << ", strategy " << static_cast<int>(strategy));
  SolverOptions options = options_of({.method = method, .contact_capacity = 20}, strategy);
  options.math =
      strategy == DeviceStrategy::cooperative && copies > 3 ? MathMode::strict : MathMode::fast;
  SolverOptions alone = options;
  if (strategy == DeviceStrategy::graph) {
    alone.device_strategy = DeviceStrategy::stream;
  }

  const testing::CopiesComparison result =
      testing::compare_copies(make_eventful_scene(ProjectionMode::compliance, 0, {4, 4, 3},
                                                  strategy == DeviceStrategy::cooperative),
                              options, alone, copies, copies == 3 ? 30 : 8);

  INFO(result.difference);
  CHECK(result.difference.empty());
}

TEST_CASE("cuda copies: reading some vertices of a copy", "[device]") {
  Solver solver(make_eventful_scene(ProjectionMode::compliance, 0),
                pbdsurg::testing::small_steps({.copies = 3, .executor = cuda::device()}));
  for (Index copy = 0; copy < 3; ++copy) {
    std::vector<Eigen::Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()));
    for (Eigen::Vector3f& v : velocities) {
      v = Eigen::Vector3f::Constant(0.1F * static_cast<float>(copy));
    }
    solver.write_velocities(velocities, copy);
  }
  solver.step(kTimeStep);
  const std::array<Index, 3> vertices{17, 4, 40};
  for (Index copy = 0; copy < 3; ++copy) {
    INFO("copy " << copy);
    std::array<Eigen::Vector3f, 3> some;
    solver.read_positions(vertices, some, copy);
    const std::vector<Eigen::Vector3f> all = solver.positions(copy);
    CHECK(some == std::array{all[17], all[4], all[40]});
  }
  CHECK(solver.positions(0) != solver.positions(2));
}

TEST_CASE("cuda copies: the report names the first that has lost a vertex", "[device]") {
  Solver solver(make_eventful_scene(ProjectionMode::compliance, 0),
                pbdsurg::testing::small_steps(
                    {.copies = 4, .executor = cuda::device(), .math = MathMode::strict}));
  std::vector<Eigen::Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                          Eigen::Vector3f::Zero());
  velocities[77].x() = std::numeric_limits<float>::max();
  solver.write_velocities(velocities, 2);
  solver.write_velocities(velocities, 3);

  const StepReport report = solver.step(1e6F);

  CHECK(report.first_non_finite_copy == 2);
  CHECK(report.first_non_finite != kInvalidIndex);
  CHECK(solver.last_report(1).non_finite_vertices == 0);
  CHECK(solver.last_report(3).first_non_finite == solver.last_report(2).first_non_finite);
}

// Would catch a copy of records, which take several times the memory of the state.
TEST_CASE("cuda copies: each takes the memory of its state", "[device]") {
  const auto bytes = [](Index copies) {
    Scene scene;
    scene.add_body("block", testing::make_box({20, 20, 20}, testing::kEventfulEdge, 0.1),
                   pbdsurg::testing::kSprings);
    Solver solver(scene, pbdsurg::testing::small_steps({.iterations = 1,
                                                        .copies = copies,
                                                        .executor = cuda::device(),
                                                        .device_strategy = DeviceStrategy::graph}));
    solver.step(kTimeStep);
    return solver.memory_bytes();
  };
  constexpr std::size_t kVertices = 21 * 21 * 21;
  constexpr std::size_t kHost = 48;     // bytes a vertex: position, velocity, carry
  constexpr std::size_t kDevice = 64;   // likewise, and the displacement
  constexpr std::size_t kInput = 1000;  // at most, of a step without tools
  const std::size_t grown = bytes(17) - bytes(1);
  CHECK(grown >= 16 * kVertices * (kHost + kDevice));
  CHECK(grown < 16 * (kVertices * (kHost + kDevice) + kInput));
}

}  // namespace pbdsurg
