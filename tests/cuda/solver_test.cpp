// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/solver.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/tissue/tissue.h"

#include "cuda/solver/longest_wait.h"
#include "tests/support/catch.h"
#include "tests/support/device_strategies.h"
#include "tests/support/edits_within_steps.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/spring_block.h"

namespace pbdsurg {
namespace {

using testing::equal;
using testing::EventfulProgram;
using testing::make_eventful_scene;
using testing::make_spring_block;
using testing::options_of;
using testing::Variant;

constexpr float kTimeStep = testing::kEventfulTimeStep;

}  // namespace

// Would catch a device that does not hear of a change, or anything in a step that is done otherwise
// than by the serial backend.
TEST_CASE("cuda solver: strict has the serial bits through all that changes", "[device]") {
  const Variant variant = GENERATE(
      Variant{}, Variant{.damping = 0.01F, .iterations = 1},
      Variant{.composition = PlanComposition::joint, .contact_capacity = 3},
      Variant{.composition = PlanComposition::joint, .max_colors = 9, .damping = 0.01F},
      Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
      Variant{.mode = ProjectionMode::fraction, .max_colors = 9, .contact_capacity = 0},
      Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::joint},
      Variant{.composition = PlanComposition::nested, .max_colors = 5},
      Variant{.method = SolverMethod::vertex_block},
      Variant{.method = SolverMethod::vertex_block, .damping = 0.01F, .iterations = 1},
      Variant{.method = SolverMethod::vertex_block,
              .composition = PlanComposition::nested,
              .damping = 0.01F,
              .iterations = 3,
              .over_relaxation = 1.5F,
              .contact_capacity = 3},
      Variant{.method = SolverMethod::vertex_block, .contact_capacity = 0},
      Variant{.damping = 0.01F, .integration = TimeIntegration::bdf2},
      Variant{.method = SolverMethod::vertex_block, .integration = TimeIntegration::bdf2},
      Variant{.method = SolverMethod::vertex_block,
              .damping = 0.01F,
              .over_relaxation = 1.5F,
              .integration = TimeIntegration::bdf2},
      Variant{.method = SolverMethod::vertex_block, .coarse_correction = CoarseCorrection::on},
      Variant{.method = SolverMethod::vertex_block,
              .damping = 0.01F,
              .over_relaxation = 1.2F,
              .integration = TimeIntegration::bdf2,
              .coarse_correction = CoarseCorrection::on});
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  if (!testing::suits(strategy, variant.method) ||
      (strategy == DeviceStrategy::cluster &&
       (variant.composition == PlanComposition::joint || variant.max_colors > 0))) {
    return;  // nothing for a cluster
  }
  const Scene scene = make_eventful_scene(variant.mode, variant.damping, {4, 4, 3},
                                          strategy == DeviceStrategy::cooperative);
  SolverOptions options = options_of(variant);
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  Solver device(scene, options);
  REQUIRE(device.plan().name == serial.plan().name);

  const ToolSurface surface =
      GENERATE(ToolSurface{ContactFeatures::vertices}, ToolSurface{ContactFeatures::all, 0.2F},
               ToolSurface{ContactFeatures::vertices, 0.2F});
  const EventfulProgram program(scene, 1, surface);
  program.begin(serial);
  program.begin(device);
  Index contacts = 0;
  Index dropped = 0;
  for (int round = 0; round < 100; ++round) {
    INFO(device.backend_name() << ": " << serial.plan().name << ", features "
                               << static_cast<int>(surface.features) << ", friction "
                               << surface.friction << ", round " << round);
    program.act(serial, round);
    program.act(device, round);
    if (round >= 40) {
      program.load(serial, round);
      program.load(device, round);
      program.fix(serial, round);
      program.fix(device, round);
    }
    if (round % 4 == 0) {  // with changes that the device has not heard of
      REQUIRE(device.state_hash() == serial.state_hash());
    }
    const StepReport expected = serial.step(kTimeStep);
    device.start_step(kTimeStep);
    const StepReport report = device.finish_step();
    CHECK(report.contacts == expected.contacts);
    CHECK(report.distance_residual == expected.distance_residual);
    REQUIRE(equal(report, expected));
    REQUIRE(std::ranges::equal(device.watched_positions(), serial.watched_positions()));
    if (round % 10 == 0) {
      REQUIRE(device.snapshot().falling == serial.snapshot().falling);
      REQUIRE(device.snapshot().roundings == serial.snapshot().roundings);
    }
    for (Index tool = 0; tool < 2; ++tool) {
      REQUIRE(device.tool_force(ToolId(tool)) == serial.tool_force(ToolId(tool)));
      REQUIRE(device.tool_torque(ToolId(tool)) == serial.tool_torque(ToolId(tool)));
    }
    if (round % 7 == 0) {
      REQUIRE(device.state_hash() == serial.state_hash());
    }
    contacts += expected.contacts;
    dropped += expected.dropped_contacts.total();
  }
  CHECK(device.state_hash() == serial.state_hash());
  CHECK((contacts > 0) == (variant.contact_capacity > 0));
  CHECK((dropped > 0) == (variant.contact_capacity < 4096));
}

// Would catch a device that goes on to settle what tools hold after the last stiff link went, where
// the serial backend does not.
TEST_CASE("cuda solver: stiff links that go and come while tools hold have the serial bits",
          "[device]") {
  const Scene scene = make_eventful_scene(ProjectionMode::compliance, GENERATE(0.0F, 0.01F));
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 3,
                        .coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on),
                        .math = MathMode::strict,
                        .composition = PlanComposition::separate};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph);
  Solver device(scene, options);
  std::vector<Index> links;
  for (Index l = 0; l < static_cast<Index>(scene.links().size()); ++l) {
    links.push_back(l);
  }
  for (Solver* solver : {&serial, &device}) {
    const ToolId tool = solver->add_tool({}, ToolPose::Identity());
    solver->grasp(tool, std::array<Index, 3>{0, 3, 40}, 1e-4F);
  }
  for (int i = 0; i < 20; ++i) {
    for (Solver* solver : {&serial, &device}) {
      if (i == 6) {
        solver->tissue().apply({.remove_links = links});
      }
      if (i == 12) {
        solver->tissue().apply({.new_links = {{0, 60, 0, {1, 0}}, {3, 61, 1e-3F, {1, 1e-7F}}}});
      }
      solver->step(kTimeStep);
    }
    INFO("step " << i);
    REQUIRE(device.state_hash() == serial.state_hash());
    CHECK(device.tool_force(ToolId{0}) == serial.tool_force(ToolId{0}));
  }
}

// Small scenes have short lists of what a node moves. Would catch long ones that are summed up in
// another order than on a host, and holds near many nodes, or near more than are listed.
TEST_CASE("cuda solver: a coarse correction of a large body has the serial bits", "[device]") {
  const TetMesh mesh = testing::make_box({32, 18, 18}, 2e-3, 0.1);
  Scene scene;
  const Index body = scene.add_body(
      "block", mesh,
      {.model = ElasticModel::neo_hookean, .youngs_modulus = 1e4F, .poissons_ratio = 0.45F});
  scene.fix_where(body, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  SolverOptions options{
      .damping = 5, .math = MathMode::strict, .composition = PlanComposition::automatic};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  Solver device(scene, options);
  REQUIRE_THAT(device.plan().name, testing::ContainsSubstring("coarse correction"));
  const std::size_t held_share = GENERATE(2000, 7);  // one of so many vertices
  std::vector<Index> held;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (static_cast<std::size_t>(v) % held_share == 3 && !scene.is_fixed(v)) {
      held.push_back(v);
    }
  }
  for (Solver* const solver : {&serial, &device}) {
    solver->grasp(solver->add_tool({}, ToolPose::Identity()), held);
  }
  for (int i = 1; i <= 6; ++i) {
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(1e-3F, 5e-4F, -1e-3F) * static_cast<float>(i);
    for (Solver* const solver : {&serial, &device}) {
      solver->move_tool(ToolId{0}, pose);
      solver->step(kTimeStep);
    }
    INFO(device.backend_name() << ", held " << held.size() << ", step " << i);
    REQUIRE(device.state_hash() == serial.state_hash());
    REQUIRE(device.tool_force(ToolId{0}) == serial.tool_force(ToolId{0}));
  }
}

// Would catch sums in another order than the host's, lists of before an edit, and a correction of
// what a tool touches.
TEST_CASE("cuda solver: the momentum of free pieces has the serial bits", "[device]") {
  Scene scene;
  const Material material{.model = ElasticModel::neo_hookean};
  scene.add_body("large", testing::make_box({7, 7, 7}, 4e-3), material);
  scene.add_body("held", testing::make_box({8, 2, 2}, 4e-3, 0.1), material);
  scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 2,
                        .iterations = 3,
                        .copies = 2,
                        .math = MathMode::strict,
                        .composition = PlanComposition::separate};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  Solver device(scene, options);
  std::vector<Index> cut;
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
    const double x = scene.positions()[scene.tets()[t][0]].x();
    if (t >= scene.bodies()[1].first_tet && x > 0.011 && x < 0.013) {
      cut.push_back(t);
    }
  }
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : serial.positions()) {
    velocities.push_back(Eigen::Vector3f(3, -4, 5).cross(x));
  }
  for (Solver* solver : {&serial, &device}) {
    solver->write_velocities(velocities);
    solver->write_velocities(velocities, 1);
    solver->add_tool(std::vector<Capsule>{{{0, 0, 0}, {0.03F, 0, 0}, 3e-3F}},
                     ToolPose(Eigen::Translation3f(0, -0.1F, 0)), {ContactFeatures::vertices});
  }
  for (int i = 0; i < 30; ++i) {
    for (Solver* solver : {&serial, &device}) {
      if (i == 5) {
        solver->tissue().apply({.remove_tets = cut});
      }
      if (i == 10 || i == 20) {  // touches in one copy
        const float height = i == 10 ? -1e-3F : -0.1F;
        solver->move_tool(ToolId{0}, ToolPose(Eigen::Translation3f(0, height, 0.01F)), 1);
      }
      if (i == 15) {
        solver->tissue().undo();
      }
      solver->step(kTimeStep);
    }
    INFO("step " << i);
    REQUIRE(device.state_hash() == serial.state_hash());
    REQUIRE(device.state_hash(1) == serial.state_hash(1));
  }
}

// Would catch a kernel of all substeps that takes a neighbour for one of another substep or step,
// begins where the step before did not end, or loses count where counts start anew.
TEST_CASE("cuda solver: steps of vertex blocks between which all changes have the serial bits",
          "[device]") {
  const int sweeps = GENERATE(1, 3);
  const int substeps = GENERATE(1, 2, 5);
  Scene scene;
  const TetMesh block = testing::make_box({6, 4, 3}, testing::kEventfulEdge, 0.1);
  scene.add_body("block", block, {.model = ElasticModel::neo_hookean});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 2e-3; });
  scene.set_gravity({1, 0, -9.81F});
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = substeps,
                        .iterations = sweeps,
                        .copies = 2,
                        .math = MathMode::strict};
  options.over_relaxation = 1.2F;
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = DeviceStrategy::cooperative;
  Solver device(scene, options);
  const std::array<Solver*, 2> both{&serial, &device};
  for (Solver* each : both) {
    each->add_tool({}, ToolPose::Identity());
  }
  for (int round = 0; round < 120; ++round) {
    INFO(device.backend_name() << ", " << sweeps << " sweeps, round " << round);
    for (Solver* each : both) {
      if (round % 20 == 3) {
        each->grasp(ToolId(0), std::array<Index, 2>{100, 101}, 1e-3F, 1);
      } else if (round % 20 == 6) {
        each->release(ToolId(0), 1);
      } else if (round % 20 == 9) {
        std::vector<Eigen::Vector3f> v(static_cast<std::size_t>(each->vertex_count()),
                                       {0.01F * static_cast<float>(round % 7), 0, 0});
        each->write_velocities(v, 1);
      } else if (round % 20 == 12) {
        each->tissue().apply({.remove_tets = {3 * round}});
      }
    }
    const float dt = 1e-3F * static_cast<float>(1 + round / 5 % 3);
    serial.step(dt);
    device.step(dt);
    for (const Index copy : {0, 1}) {
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
    }
  }
}

TEST_CASE("cuda solver: automatic substeps and sweeps have the serial bits", "[device]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Scene scene;
  scene.add_body("bar", testing::make_box({6, 3, 3}, 4e-3, 0.1),
                 {.model = ElasticModel::neo_hookean, .damping = GENERATE(0.0F, 2e-3F)});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  SolverOptions options{.method = method,
                        .substeps = kAutomatic,
                        .iterations = kAutomatic,
                        .math = MathMode::strict,
                        .composition = PlanComposition::separate};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  Solver device(scene, options);
  for (const float dt : {5e-3F, 5e-3F, 1e-4F, 16e-3F, 5e-3F}) {
    serial.step(dt);
    device.step(dt);
    REQUIRE(device.state_hash() == serial.state_hash());
  }
}

// Grasps by several tools, tools that come later, and a step length that changes.
TEST_CASE("cuda solver: tools that share vertices have the serial forces", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  if (!testing::suits(strategy, method)) {
    return;
  }
  INFO("method " << static_cast<int>(method));
  const Scene scene = make_spring_block({6, 5, 5}, method);
  SolverOptions options{.method = method, .substeps = 3, .iterations = 2, .math = MathMode::strict};
  options.composition = PlanComposition::separate;
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  Solver device(scene, options);
  for (int i = 0; i < 30; ++i) {
    INFO("step " << i);
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0.02F, 0.022F - 2e-4F * static_cast<float>(i), 0.01F);
    for (Solver* solver : {&serial, &device}) {
      if (i == 3 || i == 6) {
        solver->add_tool({}, ToolPose::Identity());
      }
      if (i == 9) {
        const Capsule capsule{{0, 0, 0}, {0.004F, 0, 0}, 3e-3F};
        solver->add_tool({&capsule, 1}, pose, {ContactFeatures::vertices});
        solver->grasp(ToolId{0}, std::array<Index, 4>{150, 151, 152, 153}, 1e-5F);
      }
      if (i == 12) {
        solver->grasp(ToolId{1}, std::array<Index, 3>{152, 153, 160});
        solver->move_tool(ToolId{1}, ToolPose(Eigen::Translation3f(0, 1e-3F, 0)));
      }
      if (i == 20) {
        solver->release(ToolId{0});
        solver->grasp(ToolId{2}, std::array<Index, 1>{200});
      }
      if (i > 9) {
        solver->move_tool(ToolId{2}, pose);
      }
    }
    const float dt = i % 2 == 0 ? 1e-3F : 2e-3F;
    REQUIRE(equal(device.step(dt), serial.step(dt)));
    for (Index tool = 0; tool < (i < 3 ? 0 : i < 6 ? 1 : i < 9 ? 2 : 3); ++tool) {
      REQUIRE(device.tool_force(ToolId(tool)) == serial.tool_force(ToolId(tool)));
    }
    REQUIRE(device.state_hash() == serial.state_hash());
  }
}

// Would catch threads that miss each other where a block waits for nothing: they would wait for
// ever.
TEST_CASE("cuda solver: a cluster of one block sweeps on and on", "[device]") {
  const Scene scene = make_spring_block({4, 3, 3});
  SolverOptions options =
      pbdsurg::testing::small_steps({.substeps = 1, .iterations = 200, .math = MathMode::strict});
  options.composition = PlanComposition::separate;
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = DeviceStrategy::cluster;
  Solver device(scene, options);
  for (int i = 0; i < 100; ++i) {
    serial.step(kTimeStep);
    device.step(kTimeStep);
  }
  CHECK(device.state_hash() == serial.state_hash());
}

TEST_CASE("cuda solver: a scene of nothing, and one of vertices alone, step", "[device]") {
  Solver empty(Scene{}, pbdsurg::testing::small_steps({.executor = cuda::device()}));
  CHECK(equal(empty.step(kTimeStep), StepReport{}));
  Scene scene;
  const std::array<Eigen::Vector3d, 2> positions{Eigen::Vector3d::Zero(), Eigen::Vector3d::Ones()};
  scene.add_particles("two", positions, 1e-3);
  Solver falling(scene, pbdsurg::testing::small_steps({.executor = cuda::device()}));
  falling.step(kTimeStep);
  CHECK(falling.positions()[1].y() < 1);
}

// Large enough for clusters of sixteen blocks, and for several rounds a phase.
TEST_CASE("cuda solver: all blocks of a cluster together have the serial bits", "[device]") {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  const bool is_damped = mode == ProjectionMode::compliance && GENERATE(true, false);
  const TetMesh mesh = testing::make_box({24, 16, 14}, 4e-3, 0.1);
  Scene scene;
  Material springs = testing::kSprings;
  springs.damping = is_damped ? 5e-3F : 0.0F;
  springs.max_stretch = 1.15F;
  scene.add_body("springs", mesh, springs);
  if (mode == ProjectionMode::compliance) {
    scene.add_body("solid", testing::make_box({9, 8, 8}, 4e-3, 0.1),
                   {.model = ElasticModel::neo_hookean, .damping = springs.damping});
    scene.add_hinges(1, 1e-3F);
  }
  for (Index v = 0; v < 40; ++v) {
    scene.add_link({3 * v, 3 * v + 1000, 2e-2F, {0.3F, 1e-4F}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 2e-3; });
  SolverOptions options = pbdsurg::testing::small_steps(
      {.mode = mode, .substeps = 2, .iterations = 3, .math = MathMode::strict});
  options.composition = composition;
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = DeviceStrategy::cluster;
  Solver device(scene, options);
  std::vector<Eigen::Vector3f> stretched = serial.positions();
  for (Eigen::Vector3f& x : stretched) {
    x.x() *= 1.2F;
  }
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 6e-3F};
  for (Solver* solver : {&serial, &device}) {
    solver->write_positions(stretched);
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0.03F, 0.03F, 0.055F);
    solver->add_tool({&capsule, 1}, pose, {ContactFeatures::vertices});
    solver->add_tool({}, ToolPose::Identity());
    solver->grasp(ToolId{1}, std::array<Index, 4>{500, 2000, 3500, 5001}, 1e-5F);
  }
  for (int i = 0; i < 4; ++i) {
    INFO(device.backend_name() << ", step " << i);
    if (i == 2) {
      TopologyEdit edit;
      for (Index t = 0; t < 300; ++t) {
        edit.remove_tets.push_back(31 * t);
      }
      edit.remove_links = {3, 7};
      edit.rest_lengths = {{20000, 5e-3F}};
      serial.tissue().apply(edit);
      device.tissue().apply(edit);
    }
    REQUIRE(equal(device.step(5e-3F), serial.step(5e-3F)));
    REQUIRE(device.state_hash() == serial.state_hash());
    REQUIRE(device.tool_force(ToolId{0}) == serial.tool_force(ToolId{0}));
    REQUIRE(device.tool_force(ToolId{1}) == serial.tool_force(ToolId{1}));
  }
}

TEST_CASE("cuda solver: domains of a nested plan have the serial bits", "[device]") {
  const bool springs = GENERATE(true, false);
  const TetMesh mesh = testing::make_box({28, 21, 19}, 4e-3, 0.1);  // four domains
  Scene scene;
  Material material = elastic_material(mesh, 1000, 20e3);
  material.max_stretch = 1.2F;
  scene.add_body("block", mesh, springs ? material : Material{.model = ElasticModel::neo_hookean});
  scene.add_hinges(0, 1e-3F);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 2e-3; });
  SolverOptions options = pbdsurg::testing::small_steps({.substeps = 2, .math = MathMode::strict});
  options.composition = PlanComposition::nested;
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  Solver device(scene, options);
  std::vector<Eigen::Vector3f> stretched = serial.positions();
  for (Eigen::Vector3f& x : stretched) {
    x.x() *= 1.1F;
  }
  serial.write_positions(stretched);
  device.write_positions(stretched);
  for (int i = 0; i < 3; ++i) {
    REQUIRE(equal(device.step(5e-3F), serial.step(5e-3F)));
    REQUIRE(device.state_hash() == serial.state_hash());
  }
}

// Hinges that fold beyond a right angle, lose triangles, come back and come with new bodies.
TEST_CASE("cuda solver: hinges have the serial bits by each strategy, through edits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const bool by_vertices = method == SolverMethod::vertex_block;
  const float damping = GENERATE(0.0F, 2e-3F);
  const TetMesh plate = testing::make_box({9, 7, 1}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("plate", plate, {.model = ElasticModel::neo_hookean, .damping = damping});
  scene.add_hinges(0, 1e-3F);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 2e-3; });
  SolverOptions options =
      pbdsurg::testing::small_steps({.substeps = 2, .iterations = 3, .math = MathMode::strict});
  options.method = by_vertices ? SolverMethod::vertex_block : SolverMethod::projection;
  options.composition = PlanComposition::separate;
  if (!by_vertices && strategy != DeviceStrategy::cluster) {
    options.coloring.max_colors = GENERATE(0, 6);
  }
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  Solver device(scene, options);
  std::vector<Eigen::Vector3f> folded = serial.positions();
  for (Eigen::Vector3f& x : folded) {
    if (x.x() > 0.02F) {
      x = {0.02F - 0.3F * (x.x() - 0.02F), x.y(), x.z() + 0.9F * (x.x() - 0.02F)};
    }
  }
  TopologyEdit with_guest;
  with_guest.new_bodies.add_body("guest", testing::make_box({3, 3, 1}, 4e-3, 0.1),
                                 {.model = ElasticModel::neo_hookean, .damping = damping});
  with_guest.new_bodies.add_hinges(0, 1e-3F);
  for (Solver* solver : {&serial, &device}) {
    solver->write_positions(folded);
  }
  for (int i = 0; i < 6; ++i) {
    INFO(device.backend_name() << ", step " << i);
    for (Solver* solver : {&serial, &device}) {
      if (i == 1 || i == 3) {
        solver->tissue().apply({.remove_tets = {40 + i, 100, 101}});
      } else if (i == 2) {
        solver->tissue().undo();
      } else if (i == 4) {
        solver->tissue().apply(with_guest);
      }
    }
    REQUIRE(equal(device.step(5e-3F), serial.step(5e-3F)));
    REQUIRE(device.state_hash() == serial.state_hash());
  }
}

TEST_CASE("cuda solver: vertices that are lost are reported, and the rest goes on", "[device]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  INFO("method " << static_cast<int>(method));
  const Scene scene = make_spring_block({6, 5, 5}, method);
  SolverOptions options = pbdsurg::testing::small_steps(
      {.method = method, .executor = cuda::device(), .math = MathMode::strict});
  options.composition = PlanComposition::separate;
  Solver device(scene, options);
  options.executor = executor::serial();
  Solver serial(scene, options);
  std::vector<Eigen::Vector3f> velocities(static_cast<std::size_t>(scene.vertex_count()),
                                          Eigen::Vector3f::Zero());
  velocities[80] = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  for (Solver* solver : {&device, &serial}) {
    solver->write_velocities(velocities);
  }
  const StepReport report = device.step(20);
  CHECK(equal(report, serial.step(20)));
  CHECK(report.non_finite_vertices > 0);
  CHECK(std::isinf(report.distance_residual));
}

// Would catch an edit that reaches a step at work, or an undo that brings vertices back as they
// moved before that step.
TEST_CASE("cuda solver: an edit within a step is one after it", "[device]") {
  const Variant variant =
      GENERATE(Variant{}, Variant{.composition = PlanComposition::joint},
               Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
               Variant{.method = SolverMethod::vertex_block, .damping = 0.01F});
  const Scene scene = make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = options_of(variant);
  options.executor = executor::serial();
  Solver after(scene, options);
  options.executor = cuda::device();
  Solver within(scene, options);

  testing::check_edits_within_steps(within, after, [](const TopologyEdit&) {});
}

// Would catch a copy of all to the device for a change of a few.
TEST_CASE("cuda solver: an edit between steps costs about as much as the edit", "[device]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(make_spring_block({20, 20, 20}, method),
                pbdsurg::testing::small_steps({.method = method,
                                               .executor = cuda::device(),
                                               .composition = PlanComposition::separate}));
  solver.step(kTimeStep);
  const std::size_t before = solver.memory_bytes();
  for (Index t = 0; t < 20; ++t) {
    solver.tissue().apply({.remove_tets = {1000 * t}});
    solver.step(kTimeStep);
  }
  CHECK(solver.memory_bytes() - before < 100'000);
  CHECK(solver.step(kTimeStep).non_finite_vertices == 0);
}

// Would catch a step that cannot end because a block of its kernel does not go on, or one that was
// given up and leaves something behind.
TEST_CASE("cuda solver: a step that stalls is given up, and the next goes launch by launch",
          "[device]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const bool is_held = GENERATE(false, true);
  Scene scene;
  scene.add_body("bar", testing::make_box({6, 3, 3}, 4e-3, 0.1),
                 {.model = ElasticModel::neo_hookean});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.002; });
  SolverOptions options{.method = method, .copies = 2, .math = MathMode::strict};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = DeviceStrategy::cooperative;
  Solver device(scene, options);
  for (Solver* each : {&serial, &device}) {
    const ToolId tool = each->add_tool({}, ToolPose::Identity());
    if (is_held) {
      each->grasp(tool, std::array<Index, 2>{100, 101}, 0, 1);
    }
    each->watch(std::array<Index, 2>{100, 20});
    each->step(kTimeStep);
  }
  REQUIRE(std::string(device.backend_name()).find("cooperative") != std::string::npos);
  const std::uint32_t usual = cuda::longest_wait.exchange(0);
  const StepReport report = device.step(kTimeStep);
  cuda::longest_wait = usual;
  if (method == SolverMethod::explicit_steps && is_held) {  // launches as it is
    CHECK_FALSE(report.stalled);
    return;
  }
  REQUIRE(report.stalled);
  CHECK(report.substeps == 0);
  CHECK(report.non_finite_vertices == 0);
  CHECK(device.tool_force(ToolId(0), 1) == Eigen::Vector3f::Zero());
  for (int i = 0; i < 3; ++i) {
    for (const Index copy : {0, 1}) {
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
      REQUIRE(device.watched_positions(copy)[0] == serial.watched_positions(copy)[0]);
    }
    serial.step(kTimeStep);
    CHECK_FALSE(device.step(kTimeStep).stalled);
  }
  CHECK(std::string(device.backend_name()).find("graph") != std::string::npos);
}

}  // namespace pbdsurg
