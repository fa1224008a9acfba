// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/material.h"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;

Material soft_tissue() {
  return {.model = ElasticModel::neo_hookean, .youngs_modulus = 5000, .poissons_ratio = 0.45F};
}

// A bar along x, by default free and without gravity.
Scene make_free_bar(const Material& material, std::array<Index, 3> cells = {6, 2, 2},
                    bool fixed = false) {
  Scene scene;
  scene.add_body("bar", testing::make_box(cells, kSoftEdge, 0.1), material);
  scene.set_gravity(Eigen::Vector3f::Zero());
  if (fixed) {
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  }
  return scene;
}

Index count_phases(const StepPlan& plan, PhaseKind kind) {
  Index result = 0;
  for (const Phase& phase : plan.phases) {
    result += phase.kind == kind;
  }
  return result;
}

// Largest change of an edge's length, which motions of the whole leave alone.
double shape_error(const Scene& scene, const Solver& solver) {
  const auto x = solver.positions();
  double largest = 0;
  for (const Edge& edge : solver.tissue().edges()) {
    const double rest = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
    const double now = (x[edge[0]] - x[edge[1]]).norm();
    largest = std::max(largest, std::abs(now - rest));
  }
  return largest;
}

}  // namespace

TEST_CASE("material: a neo-hookean body has its tetrahedra alone, whatever the composition",
          "[unit]") {
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  Material limited = soft_tissue();
  limited.max_stretch = 1.5F;
  Scene scene = make_free_bar(limited);
  scene.add_body("springs", testing::make_box({2, 2, 2}, kSoftEdge), testing::kSprings);
  const Solver solver(scene, testing::small_steps({.composition = composition}));
  const StepPlan& plan = solver.plan();
  CHECK(count_phases(plan, PhaseKind::neo_hookean) >= 24);  // tetrahedra at an inner vertex
  CHECK(count_phases(plan, PhaseKind::strain_limit) >= 14);
  CHECK(plan.phases.back().kind == PhaseKind::strain_limit);
  CHECK(plan.phases.front().kind != PhaseKind::neo_hookean);  // the springs come first
  CHECK(count_phases(Solver(make_free_bar(soft_tissue()), testing::small_steps()).plan(),
                     PhaseKind::strain_limit) == 0);
  CHECK(count_phases(Solver(make_free_bar(soft_tissue()), testing::small_steps()).plan(),
                     PhaseKind::distance) == 0);
  CHECK(count_phases(Solver(make_free_bar(soft_tissue()), testing::small_steps()).plan(),
                     PhaseKind::volume) == 0);

  CHECK(solver.tissue().is_edge_alive(0));
  CHECK_THROWS_WITH(solver.rest_length(0), ContainsSubstring("Neo-Hookean"));
  CHECK(solver.rest_volume(3) ==
        Approx(tet_volume(scene.positions(), scene.tets()[3])).epsilon(1e-5));
}

TEST_CASE("material: a neo-hookean body needs the compliance mode", "[unit]") {
  CHECK_THROWS_WITH(Solver(make_free_bar(soft_tissue()), SolverOptions::paper()),
                    ContainsSubstring("body 'bar' is Neo-Hookean"));
}

TEST_CASE("material: a neo-hookean body at rest stays, and reports its volumes", "[unit]") {
  const Scene scene = make_free_bar(soft_tissue());
  Solver solver(scene, testing::small_steps());
  for (int i = 0; i < 20; ++i) {
    solver.step(0.01F);
  }
  CHECK(shape_error(scene, solver) < 1e-4 * kSoftEdge);

  auto x = solver.positions();
  for (Eigen::Vector3f& p : x) {
    p.x() *= 1.2F;
  }
  solver.write_positions(x);
  CHECK(solver.step(1e-6F).volume_residual == Approx(0.2).epsilon(1e-3));
  for (Eigen::Vector3f& p : x) {
    p.x() *= -1;
  }
  solver.write_positions(x);
  const StepReport report = solver.step(1e-6F);
  CHECK(report.inverted_tets == static_cast<Index>(solver.tissue().tets().size()));
  CHECK(report.volume_residual == Approx(2.2).epsilon(1e-3));
}

TEST_CASE("material: neo-hookean steps have the serial bits, on any number of threads",
          "[golden]") {
  Material material = soft_tissue();
  material.max_stretch = 1.3F;
  material.damping = GENERATE(0.0F, 0.01F);
  Scene scene = make_free_bar(material, {6, 2, 2}, true);
  scene.set_gravity({0, -9.81F, 0});
  const auto run = [&](const Executor& executor, MathMode math) {
    Solver solver(scene,
                  testing::small_steps({.iterations = 2, .executor = executor, .math = math}));
    StepReport report;
    for (int i = 0; i < 5; ++i) {
      report = solver.step(0.01F);
    }
    CHECK(solver.positions()[40] != scene.positions()[40].cast<float>());
    return std::pair(solver.state_hash(), report.volume_residual);
  };
  const auto expected = run(executor::serial(), MathMode::strict);
  CHECK(run(executor::serial(), MathMode::strict) == expected);
  CHECK(run(executor::threads(GENERATE(1, 3)), MathMode::strict) == expected);
  const auto fast = run(executor::threads(1), MathMode::fast);
  CHECK(run(executor::threads(3), MathMode::fast) == fast);
  CHECK(fast.second == Approx(expected.second).epsilon(0.01));
}

// A vertex is written beyond the limit; the limit alone must bring it back, in either mode of
// projections.
TEST_CASE("material: no edge stays longer than its limit", "[property]") {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  Material material{.model = ElasticModel::springs,
                    .stretch = {0.01F, 1e3F},
                    .volume = {0.01F, 1},
                    .max_stretch = 1.1F};
  const Scene scene = make_free_bar(material);
  Solver solver(scene, testing::small_steps({.mode = mode, .substeps = 1, .iterations = 300}));
  auto x = solver.positions();
  for (Eigen::Vector3f& p : x) {
    p *= 1.3F;
  }
  solver.write_positions(x);
  solver.step(1e-4F);
  x = solver.positions();
  for (const Edge& edge : solver.tissue().edges()) {
    const double rest = (scene.positions()[edge[0]] - scene.positions()[edge[1]]).norm();
    CHECK((x[edge[0]] - x[edge[1]]).norm() < 1.101 * rest);
  }
}

}  // namespace pbdsurg
