// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/convergence.h"

#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/state/solver_data.h"
#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;

constexpr float kFineTimeStep = 5e-4F;  // s

// A bar of 20 kPa, held at one end and on the move.
Scene make_moving_bar(Material material) {
  Scene scene;
  const TetMesh mesh = testing::make_box({8, 3, 3}, kSoftEdge, 0.1);
  if (material.model == ElasticModel::springs) {
    const float damping = material.damping;
    material = elastic_material(mesh, 1000, 20e3);
    material.damping = damping;
  } else {
    material.youngs_modulus = 20e3F;
  }
  scene.add_body("bar", mesh, material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  return scene;
}

// Bends and stretches.
void push(Solver& solver) {
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : solver.positions()) {
    velocities.emplace_back(4 * x.x(), 20 * x.x() * x.x(), 0);
  }
  solver.write_velocities(velocities);
}

double ratio_after(const Scene& scene, const SolverOptions& options) {
  Solver solver(scene, options);
  push(solver);
  for (int i = 0; i < 3; ++i) {
    solver.step(kFineTimeStep);
  }
  const std::vector<Convergence> bodies = solver.convergence(kFineTimeStep);
  REQUIRE(bodies[0].elastic > 0);
  return bodies[0].ratio();
}

}  // namespace

// Would catch a force that is another than that which sweeps solve, of tissue or of friction: the
// residual would not vanish.
TEST_CASE("convergence: sweeps bring the residual down to rounding", "[long]") {
  const auto model = GENERATE(ElasticModel::neo_hookean, ElasticModel::springs);
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  const float damping = GENERATE(0.0F, 3e-3F);
  Scene scene = make_moving_bar({.model = model, .damping = damping});
  scene.add_hinges(0, 1e-4F);
  const auto ratio = [&](int sweeps) {
    return ratio_after(scene, {.method = method, .substeps = 1, .iterations = sweeps});
  };
  INFO("model " << static_cast<int>(model) << ", method " << static_cast<int>(method)
                << ", friction " << damping);

  const double few = ratio(2);
  const double more = ratio(20);
  const double many = ratio(1000);

  CAPTURE(few, more, many);
  CHECK(few > 0.1);
  CHECK(more < 0.95 * few);
  CHECK(many < 5e-3);  // what single precision leaves; without friction's forces, all of it
}

TEST_CASE("convergence: at rest elastic forces carry the weight") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  Solver solver(make_moving_bar({}),
                {.method = method, .substeps = 1, .iterations = 30, .damping = 30});
  for (int i = 0; i < 800; ++i) {
    solver.step(kFineTimeStep);
  }

  const Convergence bar = solver.convergence(kFineTimeStep)[0];

  double weight = 0;
  Index count = 0;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    const double w = solver_data(solver).particle(v).w;
    weight += w > 0 ? std::pow(9.81 / w, 2) : 0;
    count += w > 0 ? 1 : 0;
  }
  CHECK(bar.elastic == Approx(std::sqrt(weight)).epsilon(0.01));
  CHECK(bar.residual < 5e-3 * bar.elastic);
  CHECK(bar.vertex_count == count);
}

// Would catch a measurement that leaves a trace: in rows that friction changes, in what the method
// starts from, in tools.
TEST_CASE("convergence: measuring changes no bit of what follows") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 5e-3F);
  const SolverOptions options{
      .method = method, .substeps = 3, .iterations = 2, .copies = 2, .executor = executor};
  Solver solver(scene, options);
  Solver measured(scene, options);
  const testing::EventfulProgram program(scene, 3);
  program.begin(solver);
  program.begin(measured);
  for (int round = 0; round < 20; ++round) {
    program.act(solver, round);
    program.act(measured, round);
    CHECK(measured.convergence(kFineTimeStep).size() == measured.tissue().bodies().size());
    CHECK(measured.convergence(kFineTimeStep, 1).size() == measured.tissue().bodies().size());
    solver.step(kFineTimeStep);
    measured.step(kFineTimeStep);
    REQUIRE(measured.state_hash() == solver.state_hash());
    REQUIRE(measured.state_hash(1) == solver.state_hash(1));
    REQUIRE(measured.tool_force(ToolId(0)) == solver.tool_force(ToolId(0)));
  }
}

TEST_CASE("convergence: what is held, linked rigidly or at its limit does not count") {
  const Scene bar = make_moving_bar({});
  Scene scene = bar;
  scene.add_body("other", testing::make_box({2, 2, 2}, kSoftEdge, 0.1), {});
  scene.add_link({100, scene.body(1).first_vertex, 0, {0.5F, 0}});
  Solver solver(scene, {.substeps = 1, .iterations = 200});
  Solver alone(bar, {.substeps = 1, .iterations = 200});
  const Index all = alone.convergence(kFineTimeStep)[0].vertex_count;
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, std::array<Index, 2>{79, 80});
  ToolPose lifted = ToolPose::Identity();
  lifted.translation().z() = 1e-4F;
  solver.move_tool(tool, lifted);
  solver.step(kFineTimeStep);

  const Convergence held = solver.convergence(kFineTimeStep)[0];

  CHECK(held.vertex_count == all - 3);
  CHECK(held.ratio() < 0.01);

  // to projections a limit is rigid; to vertex blocks it is a spring, whose force has to be counted
  Material limited;
  limited.max_stretch = 1.001F;
  Solver projected(make_moving_bar(limited),
                   {.method = SolverMethod::projection, .substeps = 1, .iterations = 20});
  push(projected);
  projected.step(kFineTimeStep);
  CHECK(projected.convergence(kFineTimeStep)[0].vertex_count < all);
  Solver by_vertices(make_moving_bar(limited), {.substeps = 1, .iterations = 400});
  push(by_vertices);
  by_vertices.step(kFineTimeStep);
  CHECK(by_vertices.convergence(kFineTimeStep)[0].vertex_count == all);
  CHECK(by_vertices.convergence(kFineTimeStep)[0].ratio() < 0.01);
}

TEST_CASE("convergence: of one substep of those that a step takes") {
  Solver solver(make_moving_bar({}), {.substeps = 4, .iterations = 3});
  Solver substep(make_moving_bar({}), {.substeps = 1, .iterations = 3});
  push(solver);
  push(substep);

  CHECK(solver.convergence(kFineTimeStep)[0].residual ==
        substep.convergence(kFineTimeStep / 4)[0].residual);
}

TEST_CASE("convergence: every third report has it") {
  const SolverOptions plain{.substeps = 2, .iterations = 3};
  SolverOptions watching = plain;
  watching.convergence_interval = 3;
  Solver solver(make_moving_bar({}), plain);
  Solver watched(make_moving_bar({}), watching);
  push(solver);
  push(watched);
  for (int i = 1; i <= 7; ++i) {
    solver.step(kFineTimeStep);
    const float found = watched.step(kFineTimeStep).convergence;
    REQUIRE(watched.state_hash() == solver.state_hash());
    CHECK(watched.last_report().convergence == found);
    if (i % 3 == 0) {
      CHECK(found > 0);
      CHECK(found == static_cast<float>(solver.convergence(kFineTimeStep)[0].ratio()));
    } else {
      CHECK(found == 0);
    }
  }
}

TEST_CASE("convergence: refusals, and bodies that nothing counts of") {
  Solver fraction(make_moving_bar({.model = ElasticModel::springs}), SolverOptions::paper());
  CHECK_THROWS_WITH(fraction.convergence(kFineTimeStep), ContainsSubstring("fraction mode"));
  SolverOptions paper = SolverOptions::paper();
  paper.convergence_interval = 10;
  CHECK_THROWS_WITH(Solver(make_moving_bar({.model = ElasticModel::springs}), paper),
                    ContainsSubstring("convergence_interval is 10"));
  CHECK_THROWS_WITH(Solver(make_moving_bar({}), {.convergence_interval = -1}),
                    ContainsSubstring("convergence_interval is -1"));
  Solver solver(make_moving_bar({}), {});
  CHECK_THROWS_WITH(solver.convergence(0), ContainsSubstring("dt is 0"));
  CHECK_THROWS_WITH(solver.convergence(kFineTimeStep, 1), ContainsSubstring("no copy 1"));
  solver.start_step(kFineTimeStep);
  CHECK_THROWS_WITH(solver.convergence(kFineTimeStep), ContainsSubstring("finish_step()"));
  solver.finish_step();

  Scene rigid;
  Material springs;
  springs.model = ElasticModel::springs;
  rigid.add_body("rigid", testing::make_box({2, 2, 2}, kSoftEdge, 0.1), springs);
  Solver projected(rigid, testing::small_steps());
  const Convergence none = projected.convergence(kFineTimeStep)[0];
  CHECK(none.vertex_count == 0);
  CHECK(none.ratio() == 0);
}

}  // namespace pbdsurg
