// SPDX-License-Identifier: Apache-2.0
// Tools that meet surfaces on a device: strict has the bits of the serial backend.
#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <vector>

#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/free_block.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;
using testing::Approx;
using testing::at;
using testing::StrictPair;

constexpr float kStep = 5e-3F;
constexpr float kEdge = 3e-3F;

// Of springs where the mode knows nothing else.
Scene make_block(const SolverOptions& options = {}, Index cells_along = 6) {
  const std::array<Index, 3> cells{cells_along, cells_along, 3};
  Scene scene = options.mode == ProjectionMode::fraction
                    ? testing::make_soft_block(cells, kEdge, testing::kSprings)
                    : testing::make_soft_block(cells, kEdge);
  scene.set_gravity(Scene().gravity());
  return scene;
}

// A shaft with a hook at its end.
constexpr float kRadius = 1e-3F;
const std::array<Capsule, 2> kHook{Capsule{{0, 0, 0}, {0, 0, 40e-3F}, kRadius},
                                   Capsule{{0, 0, 0}, {5e-3F, 1e-3F, 0}, kRadius}};

// Presses, drags and lifts.
ToolPose hook_at(int step) {
  const float t = static_cast<float>(step) / 40;
  const Vector3f above(7.3e-3F, 8.1e-3F, 10.5e-3F);
  ToolPose pose = at(above + Vector3f(4e-3F * t, 2e-3F * t, -4e-3F * std::sin(3.1F * t)));
  pose.rotate(Eigen::AngleAxisf(0.6F * t, Vector3f::UnitY()));
  return pose;
}

void check_same_contacts(const StrictPair& pair, ToolId tool, Index copy = 0) {
  CHECK(pair.device.tool_force(tool, copy) == pair.serial.tool_force(tool, copy));
  CHECK(pair.device.tool_torque(tool, copy) == pair.serial.tool_torque(tool, copy));
  const std::vector<ToolContact> expected = pair.serial.tool_contacts(tool, copy);
  const std::vector<ToolContact> found = pair.device.tool_contacts(tool, copy);
  REQUIRE(found.size() == expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    INFO("contact " << i);
    CHECK(found[i].vertices == expected[i].vertices);
    CHECK(found[i].weights == expected[i].weights);
    CHECK(found[i].normal == expected[i].normal);
    CHECK(found[i].point == expected[i].point);
    CHECK(found[i].force == expected[i].force);
  }
}

SolverOptions any_options() {
  return GENERATE(SolverOptions{.method = SolverMethod::projection,
                                .mode = ProjectionMode::fraction,
                                .substeps = 2,
                                .iterations = 3,
                                .integration = TimeIntegration::implicit_euler},
                  SolverOptions{.method = SolverMethod::projection,
                                .substeps = 2,
                                .iterations = 4,
                                .integration = TimeIntegration::implicit_euler},
                  SolverOptions{.method = SolverMethod::projection,
                                .substeps = 2,
                                .iterations = 2,
                                .integration = TimeIntegration::bdf2},
                  SolverOptions{.method = SolverMethod::vertex_block,
                                .substeps = 1,
                                .iterations = 10,
                                .integration = TimeIntegration::implicit_euler},
                  SolverOptions{.method = SolverMethod::vertex_block,
                                .substeps = 2,
                                .iterations = 4,
                                .integration = TimeIntegration::bdf2},
                  SolverOptions{.method = SolverMethod::explicit_steps});
}

}  // namespace

// Would catch features that a kernel misses or meets twice, another order of contacts or of holds
// at a vertex, sides that it forgets between substeps, and forces, torques or lists of contacts
// that are not the host's.
TEST_CASE("cuda surfaces: a hook that presses, drags and lifts has the serial bits", "[device]") {
  const SolverOptions options = any_options();
  const float friction = GENERATE(0.0F, 0.3F);
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration), friction);
  const Scene scene = make_block(options);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId hook{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), {ContactFeatures::all, friction});
  });
  std::size_t most = 0;
  for (int i = 1; i <= 40; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) { solver.move_tool(hook, hook_at(i)); });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, hook);
    most = std::max(most, pair.serial.tool_contacts(hook).size());
  }
  CHECK(most > 5);
}

// Would catch walls that a rod takes along on the host alone, in another order, or once more after
// a part of a step; and pushes that its force leaves out. With no room for contacts, nothing else
// stops what passes.
TEST_CASE("cuda surfaces: a rod that is thrust about in a free tube has the serial bits",
          "[device]") {
  SolverOptions options = any_options();
  if (options.mode == ProjectionMode::fraction || options.method == SolverMethod::explicit_steps) {
    return;  // they know no sheets
  }
  options.contact_capacity = GENERATE(4096, 0);
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration),
          options.contact_capacity);
  const testing::SheetMesh mesh = testing::make_square_tube(10e-3, 60e-3);
  Scene scene;
  scene.add_sheet("tube", mesh.positions, mesh.triangles, {});
  scene.set_gravity(Vector3f::Zero());
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  const Capsule rod{{0, 0, -1}, {0, 0, 1}, 0.5e-3F};
  ToolId tool{};
  pair.both([&](Solver& solver) {
    tool = solver.add_tool({&rod, 1}, at(Vector3f::Zero()), {ContactFeatures::all, 0});
  });
  for (int i = 1; i <= 60; ++i) {
    CAPTURE(i);
    const float gone = 15e-3F * std::sin(0.2F * static_cast<float>(i));
    pair.both([&](Solver& solver) { solver.move_tool(tool, at(gone * Vector3f(0.8F, 0.6F, 0))); });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, tool);
    CHECK(testing::is_around(pair.serial.positions(), gone * Vector3f(0.8F, 0.6F, 0)));
  }
}

// Would catch links of particles that a kernel passes over, or takes for triangles.
TEST_CASE("cuda surfaces: a hook that lifts a thread has the serial bits", "[device]") {
  const SolverOptions options = any_options();
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration));
  constexpr float kLink = 8e-3F, kSlack = 1.1F, kHeight = 16e-3F;
  Scene scene = make_block(options);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 4; ++i) {
    points.emplace_back(kLink * static_cast<float>(i), 2e-3, kHeight);
  }
  const BodyId thread = scene.add_particles("thread", points, 1e-4);
  scene.fix_vertices(thread, std::array{0, 3});
  const Index first = scene.body(thread).first_vertex;
  for (Index i = 0; i < 3; ++i) {
    scene.add_link({first + i, first + i + 1, kSlack * kLink, {.compliance = 1e-3F}});
  }
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  const Capsule across{{0, -6e-3F, 0}, {0, 6e-3F, 0}, kRadius};
  const auto below = [](int step) {
    return at({1.4F * kLink, 2e-3F, kHeight - 4e-3F + 0.2e-3F * static_cast<float>(step)});
  };
  ToolId hook{};
  pair.both([&](Solver& solver) { hook = solver.add_tool({&across, 1}, below(0)); });
  std::size_t most = 0;
  for (int i = 1; i <= 40; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) { solver.move_tool(hook, below(i)); });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, hook);
    most = std::max(most, pair.serial.tool_contacts(hook).size());
  }
  CHECK(most > 0);
}

// Would catch a device that places capsules where no joint takes them, or keeps what a tool had
// that was removed: other tools go on.
TEST_CASE("cuda surfaces: joints turn and tools go with the serial bits", "[device]") {
  const SolverOptions options = any_options();
  const ToolSurface surface = GENERATE(ToolSurface{}, ToolSurface{ContactFeatures::all, 0.3F});
  CAPTURE(static_cast<int>(options.method), static_cast<int>(surface.features));
  StrictPair pair(make_block(options), options, DeviceStrategy::automatic);
  ToolId hook{}, ball{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), surface,
                           std::array{ToolJoint{{0, 0, 0}, {0, 0, 1}, 1, 1}});
    ball = solver.add_tool(std::array{Capsule{{0, 0, 0}, {0, 0, 0}, 2e-3F}},
                           at({4e-3F, 12e-3F, 10.5e-3F}), surface);
  });
  std::size_t touched = 0;
  for (int i = 1; i <= 30; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) {
      if (i == 20) {
        solver.remove_tool(hook);
      }
      if (i < 20) {
        solver.move_tool(hook, hook_at(i));
        solver.set_joint(hook, 0, 0.05F * static_cast<float>(i));
      }
    });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, ball);
    if (i < 20) {
      check_same_contacts(pair, hook);
      touched += pair.serial.tool_force(hook).norm() > 0 ? 1 : 0;
    }
  }
  CHECK(touched > 5);
}

// Would catch a rigid move of a piece, or what BDF2 takes back of a push, that is summed in another
// order, and friction with a half space.
TEST_CASE("cuda surfaces: a block that falls on a slope and slides has the serial bits",
          "[device]") {
  const TimeIntegration integration = testing::any_integration();
  SolverOptions options = testing::vertex_blocks(integration);
  options.iterations = 10;
  options.substeps = 1;
  const float friction = GENERATE(0.1F, 0.5F);
  Scene scene = testing::make_free_block();
  scene.set_gravity(testing::gravity_on(0.3F));
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId slope{}, ball{};
  const Capsule sphere{{0, 0, 0}, {0, 0, 0}, 3e-3F};
  pair.both([&](Solver& solver) {
    slope = solver.add_half_space({{0, 0, -1e-3F}}, friction);
    ball = solver.add_tool({&sphere, 1}, at({40e-3F, 10e-3F, 3e-3F}), {ContactFeatures::all, 0.2F});
  });
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    pair.step_and_compare(kStep);
    check_same_contacts(pair, slope);
    check_same_contacts(pair, ball);
  }
  CHECK(pair.serial.tool_force(slope).z() < 0);
}

// Would catch triangles that edits bring or take and nobody sends, and tools that come, hold or let
// go while others touch.
TEST_CASE("cuda surfaces: edits and other tools in contact keep the serial bits", "[device]") {
  const SolverOptions options = any_options();
  const Scene scene = make_block(options);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId hook{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), {ContactFeatures::all, 0.2F});
  });
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 2.5e-3F};
  for (int i = 1; i <= 30; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) {
      solver.move_tool(hook, hook_at(i));
      if (i == 8) {
        solver.tissue().apply(
            {.remove_tets = {100, 101, 102, 103, 104, 105, 400, 401, 402, 403, 404, 405}});
      } else if (i == 12) {
        solver.tissue().undo();
      } else if (i == 15) {  // one that meets vertices alone, and one that holds some
        static_cast<void>(solver.add_tool({&ball, 1}, at({12e-3F, 12e-3F, 10e-3F}),
                                          {ContactFeatures::vertices, 0}));
        const ToolId jaws = solver.add_tool({}, at({0, 0, 10e-3F}));
        const Index corner = solver.vertex_count() - 1;
        solver.grasp(jaws, {&corner, 1}, 1e-3F);
      } else if (i == 20) {
        solver.grasp(hook, std::array<Index, 1>{solver.vertex_count() - 4});
      } else if (i == 24) {
        solver.release(hook);
      }
    });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, hook);
  }
}

// Would catch a spring that a device forgets between substeps, sums up in another order or leaves
// out of what it tells; one that is taken off, or comes later; and arms of torques without it.
TEST_CASE("cuda surfaces: hooks on springs have the serial bits", "[device]") {
  SolverOptions options = any_options();
  if (options.method == SolverMethod::explicit_steps) {
    return;  // which have none
  }
  options.copies = GENERATE(1, 2);
  const float friction = GENERATE(0.0F, 0.3F);
  CAPTURE(static_cast<int>(options.method), static_cast<int>(options.integration), friction);
  const Scene scene = make_block(options);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId hook{}, other{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), {ContactFeatures::all, friction});
    other = solver.add_tool(kHook, at({30e-3F, 8e-3F, 12e-3F}), {ContactFeatures::all, friction});
    solver.couple_tool(hook, {.stiffness = 300});
  });
  Snapshot serial, device;
  float farthest = 0;
  for (int i = 1; i <= 40; ++i) {
    CAPTURE(i);
    if (i == 20) {
      serial = pair.serial.snapshot();
      device = pair.device.snapshot();
    } else if (i == 25) {
      pair.serial.restore(serial);
      pair.device.restore(device);
    }
    pair.both([&](Solver& solver) {
      for (Index copy = 0; copy < options.copies; ++copy) {
        solver.move_tool(hook, hook_at(i + 3 * copy), copy);
        solver.move_tool(other, at({12e-3F, 9e-3F, 12e-3F - 1e-4F * static_cast<float>(i)}), copy);
      }
      if (i == 15) {
        solver.couple_tool(other, {.stiffness = 1000});
      } else if (i == 35) {
        solver.couple_tool(hook, {});
      }
    });
    pair.step_and_compare(kStep);
    for (Index copy = 0; copy < options.copies; ++copy) {
      CAPTURE(copy);
      check_same_contacts(pair, hook, copy);
      check_same_contacts(pair, other, copy);
      for (const ToolId tool : {hook, other}) {
        const Vector3f is_at = pair.serial.tool_pose(tool, copy).translation();
        CHECK(pair.device.tool_pose(tool, copy).translation() == is_at);
        farthest =
            std::max(farthest, (pair.serial.tool_target(tool, copy).translation() - is_at).norm());
      }
    }
  }
  CHECK(farthest > 1e-4F);
}

// Would catch a half space that a device leaves where it is to be, and pieces that balance on one.
TEST_CASE("cuda surfaces: a table on a spring has the serial bits", "[device]") {
  const SolverOptions options = testing::vertex_blocks(testing::any_integration());
  const float friction = GENERATE(0.0F, 0.3F);
  const Scene scene = testing::make_free_block();
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId table{};
  pair.both([&](Solver& solver) {
    table = solver.add_half_space({}, friction);
    solver.couple_tool(table, {.stiffness = 300});
  });
  for (int i = 1; i <= 30; ++i) {
    CAPTURE(i);
    pair.step_and_compare(kStep);
    check_same_contacts(pair, table);
    CHECK(pair.device.tool_pose(table).translation() == pair.serial.tool_pose(table).translation());
  }
  CHECK(pair.serial.tool_pose(table).translation().z() < -1e-7F);
}

// Would catch plates that a device takes for capsules, or turns without their width.
TEST_CASE("cuda surfaces: a plate that presses and turns has the serial bits", "[device]") {
  const SolverOptions options = any_options();
  const ToolSurface surface = GENERATE(ToolSurface{}, ToolSurface{ContactFeatures::all, 0.3F},
                                       ToolSurface{ContactFeatures::vertices});
  CAPTURE(static_cast<int>(options.method), static_cast<int>(surface.features), surface.friction);
  StrictPair pair(make_block(options), options, DeviceStrategy::automatic);
  const std::array blade{Capsule{{-3e-3F, -2e-3F, 0}, {3e-3F, -2e-3F, 0}, kRadius, {0, 4e-3F, 0}}};
  const auto blade_at = [](int step) {
    const float t = static_cast<float>(step) / 30;
    ToolPose pose = at({8e-3F + 2e-3F * t, 9e-3F, 10e-3F - 3e-3F * t});
    pose.rotate(Eigen::AngleAxisf(1.5F * t, Vector3f::UnitX()));
    return pose;
  };
  ToolId tool{};
  pair.both([&](Solver& solver) { tool = solver.add_tool(blade, blade_at(0), surface); });
  for (int i = 1; i <= 30; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) { solver.move_tool(tool, blade_at(i)); });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, tool);
  }
  CHECK(pair.serial.tool_force(tool).norm() > 1e-3F);
}

// Would catch lists that go wrong where there are more contacts than threads of a block, than it
// has near at hand, or than there is room for.
TEST_CASE("cuda surfaces: hundreds of contacts at once have the serial bits", "[device]") {
  SolverOptions options = any_options();
  const Index cells_along = GENERATE(10, 14);
  const bool is_room_small = GENERATE(false, true);
  options.contact_capacity = is_room_small ? 200 : options.contact_capacity;
  CAPTURE(static_cast<int>(options.method), cells_along, is_room_small);
  StrictPair pair(make_block(options, cells_along), options, DeviceStrategy::automatic);
  constexpr float kWide = 0.2F;  // m: a radius, whose margin reaches all of the block's top
  const float middle = 0.5F * kEdge * static_cast<float>(cells_along);
  ToolId roller{};
  pair.both([&](Solver& solver) {
    roller = solver.add_tool(std::array{Capsule{{-0.1F, 0, 0}, {0.1F, 0, 0}, kWide}},
                             at({middle, middle, 3 * kEdge + kWide}), {ContactFeatures::all, 0.3F});
  });
  std::size_t most = 0;
  for (int i = 1; i <= 5; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) {
      solver.move_tool(roller,
                       at({middle, middle, 3 * kEdge + kWide - 1e-4F * static_cast<float>(i)}));
    });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, roller);
    most = std::max(most, pair.serial.tool_contacts(roller).size());
  }
  CHECK(most > (is_room_small ? 100U : cells_along == 10 ? 256U : 512U));
}

// Would catch contacts of one copy in another's place.
TEST_CASE("cuda surfaces: copies with hooks of their own have the serial bits", "[device]") {
  SolverOptions options = any_options();
  options.copies = 3;
  const Scene scene = make_block(options);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId hook{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), {ContactFeatures::all, 0.3F});
  });
  for (int i = 1; i <= 15; ++i) {
    CAPTURE(i);
    pair.both([&](Solver& solver) {
      for (Index copy = 0; copy < options.copies; ++copy) {
        solver.move_tool(hook, hook_at((copy + 1) * i), copy);
      }
    });
    pair.step_and_compare(kStep);
    for (Index copy = 0; copy < options.copies; ++copy) {
      CAPTURE(copy);
      check_same_contacts(pair, hook, copy);
    }
  }
}

// Would catch a device that forgets what it touches when a state is written, and one that drops
// other contacts than a host.
TEST_CASE("cuda surfaces: snapshots and a small capacity keep the serial bits", "[device]") {
  SolverOptions options = any_options();
  options.contact_capacity = GENERATE(4096, 6);
  const Scene scene = make_block(options);
  StrictPair pair(scene, options, DeviceStrategy::automatic);
  ToolId hook{};
  pair.both([&](Solver& solver) {
    hook = solver.add_tool(kHook, hook_at(0), {ContactFeatures::all, 0.3F});
  });
  Snapshot serial, device;
  for (int i = 1; i <= 20; ++i) {
    CAPTURE(i);
    if (i == 8) {
      serial = pair.serial.snapshot();
      device = pair.device.snapshot();
    } else if (i == 14) {
      pair.serial.restore(serial);
      pair.device.restore(device);
    }
    pair.both([&](Solver& solver) { solver.move_tool(hook, hook_at(i)); });
    pair.step_and_compare(kStep);
    check_same_contacts(pair, hook);
    CHECK(pair.device.last_report().dropped_contacts == pair.serial.last_report().dropped_contacts);
  }
}

// Would catch fast kernels that are another computation.
TEST_CASE("cuda surfaces: fast kernels feel what the serial backend feels", "[device]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = make_block();
  Solver serial(scene, {.method = method, .executor = executor::serial()});
  Solver device(scene, {.method = method, .executor = cuda::device()});
  for (Solver* const solver : {&serial, &device}) {
    const ToolId hook = solver->add_tool(kHook, hook_at(0), {ContactFeatures::all, 0.2F});
    for (int i = 1; i <= 60; ++i) {
      solver->move_tool(hook, hook_at(std::min(i, 20)));
      solver->step(kStep);
    }
  }
  const Vector3f expected = serial.tool_force(ToolId(0));
  CHECK(expected.z() > 0.05F);
  CHECK((device.tool_force(ToolId(0)) - expected).norm() < 0.02F * expected.norm());
  CHECK((device.tool_torque(ToolId(0)) - serial.tool_torque(ToolId(0))).norm() <
        0.02F * serial.tool_torque(ToolId(0)).norm());
}

}  // namespace pbdsurg
