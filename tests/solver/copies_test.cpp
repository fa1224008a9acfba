// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <limits>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/base/executor_state.h"
#include "tests/support/catch.h"
#include "tests/support/copies_program.h"
#include "tests/support/fake_device.h"
#include "tests/support/small_steps.h"
#include "tests/support/spring_block.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::kEventfulTimeStep;
using testing::make_free_spring_block;
using testing::Variant;

}  // namespace

// Would catch anything that one copy leaves behind for the next, and what copies share that they
// should not.
TEST_CASE("copies: each moves as it would alone", "[unit][long]") {
  const Variant variant = GENERATE(
      Variant{}, Variant{.composition = PlanComposition::joint, .damping = 0.01F},
      Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
      Variant{.max_colors = 5}, Variant{.method = SolverMethod::vertex_block},
      Variant{.method = SolverMethod::vertex_block, .damping = 0.01F},
      Variant{.method = SolverMethod::vertex_block, .coarse_correction = CoarseCorrection::on});
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(3), testing::fake_device());
  SolverOptions options = testing::options_of(variant);
  options.contact_capacity = 20;
  options.executor = executor;
  options.math = MathMode::fast;
  SolverOptions alone = options;
  if (executor.kind() == ExecutorKind::device) {
    alone.executor = executor::serial();
  }
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);

  const testing::CopiesComparison result = testing::compare_copies(scene, options, alone, 4, 40);

  INFO(result.difference);
  CHECK(result.difference.empty());
  CHECK(result.contacts > 0);
  CHECK(result.forces > 40);
}

// Would catch a scratch that is another worker's, of before an edit, or that is made anew.
TEST_CASE("copies: who finds the team taken steps them alone, with the same bits", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0.01F);
  SolverOptions options =
      testing::small_steps({.method = method, .copies = 5, .executor = executor::serial()});
  options.math = MathMode::strict;
  options.composition = PlanComposition::separate;
  Solver serial(scene, options);
  const Executor shared = options.executor = executor::threads(3);
  Solver solver(scene, options);
  std::size_t memory = 0;
  for (int step = 0; step < 12; ++step) {
    for (Solver* const each : {&serial, &solver}) {
      if (step % 4 == 3) {
        each->tissue().apply({.remove_tets = {step}});
      }
      if (step == 8) {
        each->tissue().undo();
      }
    }
    serial.step(kEventfulTimeStep);
    {
      const TeamLease other(step % 2 == 0 ? shared.state() : nullptr, 3);
      solver.step(kEventfulTimeStep);
    }
    memory = memory == 0 ? solver.memory_bytes() : memory;
    for (Index copy = 0; copy < 5; ++copy) {
      REQUIRE(solver.state_hash(copy) == serial.state_hash(copy));
    }
  }
  CHECK(solver.memory_bytes() < 1.02 * static_cast<double>(memory));
}

TEST_CASE("copies: a copy that there is not is refused by name", "[unit]") {
  CHECK_THROWS_WITH(Solver(make_free_spring_block(), testing::small_steps({.copies = 0})),
                    ContainsSubstring("copies is 0"));
  Solver solver(make_free_spring_block(),
                testing::small_steps({.copies = 3, .executor = executor::serial()}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const std::array<Index, 1> vertex{5};
  std::vector<Eigen::Vector3f> all = solver.positions();
  std::array<Eigen::Vector3f, 1> one{};
  const Snapshot snapshot = solver.snapshot(2);
  for (const Index copy : {-1, 3}) {
    const auto refuses = [&](auto call) {
      CHECK_THROWS_AS(call(), InvalidArgument);
      CHECK_THROWS_WITH(call(), ContainsSubstring("there is no copy " + std::to_string(copy) +
                                                  "; the solver has 3"));
    };
    refuses([&] { static_cast<void>(solver.positions(copy)); });
    refuses([&] { solver.read_positions(all, copy); });
    refuses([&] { solver.read_positions(vertex, one, copy); });
    refuses([&] { solver.write_positions(all, copy); });
    refuses([&] { static_cast<void>(solver.velocities(copy)); });
    refuses([&] { solver.write_velocities(all, copy); });
    refuses([&] { static_cast<void>(solver.snapshot(copy)); });
    refuses([&] { solver.restore(snapshot, copy); });
    refuses([&] { static_cast<void>(solver.state_hash(copy)); });
    refuses([&] { solver.move_tool(tool, ToolPose::Identity(), copy); });
    refuses([&] { solver.grasp(tool, vertex, 0, copy); });
    refuses([&] { solver.release(tool, copy); });
    refuses([&] { static_cast<void>(solver.tool_force(tool, copy)); });
    refuses([&] { static_cast<void>(solver.watched_positions(copy)); });
    refuses([&] { static_cast<void>(solver.last_report(copy)); });
  }
  CHECK(solver.state_hash() == solver.state_hash(2));
}

TEST_CASE("copies: a snapshot of one restores into any", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(
      testing::make_eventful_scene(ProjectionMode::compliance, 0),
      testing::small_steps({.method = method, .copies = 3, .executor = executor::serial()}));
  const std::vector<Eigen::Vector3f> moving(static_cast<std::size_t>(solver.vertex_count()),
                                            Eigen::Vector3f(0.1F, 0.2F, 0));
  solver.write_velocities(moving, 1);
  solver.step(kEventfulTimeStep);
  CHECK(solver.state_hash(0) == solver.state_hash(2));
  CHECK(solver.state_hash(0) != solver.state_hash(1));

  solver.restore(solver.snapshot(1), 2);

  CHECK(solver.state_hash(2) == solver.state_hash(1));
  solver.step(kEventfulTimeStep);
  CHECK(solver.state_hash(2) == solver.state_hash(1));
  CHECK(solver.state_hash(0) != solver.state_hash(1));
}

TEST_CASE("copies: the report names the first that has lost a vertex", "[unit]") {
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(3), testing::fake_device());
  Solver solver(make_free_spring_block(),
                testing::small_steps({.copies = 4, .executor = executor}));
  const StepReport calm = solver.step(kEventfulTimeStep);
  CHECK(calm.first_non_finite == kInvalidIndex);
  CHECK(calm.first_non_finite_copy == kInvalidIndex);
  std::vector<Eigen::Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                          Eigen::Vector3f::Zero());
  velocities[3].x() = std::numeric_limits<float>::max();
  solver.write_velocities(velocities, 3);
  velocities[3].x() = 0;
  velocities[9].x() = std::numeric_limits<float>::max();
  solver.write_velocities(velocities, 2);

  const StepReport report = solver.step(1e6F);

  CHECK(report.first_non_finite_copy == 2);
  CHECK(report.first_non_finite == 9);
  CHECK(report.non_finite_vertices >= 2);
  CHECK(solver.last_report(1).non_finite_vertices == 0);
  CHECK(solver.last_report(1).first_non_finite_copy == kInvalidIndex);
  CHECK(solver.last_report(3).first_non_finite == 3);
  CHECK(solver.last_report(3).first_non_finite_copy == 3);
}

// Would catch a copy of what copies share: a scene has some ten times the bytes of its state.
TEST_CASE("copies: each takes the memory of its state", "[unit]") {
  const auto bytes = [](Index copies) {
    return Solver(make_free_spring_block(),
                  testing::small_steps({.copies = copies, .executor = executor::serial()}))
        .memory_bytes();
  };
  constexpr std::size_t kState =
      64 * (sizeof(Particle) + sizeof(Velocity) + sizeof(Carry));  // of 64 vertices
  CHECK(bytes(2) == bytes(1) + kState);
  CHECK(bytes(9) == bytes(1) + 8 * kState);
}

}  // namespace pbdsurg
