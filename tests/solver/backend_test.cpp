// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <future>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/base/executor_state.h"
#include "lib/coloring/coloring_device.h"
#include "lib/solver/program/solver_device.h"
#include "tests/support/catch.h"
#include "tests/support/edits_within_steps.h"
#include "tests/support/eventful_program.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/spring_block.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::equal;
using testing::fake_device_of;
using testing::FakeDevice;
using testing::kEventfulEdge;
using testing::kEventfulTimeStep;
using testing::make_free_spring_block;
using testing::Variant;

}  // namespace

// Would catch a change that an edit, a tool or a write does not log, state that is read where it is
// out of date, and a fetch that brings back what an edit took.
TEST_CASE("backend: one that keeps the state has the serial bits through all that changes",
          "[equivalence]") {
  const Variant variant =
      GENERATE(Variant{}, Variant{.composition = PlanComposition::joint},
               Variant{.composition = PlanComposition::joint, .max_colors = 9, .damping = 0.01F},
               Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
               Variant{.mode = ProjectionMode::fraction, .max_colors = 9},
               Variant{.composition = PlanComposition::nested, .max_colors = 5},
               Variant{.method = SolverMethod::vertex_block},
               Variant{.method = SolverMethod::vertex_block, .damping = 0.01F},
               Variant{.damping = 0.01F, .integration = TimeIntegration::bdf2},
               Variant{.method = SolverMethod::vertex_block, .integration = TimeIntegration::bdf2});
  const std::uint64_t seed = GENERATE(1, 2);
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = testing::fake_device();
  Solver device(scene, options);
  REQUIRE(std::string(device.backend_name()) == "fake device");
  REQUIRE(device.plan().name == serial.plan().name);

  const testing::EventfulProgram program(scene, seed);
  program.begin(serial);
  program.begin(device);
  bool touched = false;
  for (int round = 0; round < 60; ++round) {
    INFO(serial.plan().name << ", seed " << seed << ", round " << round);
    program.act(serial, round);
    program.act(device, round);
    if (round >= 20) {
      program.load(serial, round);
      program.load(device, round);
      program.fix(serial, round);
      program.fix(device, round);
    }
    if (round % 4 == 0) {  // with changes that the device has not heard of
      REQUIRE(device.state_hash() == serial.state_hash());
      REQUIRE(device.snapshot().falling == serial.snapshot().falling);
      REQUIRE(device.snapshot().roundings == serial.snapshot().roundings);
    }
    const StepReport expected = serial.step(kEventfulTimeStep);
    device.start_step(kEventfulTimeStep);
    REQUIRE(equal(device.finish_step(), expected));
    REQUIRE(std::ranges::equal(device.watched_positions(), serial.watched_positions()));
    const auto tool_count = static_cast<Index>(testing::inspect(serial).tools.size());
    for (Index tool = 0; tool < tool_count; ++tool) {
      REQUIRE(device.tool_force(ToolId(tool)) == serial.tool_force(ToolId(tool)));
    }
    if (round % 7 == 0) {
      REQUIRE(device.state_hash() == serial.state_hash());
    }
    touched = touched || expected.contacts > 0;
    REQUIRE(expected.non_finite_vertices == 0);
  }
  CHECK(device.state_hash() == serial.state_hash());
  CHECK(touched);
}

// Would catch a whole read back for the sake of some vertices, which costs more than the step.
TEST_CASE("backend: reading some vertices fetches no others", "[unit]") {
  Solver solver(make_free_spring_block(),
                testing::small_steps({.executor = testing::fake_device()}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.step(kEventfulTimeStep);
  const std::array<Index, 2> vertices{3, 9};
  std::array<Eigen::Vector3f, 2> some;
  solver.watch(vertices);
  solver.read_positions(vertices, some);
  solver.grasp(tool, vertices);
  solver.tissue().apply({.remove_tets = {0}});
  solver.step(kEventfulTimeStep);
  static_cast<void>(solver.tool_force(tool));
  static_cast<void>(solver.watched_positions());
  CHECK(fake_device_of(solver).fetch_count == 0);

  solver.read_positions(vertices, some);
  const std::vector<Eigen::Vector3f> all = solver.positions();
  CHECK(some == std::array{all[3], all[9]});
  static_cast<void>(solver.velocities());
  static_cast<void>(solver.state_hash());
  CHECK(fake_device_of(solver).fetch_count == 1);
}

// Would catch an edit that a running step feels, that waits for it, or whose undo brings vertices
// back as they moved before that step.
TEST_CASE("backend: an edit within a step is one after it, and does not wait", "[equivalence]") {
  const Variant variant =
      GENERATE(Variant{}, Variant{.composition = PlanComposition::joint},
               Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
               Variant{.method = SolverMethod::vertex_block, .damping = 0.01F});
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  Solver after(scene, options);
  options.executor = testing::fake_device();
  Solver within(scene, options);

  testing::check_edits_within_steps(within, after, [&](const TopologyEdit& edit) {
    REQUIRE(fake_device_of(within).is_running() == edit.new_vertices.empty());
  });
}

// Would catch a log that only grows, where nobody reads it.
// Would catch a compacted solver on the device of the thread that built it, or whose device was not
// told of tools, of what they hold or of what is watched.
TEST_CASE("backend: a compaction stays on its device and has the serial bits", "[equivalence]") {
  SolverOptions options = testing::small_steps(
      {.method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block),
       .copies = 2,
       .executor = executor::serial(),
       .composition = PlanComposition::separate});
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  Solver serial(scene, options);
  options.executor = testing::fake_device(1);
  Solver device(scene, options);
  const Index held = scene.body(1).first_vertex;
  for (Solver* solver : {&serial, &device}) {
    const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0, 0.016F, 0.006F);
    solver->add_tool({&capsule, 1}, pose, {ContactFeatures::vertices});
    solver->add_tool({}, ToolPose::Identity());
    solver->step(kEventfulTimeStep);
    solver->grasp(ToolId{1}, std::array{held}, 1e-4F, 1);
    solver->watch(std::array{held, held + 1});
    solver->tissue().apply({.remove_tets = {0, 1, 2, 3, 4, 5}});
    Compaction compaction(*solver);
    std::async(std::launch::async, [&] { compaction.build(); }).get();
    solver->step(kEventfulTimeStep);
    static_cast<void>(compaction.finish(*solver));
  }
  CHECK(fake_device_of(device).number == 1);
  for (int i = 0; i < 4; ++i) {
    const StepReport report = device.step(kEventfulTimeStep);
    CHECK(report.contacts == serial.step(kEventfulTimeStep).contacts);
    for (Index copy = 0; copy < 2; ++copy) {
      CHECK(device.state_hash(copy) == serial.state_hash(copy));
      CHECK(std::ranges::equal(device.watched_positions(copy), serial.watched_positions(copy)));
      CHECK(device.tool_force(ToolId{0}, copy) == serial.tool_force(ToolId{0}, copy));
      CHECK(device.tool_force(ToolId{1}, copy) == serial.tool_force(ToolId{1}, copy));
    }
    ToolPose pose = ToolPose::Identity();
    pose.translation().y() = 1e-3F * static_cast<float>(i + 1);
    device.move_tool(ToolId{1}, pose, 1);
    serial.move_tool(ToolId{1}, pose, 1);
  }
  CHECK(device.tool_force(ToolId{1}, 1).norm() > 0);
}

TEST_CASE("backend: edits are logged for those who need it alone, and until the next step",
          "[unit]") {
  const auto size_of_log = [](Solver& solver) {
    const Changes& changes = testing::inspect(solver).changes;
    return changes.vertices.size() + changes.constraints.size() + changes.tets.size();
  };
  Solver serial(make_free_spring_block(), testing::small_steps({.executor = executor::serial()}));
  Solver device(make_free_spring_block(),
                testing::small_steps({.executor = testing::fake_device()}));
  for (Solver* solver : {&serial, &device}) {
    solver->tissue().apply({.remove_tets = {0, 5}});
  }
  CHECK(size_of_log(serial) == 0);
  CHECK(size_of_log(device) > 0);
  CHECK(size_of_log(device) < 200);  // of 60 tetrahedra each around two
  device.step(kEventfulTimeStep);
  CHECK_FALSE(testing::inspect(device).changes.any());
}

TEST_CASE("backend: what it holds counts as memory", "[unit]") {
  SolverOptions options = testing::small_steps(
      {.executor = executor::serial(), .composition = PlanComposition::separate});
  Solver serial(make_free_spring_block(), options);
  options.executor = testing::fake_device();
  const Solver device(make_free_spring_block(), options);
  const std::size_t scratch = testing::inspect(serial).step_scratch.memory_bytes();
  CHECK(scratch > 0);  // which is of no use to a device
  CHECK(device.memory_bytes() == serial.memory_bytes() - scratch + FakeDevice::kMemory);
}

TEST_CASE("solver: a step that is started is finished once", "[unit]") {
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(1), testing::fake_device());
  const SolverOptions options = testing::small_steps({.substeps = 2, .executor = executor});
  Solver solver(make_free_spring_block(), options), other(make_free_spring_block(), options);
  const auto refuses_to_finish = [&] {
    CHECK_THROWS_WITH(solver.finish_step(), ContainsSubstring("no step was started"));
  };
  refuses_to_finish();
  CHECK_THROWS_AS(solver.start_step(-1), InvalidArgument);
  refuses_to_finish();

  solver.start_step(kEventfulTimeStep);
  CHECK_THROWS_WITH(solver.start_step(kEventfulTimeStep), ContainsSubstring("not finished"));
  CHECK_THROWS_WITH(solver.step(kEventfulTimeStep), ContainsSubstring("not finished"));
  const StepReport expected = other.step(kEventfulTimeStep);
  CHECK(solver.state_hash() == other.state_hash());  // waits for the step
  CHECK_THROWS_WITH(solver.start_step(kEventfulTimeStep), ContainsSubstring("not finished"));
  CHECK(equal(solver.finish_step(), expected));
  refuses_to_finish();

  // a step goes on in the solver that it was moved to, and may be given up
  solver.start_step(kEventfulTimeStep);
  Solver moved = std::move(solver);
  other.step(kEventfulTimeStep);
  moved.finish_step();
  CHECK(moved.state_hash() == other.state_hash());
  moved.start_step(kEventfulTimeStep);
}

// Would catch a call that works on the state of before the step, or changes what the step does.
TEST_CASE("solver: calls within a step wait for it and leave its report", "[unit]") {
  const Scene scene = make_free_spring_block();
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(1), testing::fake_device());
  const SolverOptions options = testing::small_steps({.substeps = 2, .executor = executor});
  const Capsule capsule{{0, 0, 0}, {0.01F, 0, 0}, 4e-3F};
  const auto make = [&] {
    auto solver = std::make_unique<Solver>(scene, options);
    solver->add_tool({&capsule, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
    solver->add_tool({}, ToolPose::Identity());
    solver->grasp(ToolId{1}, std::array<Index, 1>{63});
    solver->watch(std::array<Index, 1>{5});
    solver->step(kEventfulTimeStep);
    return solver;
  };
  ToolPose away = ToolPose::Identity();
  away.translation().x() = 1e-3F;
  const Snapshot snapshot = make()->snapshot();
  const auto zeros =
      std::vector<Eigen::Vector3f>(scene.positions().size(), Eigen::Vector3f::Zero());
  const auto call = [&](Solver& solver, int which) {
    std::array<Eigen::Vector3f, 1> one{};
    switch (which) {
      case 0:
        return solver.positions()[0];
      case 1:
        return solver.velocities()[0];
      case 2:
        solver.read_positions(std::array<Index, 1>{5}, one);
        return one[0];
      case 3:
        return solver.watched_positions()[0];
      case 4:
        solver.write_positions(snapshot.positions);
        break;
      case 5:
        solver.write_velocities(zeros);
        break;
      case 6: {
        Snapshot own = snapshot;
        own.tissue = solver.tissue().identified_version();
        solver.restore(own);
        break;
      }
      case 7:
        solver.move_tool(ToolId{1}, away);
        break;
      case 8:
        solver.grasp(ToolId{1}, std::array<Index, 1>{62});
        break;
      case 9:
        solver.release(ToolId{1});
        break;
      case 10:
        return solver.tool_force(ToolId{0});
      case 11:
        solver.watch(std::array<Index, 1>{6});
        return solver.watched_positions()[0];
      case 12:
        solver.tissue().apply({.remove_tets = {0, 1}});
        break;
      case 13:
        solver.add_tool({&capsule, 1}, away, {ContactFeatures::vertices});
        break;
      default:
        return solver.snapshot().positions[7];
    }
    return Eigen::Vector3f(0, 0, 0);
  };
  for (int which = 0; which <= 14; ++which) {
    INFO("call " << which);
    const auto within = make(), after = make();
    const StepReport expected = after->step(kEventfulTimeStep);
    const Eigen::Vector3f result = call(*after, which);
    within->start_step(kEventfulTimeStep);
    CHECK(call(*within, which) == result);
    CHECK(equal(within->finish_step(), expected));
    CHECK(equal(within->step(kEventfulTimeStep), after->step(kEventfulTimeStep)));
    CHECK(within->state_hash() == after->state_hash());
  }
}

TEST_CASE("solver: watched vertices come with every step", "[unit]") {
  const Executor executor =
      GENERATE(executor::serial(), executor::threads(1), testing::fake_device());
  Solver solver(make_free_spring_block(), testing::small_steps({.executor = executor}));
  CHECK(solver.watched_positions().empty());
  const std::array<Index, 3> vertices{17, 2, 17};
  const auto check = [&] {
    std::vector<Eigen::Vector3f> expected(vertices.size());
    solver.read_positions(vertices, expected);
    CHECK(std::ranges::equal(solver.watched_positions(), expected));
  };
  solver.watch(vertices);
  check();
  const Eigen::Vector3f before = solver.watched_positions()[0];
  for (int i = 0; i < 3; ++i) {
    solver.step(kEventfulTimeStep);
    check();
  }
  CHECK(solver.watched_positions()[0] != before);

  CHECK_THROWS_WITH(solver.watch(std::array<Index, 2>{0, 64}), ContainsSubstring("vertex 64"));
  CHECK_THROWS_WITH(solver.watch(std::array<Index, 1>{-1}), ContainsSubstring("vertex -1"));
  check();
  solver.watch({});
  solver.step(kEventfulTimeStep);
  CHECK(solver.watched_positions().empty());
}

namespace {

// Colours, until it refuses; steps as the fake device.
class ColorsOnce final : public Device, public ColoringDevice, public SolverDevice {
 public:
  [[nodiscard]] const std::string& name() const noexcept override { return name_; }
  [[nodiscard]] Coloring color(const ConstraintVertices& constraints,
                               const ColoringOptions& options) override {
    ++asked;
    if (refuses) {
      throw BackendUnavailable("no memory, the test says");
    }
    ColoringOptions on_host = options;
    on_host.executor = {};
    return color_constraints(constraints, on_host);
  }

  [[nodiscard]] std::unique_ptr<Backend> make_backend(const SolverData& data) override {
    return std::make_unique<FakeDevice>(data, 0);
  }

  bool refuses = false;
  int asked = 0;

 private:
  std::string name_ = "colours";
};

}  // namespace

// Would catch an edit that asks a device for colours, and so can fail where nothing may.
TEST_CASE("solver: a device may colour what is built, and never what edits bring", "[unit]") {
  const auto device = std::make_shared<ColorsOnce>();
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  SolverOptions options =
      testing::small_steps({.method = method, .executor = executor::threads(1)});
  options.coloring.algorithm = ColoringAlgorithm::luby;
  const TetMesh mesh = testing::make_box({3, 3, 3}, kEventfulEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 2e4));
  Solver expected(scene, options);
  options.coloring.executor = Executor(std::make_shared<ExecutorState>(device, Executor()));
  Solver solver(scene, options);
  device->refuses = true;
  CHECK_THROWS_AS(Solver(scene, options), BackendUnavailable);
  TopologyEdit edit;
  edit.new_bodies.add_body("second", mesh, elastic_material(mesh, 1000, 2e4));
  for (Solver* each : {&solver, &expected}) {
    each->tissue().apply(edit);
    each->step(kEventfulTimeStep);
  }
  CHECK(solver.state_hash() == expected.state_hash());
}

// Would catch a scene that steps on no device because its colours are too many for it.
TEST_CASE("solver: a device colours what is large, and may refuse to", "[long]") {
  const auto device = std::make_shared<ColorsOnce>();
  const Executor executor(std::make_shared<ExecutorState>(device, Executor()));
  const auto backend_of = [&](Index side) {
    const TetMesh mesh = testing::make_box({side, side, side}, 1e-3);
    Scene scene;
    scene.add_body("block", mesh, elastic_material(mesh, 1000, 2e4));
    return Solver(scene, testing::small_steps({.executor = executor})).backend_name();
  };
  const std::string small = backend_of(6);
  CHECK(device->asked == 0);
  CHECK(backend_of(52) == small);
  CHECK(device->asked > 0);
  device->refuses = true;
  CHECK(backend_of(52) == small);
}

// Would catch a device that is left out without a word, and one that ends a program that could go
// on without.
TEST_CASE("solver: a device that refuses says why, or another executor works instead", "[unit]") {
  const Scene scene = make_free_spring_block();
  using Names = std::pair<std::string, std::string>;
  const auto name = [&](const SolverOptions& options) -> Names {
    const Solver solver(scene, testing::small_steps(options));
    return {solver.backend_name(), solver.plan().name};
  };
  const auto refuse = [](const SolverData&) -> std::unique_ptr<Backend> {
    throw BackendUnavailable("this scene is too large, the test says");
  };
  const Executor small = testing::device_of_test(refuse);
  CHECK_THROWS_AS(Solver(scene, testing::small_steps({.executor = small})), BackendUnavailable);
  CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.executor = small})),
                    ContainsSubstring("this scene is too large, the test says"));

  const Executor careful = testing::device_of_test(refuse, executor::serial());
  CHECK(name({.executor = careful}) == Names{"serial", "greedy+repair, nested"});
  CHECK(name({.executor = careful, .composition = PlanComposition::joint}).second ==
        "greedy+repair, joint");
  CHECK(Solver(scene, testing::small_steps({.executor = careful})).options().executor.kind() ==
        ExecutorKind::serial);

  const Executor device = testing::fake_device();
  CHECK(name({.executor = device}) ==
        Names{"fake device", "greedy+repair, distances then volumes"});
  CHECK(name({.executor = device, .composition = PlanComposition::joint}) ==
        Names{"fake device", "greedy+repair, joint"});
  CHECK(name({.executor = executor::serial()}) == Names{"serial", "greedy+repair, nested"});
  CHECK(name({}).first.starts_with("threaded, " + executor::threads().name()));
  CHECK(Solver(scene, testing::small_steps({.executor = device})).options().composition ==
        PlanComposition::separate);
}

}  // namespace pbdsurg
