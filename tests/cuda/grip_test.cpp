// SPDX-License-Identifier: Apache-2.0
// Jaws that hold with a limit on a device: strict has the bits of the serial backend.
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/held_slab.h"
#include "tests/support/meshes.h"
#include "tests/support/soft_block.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::any_sweeping_method;
using testing::HeldSlab;
using testing::kUsualStep;
using testing::StrictPair;

void check_same_grip(const StrictPair& pair, ToolId tool, Index copy = 0) {
  const GripReport expected = pair.serial.tool_grip(tool, copy);
  const GripReport found = pair.device.tool_grip(tool, copy);
  REQUIRE(found.state == expected.state);
  CHECK(found.pull == expected.pull);
  CHECK(found.slid == expected.slid);
  CHECK(found.tear_limit == expected.tear_limit);
  CHECK(found.torn_vertices == expected.torn_vertices);
  CHECK(pair.device.tool_force(tool, copy) == pair.serial.tool_force(tool, copy));
  CHECK(pair.device.tool_torque(tool, copy) == pair.serial.tool_torque(tool, copy));
  REQUIRE(found.points.size() == expected.points.size());
  for (std::size_t i = 0; i < found.points.size(); ++i) {
    CHECK(found.points[i].anchor == expected.points[i].anchor);
    CHECK(found.points[i].force == expected.points[i].force);
  }
}

// The jaws of a slab, i steps of 8 mm/s away and turned a little.
ToolPose pulled(int i) {
  const auto steps = static_cast<float>(i);
  ToolPose pose = HeldSlab::pose({8e-3F * kUsualStep * steps, 0, 0.5e-3F * std::sin(0.2F * steps)});
  pose.rotate(Eigen::AngleAxisf(2e-3F * steps, Eigen::Vector3f::UnitY()));
  return pose;
}

Material damped() {
  return {.model = ElasticModel::neo_hookean, .youngs_modulus = 20e3F, .damping = 0.005F};
}

}  // namespace

// Would catch a grip that a device holds too firmly, lets slip too far or tells too late, and one
// that it goes on holding once it has torn.
TEST_CASE("cuda grip: what slips and tears has the serial bits", "[device]") {
  const SolverMethod method = any_sweeping_method();
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const HeldSlab slab(true, damped());
  StrictPair pair(slab.scene, {.method = method, .integration = integration},
                  DeviceStrategy::automatic);
  ToolId tool{};
  pair.both([&](Solver& solver) {
    tool = solver.add_tool({}, HeldSlab::pose());
    Grip grip = HeldSlab::grip(0.05F);
    grip.tear_strength = 8;
    solver.grasp(tool, slab.points(), grip);
  });
  bool has_slipped = false;
  for (int i = 1; i <= 300 && pair.serial.tool_grip(tool).state != GripState::torn; ++i) {
    pair.both([&](Solver& solver) {
      solver.move_tool(tool, pulled(i));
      if (has_slipped) {
        solver.set_clamp_force(tool, 5);  // so that it tears
      }
    });
    pair.step_and_compare(kUsualStep);
    check_same_grip(pair, tool);
    has_slipped |= pair.serial.tool_grip(tool).state == GripState::slipping;
  }
  CHECK(has_slipped);
  CHECK(pair.serial.tool_grip(tool).state == GripState::torn);
  CHECK(pair.device.lost_grips() == pair.serial.lost_grips());
  pair.step_and_compare(kUsualStep);
  CHECK(pair.device.tool_force(tool).norm() == 0);
}

// Would catch copies that hold with each other's jaws, and sweeps by launches that differ.
TEST_CASE("cuda grip: copies and strategies have the serial bits", "[device]") {
  const SolverMethod method = any_sweeping_method();
  const auto strategy =
      GENERATE(DeviceStrategy::graph, DeviceStrategy::stream, DeviceStrategy::automatic);
  const HeldSlab slab;
  StrictPair pair(slab.scene, {.method = method, .copies = 2}, strategy);
  ToolId tool{};
  pair.both([&](Solver& solver) {
    tool = solver.add_tool({}, HeldSlab::pose());
    for (const Index copy : {0, 1}) {
      solver.grasp(tool, slab.points(), HeldSlab::grip(copy == 0 ? 0.05F : 1), copy);
    }
  });
  for (int i = 1; i <= 20; ++i) {
    pair.both([&](Solver& solver) {
      for (const Index copy : {0, 1}) {
        solver.move_tool(tool, pulled(i), copy);
      }
    });
    pair.step_and_compare(kUsualStep);
    for (const Index copy : {0, 1}) {
      check_same_grip(pair, tool, copy);
    }
  }
  CHECK(pair.serial.tool_grip(tool, 0).state == GripState::slipping);
  CHECK(pair.serial.tool_grip(tool, 1).state == GripState::holding);
}

// Would catch points that a device draws in another order where a warp has no thread for each, and
// corners that it loses where there is no room for them near at hand.
TEST_CASE("cuda grip: a thousand points have the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::automatic);
  constexpr int kCells = 10;  // 1,331 vertices
  constexpr double kEdge = 3e-3;
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  const BodyId block =
      scene.add_body("block", testing::make_box({kCells, kCells, kCells}, kEdge, 0.1), damped());
  scene.fix_where(block, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kEdge; });
  // within what a block of a cluster has room for, and beyond
  const int layers = GENERATE(4, 11);
  StrictPair pair(scene, {.method = SolverMethod::projection}, strategy);
  ToolId tool{};
  const Eigen::Vector3f middle = Eigen::Vector3f::Constant(0.5F * kCells * float{kEdge});
  pair.both([&](Solver& solver) {
    tool = solver.add_tool({}, testing::at(middle));
    std::vector<TissuePoint> points;
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      if (scene.positions()[v].z() > (kCells + 0.5 - layers) * kEdge) {
        points.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
      }
    }
    Grip grip;
    grip.pad.half_length = grip.pad.half_width = 0.03F;
    grip.friction = 0.5F;
    grip.clamp_force = 0.02F;
    solver.grasp(tool, points, grip);
  });
  for (int i = 1; i <= 10; ++i) {
    pair.both([&](Solver& solver) {
      solver.move_tool(
          tool, testing::at(middle + Eigen::Vector3f(0.2e-3F * static_cast<float>(i), 0, 0)));
    });
    pair.step_and_compare(kUsualStep);
    check_same_grip(pair, tool);
  }
  CHECK(pair.serial.tool_grip(tool).slid > 0);
}

// Would catch points of edges and faces that jaws find otherwise, jaws that go on pushing, and
// points that an edit leaves without tissue.
TEST_CASE("cuda grip: jaws that close, hold through an edit and open have the serial bits",
          "[device]") {
  const SolverMethod method = any_sweeping_method();
  const HeldSlab slab;
  StrictPair pair(slab.scene, {.method = method, .damping = 5}, DeviceStrategy::automatic);
  constexpr float kRadius = 2e-3F, kHalf = 6e-3F;
  const auto jaw = [&](float side) {
    std::vector<Capsule> bars;
    for (const float x : {-3e-3F, 0.7e-3F, 4e-3F}) {
      const float height = side * (kHalf + kRadius);
      bars.push_back({{x, -8e-3F, height}, {x, 8e-3F, height}, kRadius});
    }
    return bars;
  };
  ToolId upper{}, lower{}, holder{}, other{};
  const ToolSurface surface{ContactFeatures::all, 0.3F};
  pair.both([&](Solver& solver) {
    upper = solver.add_tool(jaw(1), HeldSlab::pose(), surface);
    lower = solver.add_tool(jaw(-1), HeldSlab::pose(), surface);
    holder = solver.add_tool({}, HeldSlab::pose());
    other = solver.add_tool({}, HeldSlab::pose());  // holds some of the vertices, too
  });
  const auto step = [&] {
    pair.step_and_compare(kUsualStep);
    for (const ToolId tool : {upper, lower, holder, other}) {
      CHECK(pair.device.tool_force(tool) == pair.serial.tool_force(tool));
    }
    check_same_grip(pair, holder);
  };
  for (int i = 1; i <= 20; ++i) {
    const float depth = 3e-3F * static_cast<float>(i) / 20;
    pair.both([&](Solver& solver) {
      solver.move_tool(upper, HeldSlab::pose({0, 0, -depth}));
      solver.move_tool(lower, HeldSlab::pose({0, 0, depth}));
    });
    step();
  }
  std::array<std::size_t, 2> counts{};
  std::size_t* count = counts.data();
  pair.both([&](Solver& solver) {
    *count++ = solver.close_jaws(holder, {upper, lower}, HeldSlab::grip(0.2F));
  });
  REQUIRE(counts[0] >= 6);
  REQUIRE(counts[1] == counts[0]);
  const auto pull = [&](int steps) {
    for (int i = 1; i <= steps; ++i) {
      pair.both([&](Solver& solver) {
        for (const ToolId tool : {upper, lower, holder}) {
          ToolPose pose = solver.tool_pose(tool);
          pose.translation().x() += 0.1e-3F;
          solver.move_tool(tool, pose);
        }
      });
      step();
    }
  };
  pull(10);
  pair.both([&](Solver& solver) {
    solver.grasp(other, std::array{slab.held().front(), slab.held().back()}, 1e-3F);
  });
  pull(10);
  pair.both([&](Solver& solver) {
    TopologyEdit edit;
    const auto tets = solver.tissue().tets_at(slab.held().back());
    edit.remove_tets.assign(tets.begin(), tets.end());
    solver.tissue().apply(edit);
  });
  pull(5);
  pair.both([&](Solver& solver) { solver.tissue().undo(); });
  pull(5);
  pair.both([&](Solver& solver) { solver.release(holder); });
  for (int i = 0; i < 5; ++i) {
    step();
  }
}

}  // namespace pbdsurg
