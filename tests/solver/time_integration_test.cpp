// SPDX-License-Identifier: Apache-2.0
// BDF2: its order, its first substep, and what tools, links, edits and snapshots make of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::any_sweeping_method;
using testing::Approx;
using testing::ContainsSubstring;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;
using testing::vertices_above;

constexpr auto kBdf2 = TimeIntegration::bdf2;

SolverOptions bdf2_options(SolverMethod method, int substeps, int sweeps, float damping = 0) {
  return {.method = method,
          .substeps = substeps,
          .iterations = sweeps,
          .damping = damping,
          .integration = kBdf2};
}

// Half of the kinetic and all of the potential energy that gravity along y gives, per weight: m.
double height_and_speed(const Solver& solver) {
  const auto masses = solver.tissue().masses();
  const auto x = solver.positions();
  const auto v = solver.velocities();
  double energy = 0;
  double mass = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    mass += masses[i];
    energy += masses[i] * (x[i].y() + v[i].squaredNorm() / (2 * 9.81));
  }
  return energy / mass;
}

// Where a bar is 40 ms after it was let go, with substeps of 4 ms / n, or by turns a half longer
// and a half shorter.
std::vector<Eigen::Vector3f> swung(TimeIntegration integration, SolverMethod method, float friction,
                                   int n, bool alternates) {
  Material soft = neo_hookean(5e3F, 0.3F);
  soft.damping = friction;
  SolverOptions options = bdf2_options(method, 1, 200, 5);
  options.integration = integration;
  Solver solver(make_bar(soft, {3, 1, 1}, 8e-3), options);
  for (int i = 0; i < 10 * n; ++i) {
    const float part = !alternates ? 1.0F : i % 2 == 0 ? 1.5F : 0.5F;
    solver.step(part * 4e-3F / static_cast<float>(n));
  }
  return solver.positions();
}

double distance(const std::vector<Eigen::Vector3f>& a, const std::vector<Eigen::Vector3f>& b) {
  double sum = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    sum += (a[v] - b[v]).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(a.size()));
}

}  // namespace

// Would catch a coefficient, of drag, friction or of substeps that differ, that is right in the
// limit only: halving substeps would halve the error.
TEST_CASE("time integration: half the substep leaves a quarter of BDF2's error", "[property]") {
  const SolverMethod method = any_sweeping_method();
  const float friction = GENERATE(0.0F, 2e-3F);  // s
  const bool alternates = GENERATE(false, true);
  INFO("method " << static_cast<int>(method) << ", friction " << friction << " s, alternates "
                 << alternates);
  const auto exact = swung(kBdf2, method, friction, 64, false);
  const double coarse = distance(swung(kBdf2, method, friction, 4, alternates), exact);
  const double fine = distance(swung(kBdf2, method, friction, 8, alternates), exact);
  const double euler =
      distance(swung(TimeIntegration::implicit_euler, method, friction, 8, alternates), exact);
  CAPTURE(coarse, fine, euler);
  CHECK(coarse > 2.8 * fine);
  CHECK(fine < 0.5 * euler);
}

// Would catch a past that was never, or is not forgotten, in the first substep or after a write.
TEST_CASE("time integration: BDF2 begins as implicit Euler, also after positions or velocities",
          "[unit]") {
  const SolverMethod method = any_sweeping_method();
  const Scene scene = make_bar(neo_hookean(5e3F, 0.3F));
  Solver bdf2(scene, bdf2_options(method, 1, 3));
  SolverOptions options = bdf2_options(method, 1, 3);
  options.integration = TimeIntegration::implicit_euler;
  Solver euler(scene, options);
  const auto step_alike = [&] {
    bdf2.step(1e-3F);
    euler.step(1e-3F);
    return bdf2.positions() == euler.positions() && bdf2.velocities() == euler.velocities();
  };
  CHECK(step_alike());
  CHECK_FALSE(step_alike());
  for (const bool writes_positions : {true, false}) {
    const std::vector<Eigen::Vector3f> x = bdf2.positions();
    const std::vector<Eigen::Vector3f> v = bdf2.velocities();
    for (Solver* solver : {&bdf2, &euler}) {
      solver->write_positions(x);
      solver->step(1e-3F);
      if (writes_positions) {
        solver->write_positions(x);
      } else {
        Snapshot by_hand = solver->snapshot();
        by_hand = {.positions = x,
                   .velocities = v,
                   .tool_poses = by_hand.tool_poses,
                   .tissue = by_hand.tissue};
        solver->restore(by_hand);
        solver->write_velocities(v);
      }
    }
    CHECK(step_alike());
    CHECK_FALSE(step_alike());
  }
}

TEST_CASE("time integration: a snapshot has BDF2's past, and one made by hand does without",
          "[golden]") {
  const SolverMethod method = any_sweeping_method();
  SolverOptions options = bdf2_options(method, 2, 2);
  options.copies = 2;
  Solver solver(make_bar(neo_hookean(5e3F, 0.3F)), options);
  run(solver, 5);
  Snapshot snapshot = solver.snapshot();
  CHECK(snapshot.past_substep == 2.5e-3F);
  run(solver, 3);
  const std::uint64_t after = solver.state_hash();
  solver.restore(snapshot, 1);
  CHECK(solver.state_hash(1) != after);
  run(solver, 3);
  CHECK(solver.state_hash(1) == after);  // the first goes on with its own past
  Snapshot wrong = snapshot;
  wrong.past_substep = -1;
  CHECK_THROWS_WITH(solver.restore(wrong), ContainsSubstring("past substep"));
  wrong = snapshot;
  wrong.velocities_before.pop_back();
  CHECK_THROWS_WITH(solver.restore(wrong), ContainsSubstring("velocities before"));
  snapshot.ways.clear();
  snapshot.velocities_before.clear();
  solver.restore(snapshot);
  run(solver, 3);
  CHECK(solver.state_hash() != after);
}

TEST_CASE("time integration: fraction mode refuses BDF2", "[unit]") {
  SolverOptions options = SolverOptions::paper();
  options.integration = kBdf2;
  CHECK_THROWS_WITH(Solver(make_bar(testing::kSprings), options),
                    ContainsSubstring("needs compliance mode"));
  options.integration = static_cast<TimeIntegration>(2);
  CHECK_THROWS_WITH(Solver(make_bar(testing::kSprings), options),
                    ContainsSubstring("unknown time integration 2"));
}

// Would catch forces in newtons that take another substep for their multipliers than sweeps did.
TEST_CASE("time integration: a grasp and a tool feel the weight that they carry", "[validation]") {
  const SolverMethod method = any_sweeping_method();
  const float compliance = GENERATE(0.0F, 1e-3F);
  const double edge = 5e-3;
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, edge), neo_hookean(2e4F, 0.4F));
  const Index block = scene.vertex_count();
  scene.add_particles("particle", std::vector<Eigen::Vector3d>{{0.1, 0.0101, 0}}, 1e-3);
  Solver solver(scene, bdf2_options(method, 2, 60, 60));
  const ToolId holder = solver.add_tool({}, ToolPose::Identity());
  const ToolId floor = solver.add_tool(std::vector<Capsule>{{{0.1F, 0, 0}, {0.1F, 0, 0}, 0.01F}},
                                       ToolPose::Identity());
  std::vector<Index> top = vertices_above(scene, 1.99 * edge);
  std::erase(top, block);
  solver.grasp(holder, top, compliance);
  run(solver, 600, 2e-3F);
  const double weight = 1000 * std::pow(2 * edge, 3) * 9.81;
  CHECK(solver.tool_force(holder).y() == Approx(-weight).epsilon(1e-3));
  CHECK(solver.tool_force(floor).y() == Approx(-9.81e-3).epsilon(1e-3));
  solver.step(5e-3F);  // of another length: its substeps' numbers differ
  CHECK(solver.tool_force(holder).y() == Approx(-weight).epsilon(1e-3));
  CHECK(solver.tool_force(floor).y() == Approx(-9.81e-3).epsilon(1e-3));
}

// Would catch the bounce that backward differences make of a stop: a particle sprang back higher,
// by 17 % of its fall.
TEST_CASE("time integration: what falls onto a tool gains no energy", "[property]") {
  const SolverMethod method = any_sweeping_method();
  const bool is_body = GENERATE(false, true);
  const float dt = GENERATE(1e-3F, 1.3e-3F, 4e-3F);
  Scene scene;
  if (is_body) {
    scene.add_body("block", testing::make_box({2, 2, 2}, 5e-3), neo_hookean(1e4F, 0.4F));
  } else {
    scene.add_particles("particle", std::vector<Eigen::Vector3d>{{5e-3, 0, 5e-3}}, 1e-3);
  }
  Solver solver(scene, bdf2_options(method, 1, 30));
  solver.add_tool(std::vector<Capsule>{{{5e-3F, -0.05F, 5e-3F}, {5e-3F, -0.05F, 5e-3F}, 0.03F}},
                  ToolPose::Identity());
  const double start = height_and_speed(solver);
  double most = start;
  Index contacts = 0;
  for (int i = 0; i < 400; ++i) {
    contacts += solver.step(dt).contacts;
    most = std::max(most, height_and_speed(solver));
  }
  INFO("method " << static_cast<int>(method) << ", body " << is_body << ", step " << dt);
  CHECK(contacts > 0);
  // 1 %: what implicit Euler's first substep adds to the fall
  CHECK(most - start < 0.01 * 0.02);
}

// Would catch a vertex that a tool moved and that has another motion once it is released.
TEST_CASE("time integration: what a tool carries goes on at its speed when it is released",
          "[unit]") {
  const SolverMethod method = any_sweeping_method();
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("block", testing::make_box({1, 1, 1}, 5e-3), neo_hookean(1e4F, 0.4F));
  Solver solver(scene, bdf2_options(method, 2, 10));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, vertices_above(scene, -1));
  ToolPose pose = ToolPose::Identity();
  for (int i = 0; i < 50; ++i) {
    pose.translation().x() += 1e-4F;  // 0.1 m/s
    solver.move_tool(tool, pose);
    solver.step(1e-3F);
  }
  solver.release(tool);
  run(solver, 20, 1e-3F);
  for (const Eigen::Vector3f& v : solver.velocities()) {
    CHECK(v.x() == Approx(0.1).epsilon(1e-3));
  }
}

TEST_CASE("time integration: a chain of rigid links carries its weight", "[validation]") {
  constexpr Index kCount = 12;
  const double spacing = 2e-3, mass = 1e-3;
  Scene scene;
  std::vector<Eigen::Vector3d> positions;
  for (Index i = 0; i < kCount; ++i) {
    positions.emplace_back(0, -spacing * i, 0);
  }
  scene.add_particles("chain", positions, mass);
  for (Index i = 0; i + 1 < kCount; ++i) {
    scene.add_link({i, i + 1, static_cast<float>(spacing), {1, 0}});
  }
  Solver solver(scene, bdf2_options(SolverMethod::vertex_block, 4, 10, 20));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, std::vector<Index>{0});
  run(solver, 400, 2e-3F);
  CHECK(solver.positions()[kCount - 1].y() == Approx(-spacing * (kCount - 1)).epsilon(1e-3));
  CHECK(solver.tool_force(tool).y() == Approx(-kCount * mass * 9.81).epsilon(1e-3));
}

// Would catch a residual with another inertia or another start of friction than sweeps have.
TEST_CASE("time integration: many sweeps bring BDF2's residual down to rounding", "[unit]") {
  const SolverMethod method = any_sweeping_method();
  Material soft = neo_hookean(2e4F, 0.4F);
  soft.damping = GENERATE(0.0F, 3e-3F);
  Solver solver(make_bar(soft), bdf2_options(method, 1, 1000, 5));
  run(solver, 6, 1e-3F);
  CHECK(solver.convergence(1e-3F)[0].ratio() < 5e-3);
  CHECK(solver.convergence(2e-3F)[0].ratio() < 5e-3);
}

// Would catch new tissue whose past is that of nothing: it would lag behind what it came from.
TEST_CASE("time integration: what edits bring moves on with what is there, and undo forgets it",
          "[unit]") {
  const SolverMethod method = any_sweeping_method();
  const TetMesh mesh = testing::make_box({1, 1, 1}, 5e-3);
  Scene scene;
  scene.add_body("block", mesh, neo_hookean(1e4F, 0.4F));
  Solver solver(scene, bdf2_options(method, 2, 5));
  Solver twin(scene, bdf2_options(method, 2, 5));
  run(solver, 10, 1e-3F);
  run(twin, 10, 1e-3F);
  const Index before = solver.vertex_count();
  TopologyEdit edit;
  edit.remove_tets = {0, 1};
  Scene other;
  other.add_body("other", mesh, neo_hookean(1e4F, 0.4F));
  edit.new_bodies = other;
  solver.tissue().apply(edit);
  solver.tissue().undo();
  CHECK(solver.state_hash() == twin.state_hash());
  solver.tissue().apply(edit);
  const std::vector<Eigen::Vector3f> start = solver.positions();
  run(solver, 10, 1e-3F);
  const std::vector<Eigen::Vector3f> now = solver.positions();
  double fallen = 0;
  for (Index v = before; v < solver.vertex_count(); ++v) {
    fallen += (start[v].y() - now[v].y()) / (solver.vertex_count() - before);
  }
  CHECK(fallen == Approx(9.81 / 2 * 1e-4).epsilon(1e-3));
  solver.tissue().undo();
  run(solver, 10, 1e-3F);
  CHECK(solver.vertex_count() == before);
  CHECK(solver.last_report().non_finite_vertices == 0);
}

// Would catch vertices that threads recall or keep by halves, and contacts that they ease at once.
TEST_CASE("time integration: BDF2 has the serial bits on any number of threads, in every copy",
          "[equivalence]") {
  const SolverMethod method = any_sweeping_method();
  const testing::Variant variant{
      .method = method, .damping = GENERATE(0.0F, 0.01F), .integration = kBdf2};
  const Index copies = GENERATE(1, 3);
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  Solver serial(scene, testing::serial_options(variant, copies));
  const testing::EventfulProgram program(scene, 1);
  program.begin(serial);
  std::vector<std::unique_ptr<Solver>> others;
  for (const int threads : {1, 2, 3}) {
    SolverOptions options = testing::options_of(variant);
    options.copies = copies;
    options.executor = executor::threads(threads);
    others.push_back(std::make_unique<Solver>(scene, options));
    program.begin(*others.back());
  }
  Index contacts = 0;
  for (int round = 0; round < 40; ++round) {
    INFO("round " << round);
    program.act(serial, round);
    program.fix(serial, round);
    const float dt = round % 9 == 8 ? 3e-3F : testing::kEventfulTimeStep;
    contacts += serial.step(dt).contacts;
    for (const auto& other : others) {
      program.act(*other, round);
      program.fix(*other, round);
      other->step(dt);
      for (Index copy = 0; copy < copies; ++copy) {
        REQUIRE(other->state_hash(copy) == serial.state_hash(copy));
      }
      REQUIRE(other->tool_force(ToolId(0)) == serial.tool_force(ToolId(0)));
    }
  }
  CHECK(contacts > 0);
}

}  // namespace pbdsurg
