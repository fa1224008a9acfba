// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::at;
using testing::ContainsSubstring;
using testing::make_soft_block;

constexpr float kStep = 5e-3F;
constexpr ToolSurface kAll{ContactFeatures::all, 0};

// Presses from above to a depth within half a second, and waits.
void press(Solver& solver, ToolId tool, const Eigen::Vector3f& touch, float depth, int wait = 100) {
  constexpr int kSteps = 100;
  for (int i = 0; i < kSteps + wait; ++i) {
    const float share = std::min(1.0F, static_cast<float>(i + 1) / kSteps);
    solver.move_tool(tool, at(touch - Eigen::Vector3f(0, 0, share * depth)));
    solver.step(kStep);
  }
}

float gap_of(const ToolContact& contact, const std::vector<Eigen::Vector3f>& positions) {
  Eigen::Vector3f x = Eigen::Vector3f::Zero();
  for (int k = 0; k < 3 && contact.vertices[k] != kInvalidIndex; ++k) {
    x += contact.weights[k] * positions[contact.vertices[k]];
  }
  return contact.normal.dot(x - contact.point);
}

SolverMethod any_method() {
  return GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
}

}  // namespace

// Would catch a tool that feels nothing between vertices: a ball of 1 mm on edges of 3 mm, above a
// vertex, the middle of an edge and the middle of a triangle.
TEST_CASE("surface contact: a thin tool feels tissue wherever it meets it", "[validation]") {
  const SolverMethod method = any_method();
  const auto offset =
      GENERATE(Eigen::Vector2f(0, 0), Eigen::Vector2f(0.5F, 0), Eigen::Vector2f(0.6F, 0.3F));
  constexpr float kEdge = 3e-3F, kRadius = 1e-3F, kDepth = 2e-3F;
  CAPTURE(static_cast<int>(method), offset.x(), offset.y());
  Solver solver(make_soft_block({6, 6, 3}, kEdge), {.method = method});
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, kRadius};
  const Eigen::Vector3f touch(kEdge * (3 + offset.x()), kEdge * (3 + offset.y()),
                              3 * kEdge + kRadius);
  const ToolId tool = solver.add_tool({&ball, 1}, at(touch), kAll);

  press(solver, tool, touch, kDepth);

  const Eigen::Vector3f force = solver.tool_force(tool);
  const std::vector<ToolContact> contacts = solver.tool_contacts(tool);
  const std::vector<Eigen::Vector3f> positions = solver.positions();
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  float deepest = 0;
  for (const ToolContact& contact : contacts) {
    sum += contact.force;
    deepest = std::min(deepest, gap_of(contact, positions));
  }
  // an elastic half space answers a flat punch of this radius with 2 a E / (1 - nu^2) a meter
  const float punch = 2 * kRadius * 10e3F / (1 - 0.45F * 0.45F) * kDepth;
  CHECK(force.z() > 0.7F * punch);
  CHECK(force.z() < 4 * punch);
  CHECK(deepest > -1e-2F * kEdge);
  CHECK((sum - force).norm() < 0.1F * force.norm());
}

// Would catch a thick tool that firm contacts push by turns too far and not at all.
TEST_CASE("surface contact: a wide ball feels the same with more sweeps", "[validation]") {
  constexpr float kEdge = 3e-3F, kWide = 0.2F;
  constexpr int kLast = 50;
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, kWide};
  const Eigen::Vector3f touch(3 * kEdge, 3 * kEdge, 3 * kEdge + kWide);
  const auto felt = [&](const SolverOptions& options) {
    Solver solver(make_soft_block({6, 6, 3}, kEdge), options);
    const ToolId tool = solver.add_tool({&ball, 1}, at(touch), kAll);
    press(solver, tool, touch, 1e-3F, 50);
    float sum = 0;  // the set of contacts changes from step to step
    for (int i = 0; i < kLast; ++i) {
      solver.step(kStep);
      sum += solver.tool_force(tool).z();
    }
    return sum / kLast;
  };
  CHECK(felt({}) == Approx(felt({.iterations = 10})).epsilon(0.04));
}

// Would catch contacts that stay where their features were when a substep began: tissue trembles at
// a thin hook, edges slip past it, and its force depends on the length of steps.
TEST_CASE("surface contact: soft tissue at a thin hook comes to rest", "[validation]") {
  constexpr float kEdge = 2e-3F, kDepth = 2e-3F;
  constexpr int kPlaces = 6, kSteps = 500;
  const std::array<Capsule, 2> hook{Capsule{{0, 0, 0}, {3e-3F, 0, 1e-3F}, 0.5e-3F},
                                    Capsule{{3e-3F, 0, 1e-3F}, {3e-3F, 0, 12e-3F}, 0.6e-3F}};
  for (int place = 0; place < kPlaces; ++place) {
    std::array<float, 2> forces{};
    float moved = 0;
    for (const int substeps : {1, 4}) {
      Scene scene;
      const BodyId fat =
          scene.add_body("fat", testing::make_box({10, 10, 4}, double{kEdge}),
                         {.model = ElasticModel::neo_hookean, .youngs_modulus = 2e3F});
      scene.fix_where(fat, [](const Eigen::Vector3d& x) { return x.z() < 1e-9; });
      Solver solver(scene, {.substeps = substeps, .iterations = 4, .damping = 20});
      const auto turn = static_cast<float>(place);
      const Eigen::Vector3f touch(9e-3F + 0.3e-3F * turn, 10e-3F - 0.2e-3F * turn,
                                  4 * kEdge + 0.5e-3F);
      ToolPose pose(Eigen::Translation3f(touch) *
                    Eigen::AngleAxisf(turn, Eigen::Vector3f::UnitZ()));
      const ToolId tool = solver.add_tool(hook, pose, kAll);
      for (int i = 1; i <= kSteps; ++i) {
        const float share = std::min(1.0F, static_cast<float>(i) / 200);
        pose.translation() = touch - Eigen::Vector3f(0, 0, share * kDepth);
        solver.move_tool(tool, pose);
        const std::vector<Eigen::Vector3f> before = solver.positions();
        solver.step(kStep);
        if (i > kSteps - 50) {
          for (std::size_t v = 0; v < before.size(); ++v) {
            moved = std::max(moved, (solver.positions()[v] - before[v]).norm());
          }
        }
      }
      forces[substeps == 1 ? 0 : 1] = solver.tool_force(tool).norm();
    }
    CAPTURE(place);
    CHECK(forces[0] == Approx(forces[1]).epsilon(0.02));
    CHECK(moved < 1e-2F * kEdge);
  }
}

// Would catch contacts too soft for the few sweeps of a substep: edges slip past a thin rod that
// lies flat and is pressed quickly, which then feels next to nothing.
TEST_CASE("surface contact: edges do not slip past a thin rod", "[validation]") {
  constexpr float kEdge = 2e-3F, kDepth = 4e-3F, kSpeed = 0.1F, kRadius = 0.5e-3F;
  constexpr int kPlaces = 8, kSteps = 30;
  const Capsule rod{{-8e-3F, 0, 0}, {8e-3F, 0, 0}, kRadius};
  float force = 0;
  for (int place = 0; place < kPlaces; ++place) {
    Solver solver(make_soft_block({12, 12, 5}, kEdge), {.damping = 20});
    const auto shift = static_cast<float>(place);
    const Eigen::Vector3f touch(11.1e-3F + 0.21e-3F * shift, 12.9e-3F - 0.17e-3F * shift,
                                5 * kEdge + kRadius);
    ToolPose pose(Eigen::Translation3f(touch) *
                  Eigen::AngleAxisf(0.1F + 0.37F * shift, Eigen::Vector3f::UnitZ()));
    const ToolId tool = solver.add_tool({&rod, 1}, pose, kAll);
    for (int i = 1; i <= kSteps; ++i) {
      const float gone = kSpeed * kStep * static_cast<float>(i);
      pose.translation() = touch - Eigen::Vector3f(0, 0, std::min(gone, kDepth));
      solver.move_tool(tool, pose);
      solver.step(kStep);
    }
    force += solver.tool_force(tool).z() / kPlaces;
  }
  CHECK(force > 0.25F);  // N
}

// Would catch a list of near features that is too short, or serves for too long: where a vertex
// flies by many radii in a step, no list serves, and all features are gone through.
TEST_CASE("surface contact: lists of near features leave nothing out", "[equivalence]") {
  const SolverMethod method = any_method();
  const std::array<Capsule, 2> hook{Capsule{{0, 0, 0}, {0, 0, 40e-3F}, 1e-3F},
                                    Capsule{{0, 0, 0}, {5e-3F, 1e-3F, 0}, 1e-3F}};
  Scene scene = make_soft_block({6, 6, 3}, 3e-3);
  const Index stray = scene.vertex_count();
  scene.add_particles("stray", std::vector<Eigen::Vector3d>{{1, 0, 0}}, 1e-3);
  Solver solver(scene, {.method = method, .copies = 2});
  std::vector<Eigen::Vector3f> velocities(static_cast<std::size_t>(solver.vertex_count()),
                                          Eigen::Vector3f::Zero());
  velocities[stray].x() = 2;
  solver.write_velocities(velocities, 1);
  const ToolId tool = solver.add_tool(hook, at({7e-3F, 8e-3F, 10.5e-3F}), kAll);
  std::size_t most = 0;
  for (int i = 1; i <= 80; ++i) {
    CAPTURE(i);
    const float t = static_cast<float>(i) / 40;
    const Eigen::Vector3f tip(7e-3F + 4e-3F * t, 8e-3F + 2e-3F * t,
                              10.5e-3F - 4e-3F * std::sin(3 * t));
    for (Index copy = 0; copy < 2; ++copy) {
      solver.move_tool(tool, at(tip), copy);
    }
    if (i == 30) {
      solver.tissue().apply({.remove_tets = {100, 101, 102, 400, 401}});
    }
    solver.step(kStep);
    std::vector<Eigen::Vector3f> listed = solver.positions(0), all = solver.positions(1);
    CHECK(all[stray].x() > listed[stray].x());
    listed[stray] = all[stray];
    REQUIRE(listed == all);
    REQUIRE(solver.tool_force(tool, 0) == solver.tool_force(tool, 1));
    REQUIRE(solver.tool_torque(tool, 0) == solver.tool_torque(tool, 1));
    most = std::max(most, solver.tool_contacts(tool).size());
  }
  CHECK(most > 5);
}

// Would catch explicit steps that leave out edges and triangles, or count a force twice.
TEST_CASE("surface contact: explicit steps come to the same force", "[validation]") {
  constexpr float kEdge = 3e-3F, kRadius = 1e-3F;
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, kRadius};
  const Eigen::Vector3f touch(3.6F * kEdge, 3.3F * kEdge, 3 * kEdge + kRadius);
  const auto force_by = [&](const SolverOptions& options) {
    Solver solver(make_soft_block({6, 6, 3}, kEdge), options);
    const ToolId tool = solver.add_tool({&ball, 1}, at(touch), kAll);
    press(solver, tool, touch, 1e-3F);
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    constexpr int kSteps = 40;  // it trembles
    for (int i = 0; i < kSteps; ++i) {
      solver.step(kStep);
      sum += solver.tool_force(tool);
    }
    return Eigen::Vector3f(sum / kSteps);
  };
  const Eigen::Vector3f expected = force_by({.method = SolverMethod::vertex_block});
  const Eigen::Vector3f found = force_by({.method = SolverMethod::explicit_steps, .damping = 20});
  CHECK((found - expected).norm() < 0.05F * expected.norm());
}

// Would catch weights or normals that make a tool slide off, or a torque with the wrong lever.
TEST_CASE("surface contact: a bar that lies flat feels a force in its middle", "[validation]") {
  const SolverMethod method = any_method();
  Solver solver(make_soft_block({6, 6, 3}, 3e-3), {.method = method});
  const Capsule bar{{0, -20e-3F, 0}, {0, 20e-3F, 0}, 1e-3F};
  const Eigen::Vector3f touch(9e-3F, 9e-3F, 10e-3F);
  const ToolId tool = solver.add_tool({&bar, 1}, at(touch), kAll);

  press(solver, tool, touch, 1.5e-3F);

  const Eigen::Vector3f force = solver.tool_force(tool), torque = solver.tool_torque(tool);
  CHECK(force.z() > 0.1F);
  CHECK(std::hypot(force.x(), force.y()) < 0.4F * force.z());  // tetrahedra have no symmetry
  CHECK(torque.norm() < 2e-3F * force.z());                    // 2 mm of lever

  // the same forces around another origin
  Solver shifted(make_soft_block({6, 6, 3}, 3e-3), {.method = method});
  const Eigen::Vector3f lever(10e-3F, 0, 0);
  const Capsule beside{bar.start + lever, bar.end + lever, bar.radius};
  const ToolId other = shifted.add_tool({&beside, 1}, at(touch - lever), kAll);
  press(shifted, other, touch - lever, 1.5e-3F);
  CHECK(shifted.tool_force(other).z() == Approx(force.z()).epsilon(1e-3));
  CHECK(shifted.tool_torque(other).y() - torque.y() ==
        Approx(-lever.x() * force.z()).epsilon(2e-2));
}

// Would catch friction that creeps, and multipliers that are no forces.
TEST_CASE("surface contact: what lies on a slope below the angle of friction stays",
          "[validation]") {
  const SolverMethod method = any_method();
  constexpr float kFriction = 0.3F, kEdge = 5e-3F;
  const float angle = 0.95F * std::atan(kFriction);
  const Eigen::Vector3f down = 9.81F * Eigen::Vector3f(std::sin(angle), 0, -std::cos(angle));
  Scene scene;
  scene.add_body("block", testing::make_box({4, 4, 2}, kEdge),
                 {.youngs_modulus = 20e3F, .poissons_ratio = 0.4F, .damping = 0.01F});
  scene.set_gravity(down);
  Solver solver(scene, {.method = method});
  const ToolId slope = solver.add_half_space({}, kFriction);
  const auto mean = [&] {
    Eigen::Vector3f sum = Eigen::Vector3f::Zero();
    for (const Eigen::Vector3f& x : solver.positions()) {
      sum += x;
    }
    return Eigen::Vector3f(sum / static_cast<float>(solver.vertex_count()));
  };
  for (int i = 0; i < 200; ++i) {
    solver.step(kStep);
  }
  const Eigen::Vector3f before = mean();

  for (int i = 0; i < 200; ++i) {
    solver.step(kStep);
  }

  CHECK((mean() - before).norm() < 1e-3F * kEdge);
  const float mass = 1000 * 4e-6F;
  CHECK((solver.tool_force(slope) - mass * down).norm() < 1e-3F * mass * down.norm());
}

// Would catch friction that does not slide, or slides without friction.
TEST_CASE("surface contact: what lies on a steeper slope slides as it must", "[validation]") {
  constexpr float kFriction = 0.3F;
  const float angle = 1.3F * std::atan(kFriction);
  Scene scene;
  scene.add_body("block", testing::make_box({4, 4, 2}, 5e-3),
                 {.youngs_modulus = 20e3F, .poissons_ratio = 0.4F, .damping = 0.01F});
  scene.set_gravity({0, 0, -9.81F * std::cos(angle)});
  Solver solver(scene, {.method = SolverMethod::projection});
  solver.add_half_space({}, kFriction);
  for (int i = 0; i < 100; ++i) {
    solver.step(kStep);
  }
  const float before = solver.positions()[0].x();
  solver.set_gravity({9.81F * std::sin(angle), 0, -9.81F * std::cos(angle)});

  for (int i = 0; i < 200; ++i) {
    solver.step(kStep);
  }

  const float way = 9.81F / 2 * (std::sin(angle) - kFriction * std::cos(angle));
  CHECK(solver.positions()[0].x() - before == Approx(way).epsilon(0.02));
}

// Would catch a fast thin tool that is on the other side before anybody looks.
TEST_CASE("surface contact: nothing passes through a sheet", "[validation]") {
  const SolverMethod method = any_method();
  const float speed = GENERATE(0.1F, 1.0F);
  constexpr Index kCells = 8;
  const testing::SheetMesh mesh = testing::make_slanted_sheet({kCells, kCells}, 5e-3);
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  const BodyId sheet = scene.add_sheet("sheet", mesh.positions, mesh.triangles, {});
  scene.fix_vertices(sheet, testing::rim_of_sheet({kCells, kCells}));
  Solver solver(scene, {.method = method});
  // points down, above the middle of a triangle
  const Capsule rod{{0, 0, 0}, {0, 0, 50e-3F}, 0.5e-3F};
  Eigen::Vector3f place(18.4e-3F, 16.7e-3F, 3e-3F);
  const ToolId tool = solver.add_tool({&rod, 1}, at(place), kAll);
  for (int i = 0; place.z() > -6e-3F; ++i) {
    place.z() -= speed * kStep;
    solver.move_tool(tool, at(place));
    solver.step(kStep);
  }
  for (int i = 0; i < 20; ++i) {
    solver.step(kStep);
  }

  // The sheet hangs from the tip, all of it below what touches it.
  const std::vector<Eigen::Vector3f> x = solver.positions();
  const auto triangle_below = [&] {
    float least = 1;
    for (const Triangle& t : mesh.triangles) {
      Eigen::Matrix2f base;
      base.col(0) = (x[t[1]] - x[t[0]]).head<2>();
      base.col(1) = (x[t[2]] - x[t[0]]).head<2>();
      const Eigen::Vector2f share = base.inverse() * (place - x[t[0]]).head<2>();
      if (share.minCoeff() >= 0 && share.sum() <= 1) {
        const float z =
            x[t[0]].z() + share.x() * (x[t[1]] - x[t[0]]).z() + share.y() * (x[t[2]] - x[t[0]]).z();
        least = std::min(least, place.z() - z);
      }
    }
    return least;
  };
  CHECK(triangle_below() > 0.4e-3F);
  CHECK(triangle_below() < 1);
  CHECK(solver.tool_force(tool).z() > 0);
}

// Would catch edges and triangles whose free corners are thrown, again and again, by what no push
// can get out of a tool: a fixed corner.
TEST_CASE("surface contact: a tool that appears in tissue beside what is fixed throws nothing",
          "[validation]") {
  const SolverMethod method = any_method();
  const TimeIntegration integration =
      method == SolverMethod::projection
          ? TimeIntegration::implicit_euler
          : GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const float inside = GENERATE(1e-3F, 2e-3F, 3e-3F);  // m, of a radius of 4 mm
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), inside);
  constexpr float kEdge = 4e-3F, kRadius = 4e-3F, kTop = 4 * kEdge;
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("block", testing::make_box({4, 3, 4}, kEdge),
                 {.model = ElasticModel::neo_hookean, .youngs_modulus = 10e3F});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
  Solver solver(scene, {.method = method, .integration = integration});
  const Capsule shaft{{0, 0, 0}, {5 * kEdge, 0, 0}, kRadius};
  solver.add_tool({&shaft, 1}, at({0, 1.5F * kEdge, kTop + kRadius - inside}), kAll);

  constexpr float kShortStep = 2e-3F;
  float fastest = 0;
  for (int i = 0; i < 200; ++i) {
    const StepReport report = solver.step(kShortStep);
    if (i < 100) {
      continue;  // it is pushed out at once, and swings
    }
    CHECK(report.inverted_tets == 0);
    for (const Eigen::Vector3f& velocity : solver.velocities()) {
      fastest = std::max(fastest, velocity.norm());
    }
  }
  CHECK(fastest < 3);  // m/s
  const std::vector<Eigen::Vector3f> rest = solver.positions();
  const Eigen::Vector3d origin = scene.positions().front();
  for (const Eigen::Vector3f& x : rest) {
    CHECK((x - origin.cast<float>()).norm() < 3 * kTop);
  }
}

// Would catch an order that depends on threads, and memory of contacts that a snapshot leaves out.
TEST_CASE("surface contact: any number of threads has the serial bits, and a snapshot goes on",
          "[determinism]") {
  const SolverMethod method = any_method();
  const auto run = [&](Executor executor, bool restores) {
    Solver solver(make_soft_block({6, 6, 3}, 3e-3),
                  {.method = method, .executor = std::move(executor), .math = MathMode::strict});
    const Capsule bar{{-3e-3F, 0, 0}, {4e-3F, 1e-3F, 0}, 1e-3F};
    Eigen::Vector3f place(9e-3F, 8e-3F, 10e-3F);
    const ToolId tool = solver.add_tool({&bar, 1}, at(place), {ContactFeatures::all, 0.4F});
    for (int i = 0; i < 30; ++i) {
      place += Eigen::Vector3f(1e-4F, 0.5e-4F, -1e-4F);
      solver.move_tool(tool, at(place));
      solver.step(kStep);
      if (restores && i == 20) {
        const Snapshot snapshot = solver.snapshot();
        CHECK(!snapshot.contacts.empty());
        solver.step(kStep);
        solver.restore(snapshot);
      }
    }
    return solver.state_hash();
  };
  const std::uint64_t serial = run(executor::serial(), false);
  CHECK(run(executor::threads(1), false) == serial);
  CHECK(run(executor::threads(3), false) == serial);
  CHECK(run(executor::threads(2), true) == serial);
}

// Would catch a surface that keeps triangles of what was removed, or loses those that came to
// light.
TEST_CASE("surface contact: what is removed pushes no more, and comes back by undo", "[edit]") {
  const SolverMethod method = any_method();
  Solver solver(make_soft_block({4, 4, 3}, 3e-3), {.method = method});
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 1e-3F};
  const Eigen::Vector3f touch(7e-3F, 6.5e-3F, 10e-3F);
  const ToolId tool = solver.add_tool({&ball, 1}, at(touch), kAll);
  press(solver, tool, touch, 1e-3F, 20);
  const float before = solver.tool_force(tool).z();
  REQUIRE(before > 0);

  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    bool is_on_top = false;
    for (const Index v : solver.tissue().tets()[t]) {
      is_on_top = is_on_top || solver.tissue().rest_positions()[v].z() > 8.9e-3;
    }
    if (is_on_top) {
      edit.remove_tets.push_back(t);
    }
  }
  const Snapshot pressed = solver.snapshot();
  solver.tissue().apply(edit);
  solver.step(kStep);
  CHECK(solver.tool_contacts(tool).empty());
  press(solver, tool, touch - Eigen::Vector3f(0, 0, 3e-3F), 1e-3F, 20);
  CHECK(solver.tool_force(tool).z() > 0.3F * before);  // the layer below

  solver.tissue().undo();
  for (int i = 0; i < 5; ++i) {
    solver.step(kStep);
  }
  for (const ToolContact& contact : solver.tool_contacts(tool)) {
    CHECK(solver.tissue().has_tissue(contact.vertices[0]));
  }
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  solver.step(kStep);
  for (const Eigen::Vector3f& x : solver.positions()) {
    REQUIRE(x.allFinite());
  }
}

TEST_CASE("surface contact: what is out of range is refused", "[errors]") {
  Solver solver(make_soft_block({1, 1, 1}, 3e-3));
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 1e-3F};
  CHECK_THROWS_WITH(solver.add_tool({&ball, 1}, at({0, 0, 1}), {ContactFeatures::all, -1}),
                    ContainsSubstring("friction is -1"));
  CHECK_THROWS_WITH(solver.add_half_space({{0, 0, 0}, {0, 0, 2}}),
                    ContainsSubstring("normal of length 2"));
  CHECK_THROWS_WITH(solver.add_half_space({}, std::numeric_limits<float>::infinity()),
                    ContainsSubstring("friction is inf"));
  CHECK_THROWS_WITH(
      solver.add_tool({&ball, 1}, at({0, 0, 1}), {static_cast<ContactFeatures>(7), 0}),
      ContainsSubstring("features are 7"));

  const ToolId tool = solver.add_tool({&ball, 1}, at({1e-3F, 1e-3F, 3.9e-3F}), kAll);
  solver.step(kStep);
  Snapshot snapshot = solver.snapshot();
  REQUIRE(!snapshot.contacts.empty());
  const auto check_refused = [&](const char* why, auto change) {
    Snapshot forged = snapshot;
    change(forged.contacts.front());
    CHECK_THROWS_WITH(solver.restore(forged), ContainsSubstring(why));
  };
  check_refused("is of tool 7", [](SnapshotContact& c) { c.tool = ToolId(7); });
  check_refused("has vertex 99", [](SnapshotContact& c) { c.vertices[0] = 99; });
  check_refused("has a normal of length 0", [](SnapshotContact& c) { c.normal.setZero(); });
  check_refused("has a force of -1", [](SnapshotContact& c) { c.force = -1; });
  CHECK(solver.tool_contacts(tool).size() == snapshot.contacts.size());
}

}  // namespace pbdsurg
