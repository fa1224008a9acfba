// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <vector>

#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {

// Would catch a device that pushes vertices otherwise than the serial executor does, a kernel of
// all substeps that reads a neighbour too early or too late, or misses what an edit changed, or
// forces and gravity.
TEST_CASE("cuda explicit steps: strict has the serial bits, with tools and without", "[device]") {
  const auto strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  const bool has_tools = GENERATE(false, true);
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0, {4, 4, 3}, true);
  SolverOptions options{
      .method = SolverMethod::explicit_steps, .damping = 2, .copies = 2, .math = MathMode::strict};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  Solver device(scene, options);
  const std::array<Solver*, 2> both{&serial, &device};
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 0.01F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0.008F, 0.024F, 0.006F);
  std::vector<Eigen::Vector3f> v(static_cast<std::size_t>(serial.vertex_count()));
  for (std::size_t i = 0; i < v.size(); ++i) {
    v[i] = 0.1F * scene.positions()[i].cast<float>();
  }
  for (Solver* each : both) {
    each->write_velocities(v, 1);
    if (has_tools) {
      each->add_tool({&ball, 1}, pose, {ContactFeatures::vertices});
      each->grasp(each->add_tool({}, ToolPose::Identity()), std::array<Index, 2>{70, 71}, 1e-3F);
    }
  }
  Index contacts = 0;
  for (Index round = 0; round < 40; ++round) {
    INFO(device.backend_name() << ", tools " << has_tools << ", round " << round);
    const TopologyEdit edit = testing::eventful_edit(serial, round);
    pose.translation().y() -= 2e-4F;
    for (Solver* each : both) {
      if (round % 5 == 4) {
        each->tissue().apply(edit);
      }
      if (has_tools) {
        each->move_tool(ToolId(0), pose, 1);
      }
      if (round == 10) {
        each->set_forces(std::array<Index, 2>{30, 75},
                         std::array<Eigen::Vector3f, 2>{{{1e-4F, 0, 0}, {0, 0, -2e-4F}}}, 1);
      } else if (round == 20) {
        each->set_gravity(1, {0, 0, 5});
      } else if (round == 30) {
        each->clear_forces(1);
        each->set_gravity({1, -9, 0});
      }
    }
    REQUIRE(device.plan().longest_substep == serial.plan().longest_substep);
    const StepReport expected = serial.step(1e-3F);
    const StepReport report = device.step(1e-3F);
    CHECK(report.non_finite_vertices == expected.non_finite_vertices);
    CHECK(report.contacts == expected.contacts);
    contacts += expected.contacts;
    for (const Index copy : {0, 1}) {
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
      for (Index tool = 0; has_tools && tool < 2; ++tool) {
        REQUIRE(device.tool_force(ToolId(tool), copy) == serial.tool_force(ToolId(tool), copy));
      }
    }
  }
  CHECK((contacts > 0) == has_tools);
}

// Would catch a device that divides what is left of a step otherwise than hosts do, forgets between
// parts of a step the length of the substep before, forces of tools or contacts that were dropped,
// begins their way anew, or launches a recording of another part.
TEST_CASE("cuda explicit steps: strict has the serial bits in steps of several parts", "[device]") {
  const auto strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  const bool has_tools = GENERATE(false, true);
  const Scene scene = testing::make_uneven_bar();
  SolverOptions options{.method = SolverMethod::explicit_steps,
                        .damping = 1,
                        .contact_capacity = 4,
                        .copies = 2,
                        .math = MathMode::strict};
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = cuda::device();
  options.device_strategy = strategy;
  Solver device(scene, options);
  const std::array<Solver*, 2> both{&serial, &device};
  const Capsule ball{{0.012F, -0.012F, 0.003F}, {0.012F, -0.012F, 0.003F}, 0.0122F};
  for (Solver* each : both) {
    each->write_positions(testing::stretched(scene, 1.3F), 1);
    if (has_tools) {
      each->add_tool({&ball, 1}, ToolPose::Identity(), {ContactFeatures::vertices});
      each->grasp(each->add_tool({}, ToolPose::Identity()),
                  std::array<Index, 2>{scene.vertex_count() - 1, 30}, 1e-4F, 1);
    }
  }
  ToolPose pose = ToolPose::Identity();
  Index dropped = 0;
  int most = 0;
  for (int i = 0; i < 30; ++i) {
    const float dt = (i % 7 == 3 ? 2e-3F : 1e-3F) + 1e-4F * static_cast<float>(i % 3);
    INFO(device.backend_name() << ", tools " << has_tools << ", step " << i);
    pose.translation().y() += 0.2F * dt;
    for (Solver* each : both) {
      for (Index tool = 0; has_tools && tool < 2; ++tool) {
        each->move_tool(ToolId(tool), pose, 1);
      }
    }
    const StepReport expected = serial.step(dt);
    device.start_step(dt);
    if (i == 20) {  // an edit while the last part runs
      for (Solver* each : both) {
        each->tissue().apply({.remove_tets = std::vector<Index>{40, 41, 42}});
      }
    }
    const StepReport report = device.finish_step();
    REQUIRE(report.substeps == expected.substeps);
    CHECK(report.contacts == expected.contacts);
    CHECK(report.dropped_contacts == expected.dropped_contacts);
    dropped += expected.dropped_contacts.total();
    most = std::max(most, expected.substeps);
    for (const Index copy : {0, 1}) {
      REQUIRE(device.state_hash(copy) == serial.state_hash(copy));
      for (Index tool = 0; has_tools && tool < 2; ++tool) {
        REQUIRE(device.tool_force(ToolId(tool), copy) == serial.tool_force(ToolId(tool), copy));
      }
    }
  }
  CHECK((dropped > 0) == has_tools);
  CHECK(most > 100);
}

}  // namespace pbdsurg
