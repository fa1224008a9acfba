// SPDX-License-Identifier: Apache-2.0
// Copies with a material and a gravity of their own, against solvers of such a scene.
#include "pbdsurg/solver/copy_factors.h"

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/solver/tet_stress.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/solver_copy.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;
using testing::Recipe;
using testing::run;

constexpr CopyFactors kSame{};
// powers of two, with which a solver of such a scene rounds alike
constexpr CopyFactors kOther{.stiffness = 4, .density = 2, .gravity = 0.5F};

// A Neo-Hookean bar with fibres and friction, a block of springs, a sheet, a thread and links, of
// material so many times as stiff and heavy.
Scene make_factored_scene(const CopyFactors& factors) {
  const auto [stiffness, density, gravity] = factors;
  const TetMesh mesh = testing::make_box({4, 2, 2}, kSoftEdge, 0.1);
  Material soft = testing::neo_hookean(stiffness * 10e3F, 0.4F);
  soft.density = density * 1000;
  soft.damping = 2e-3F;
  Material springs = elastic_material(mesh, 1000, 20e3);
  springs.density = density * 1000;
  springs.stretch.compliance /= stiffness;
  springs.volume.compliance /= stiffness;
  Scene scene;
  scene.add_body("bar", mesh, soft);
  scene.add_body("block", mesh, springs);
  const testing::SheetMesh sheet = testing::make_sheet({4, 3}, kSoftEdge, 0.2);
  const Index wide = scene.add_sheet(
      "sheet", sheet.positions, sheet.triangles,
      {.density = density * 1000, .youngs_modulus = stiffness * 50e3F, .poissons_ratio = 0.25F});
  const std::array<Eigen::Vector3d, 1> bead{{{0, -kSoftEdge, 0}}};
  const Index thread = scene.add_particles("bead", bead, density * 1e-5);
  scene.set_fibres(0, std::vector<Fibre>(static_cast<std::size_t>(scene.body(0).tet_count),
                                         {Eigen::Vector3f::UnitY(), stiffness * 8e3F}));
  const float edge = static_cast<float>(kSoftEdge);
  scene.add_link({3, scene.body(thread).first_vertex, edge, {1, 0.25F / stiffness}});
  scene.add_link({2, scene.body(1).first_vertex + 2, edge, {1, 0x1p-12F / stiffness}});  // stiff
  scene.add_link({4, scene.body(wide).first_vertex, edge, {1, 0.25F / stiffness}});
  for (const Index body : {0, 1}) {
    scene.fix_where(body, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  }
  scene.set_gravity(gravity * Eigen::Vector3f(0, -8, 0));
  return scene;
}

// A program's own constraints, of nothing.
struct Idle final : CustomConstraints {
  [[nodiscard]] std::string name() const override { return "idle"; }
  [[nodiscard]] std::span<const Index> vertices() const override { return {}; }
  void project(ConstraintSweep&) override {}
  void follow(const Tissue&, const TissueChange&) noexcept override {}
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}
};

Recipe any_copied_recipe() {
  SolverOptions blocks{.method = SolverMethod::vertex_block, .substeps = 3, .iterations = 2};
  SolverOptions projections{.method = SolverMethod::projection, .substeps = 3, .iterations = 2};
  blocks.math = projections.math = MathMode::strict;
  blocks.damping = projections.damping = 0.5F;
  SolverOptions bdf = blocks, projected_bdf = projections;
  bdf.integration = projected_bdf.integration = TimeIntegration::bdf2;
  return GENERATE_COPY(Recipe{"vertex blocks", blocks}, Recipe{"projections", projections},
                       Recipe{"vertex blocks, BDF2", bdf},
                       Recipe{"projections, BDF2", projected_bdf});
}

ToolPose lowered(int step) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, -2e-4F * static_cast<float>(step), 0);
  return pose;
}

// A grasp that gives way, a rigid one and a ball that pushes; forces at some vertices.
struct Operation {
  ToolId soft, rigid, ball;

  explicit Operation(Solver& solver) {
    soft = solver.add_tool({}, ToolPose::Identity());
    rigid = solver.add_tool({}, ToolPose::Identity());
    const Eigen::Vector3f above(2 * static_cast<float>(kSoftEdge), 9e-3F, 4e-3F);
    const std::array<Capsule, 1> capsule{{{above, above, 3e-3F}}};
    ball = solver.add_tool(capsule, ToolPose::Identity());
  }
  void begin(Solver& solver, Index copy) const {
    solver.grasp(soft, std::array<Index, 2>{9, 14}, 0.5F, copy);
    solver.grasp(rigid, std::array<Index, 1>{29}, 0, copy);
    solver.set_forces(std::array<Index, 1>{24},
                      std::array<Eigen::Vector3f, 1>{Eigen::Vector3f(0.25F, 0, 0.125F)}, copy);
  }
  void move(Solver& solver, int step, Index copy) const {
    for (const ToolId tool : {soft, rigid, ball}) {
      solver.move_tool(tool, lowered(step), copy);
    }
  }
};

}  // namespace

// Would catch a place where a factor is missing, counts twice or counts for what is not the
// tissue's: of powers of two, all bits are those of a solver of the other material.
TEST_CASE("copy factors: a copy moves as a solver of such a scene", "[property]") {
  const Recipe recipe = any_copied_recipe();
  const Executor executor = GENERATE(executor::serial(), executor::threads(3));
  INFO(recipe.name << ", " << executor.name());
  SolverOptions options = recipe.options;
  options.executor = executor;
  options.composition = PlanComposition::separate;
  Solver alone(make_factored_scene(kSame), options), other(make_factored_scene(kOther), options);
  options.copies = 3;
  Solver copies(make_factored_scene(kSame), options);
  copies.set_factors(kOther, 1);
  CHECK(copies.factors(0) == kSame);
  CHECK(copies.factors(1) == kOther);
  const Operation operation(alone), of_other(other), of_copies(copies);
  operation.begin(alone, 0);
  of_other.begin(other, 0);
  for (Index copy = 0; copy < 3; ++copy) {
    of_copies.begin(copies, copy);
  }
  double pressed = 0;
  for (int step = 1; step <= 30; ++step) {
    operation.move(alone, step, 0);
    of_other.move(other, step, 0);
    for (Index copy = 0; copy < 3; ++copy) {
      of_copies.move(copies, step, copy);
    }
    alone.step(4e-3F);
    other.step(4e-3F);
    copies.step(4e-3F);
    REQUIRE(copies.state_hash(0) == alone.state_hash());
    REQUIRE(copies.state_hash(1) == other.state_hash());
    REQUIRE(copies.state_hash(2) == alone.state_hash());
    for (const ToolId tool : {operation.soft, operation.rigid, operation.ball}) {
      const Eigen::Vector3f expected = other.tool_force(tool);
      REQUIRE((copies.tool_force(tool, 1) - expected).norm() <= 1e-6F * expected.norm());
    }
    pressed += double{other.tool_force(operation.ball).norm()};
  }
  CHECK(pressed > 0);
  CHECK(copies.state_hash(0) != copies.state_hash(1));
  const std::array<Index, 1> tet{7};
  const Eigen::Matrix3f stress = tet_stresses(other, tet)[0].stress;
  CHECK((tet_stresses(copies, tet, 1)[0].stress - stress).norm() < 1e-5F * stress.norm());
  const auto expected = other.convergence(4e-3F), found = copies.convergence(4e-3F, 1);
  for (std::size_t body = 0; body < expected.size(); ++body) {
    CHECK(found[body].residual == Approx(expected[body].residual).epsilon(1e-4));
    CHECK(found[body].elastic == Approx(expected[body].elastic).epsilon(1e-4));
  }
}

// Would catch a correction by modes of the scene's stiffness; and what other factors round to.
TEST_CASE("copy factors: any of them, and a coarse correction, follow within rounding",
          "[property]") {
  const CoarseCorrection correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on);
  const CopyFactors factors = GENERATE(
      CopyFactors{.stiffness = 3, .density = 0.7F, .gravity = 1.3F},
      CopyFactors{.stiffness = 0.3F, .gravity = -1}, CopyFactors{.density = 3, .gravity = 0});
  const auto make = [](const CopyFactors& of) {
    Material material = testing::neo_hookean(of.stiffness * 10e3F, 0.4F);
    material.density = of.density * 1000;
    Scene scene = testing::make_bar(material);
    scene.set_gravity(of.gravity * Eigen::Vector3f(0, -9, 0));
    return scene;
  };
  SolverOptions options{.method = SolverMethod::vertex_block,
                        .substeps = 4,
                        .iterations = 2,
                        .coarse_correction = correction,
                        .math = MathMode::strict};
  Solver other(make(factors), options);
  options.copies = 2;
  Solver copies(make({}), options);
  copies.set_factors(factors, 1);
  const std::vector<Eigen::Vector3f> rest = other.positions();
  const auto push = [](Solver& solver, Index copy) {
    solver.set_forces(std::array<Index, 1>{40},
                      std::array<Eigen::Vector3f, 1>{Eigen::Vector3f(0, 0, 5e-3F)}, copy);
  };
  push(other, 0);
  push(copies, 1);
  run(other, 30);
  run(copies, 30);
  float way = 0, difference = 0, to_scene = 0;
  const auto expected = other.positions(), found = copies.positions(1), scene = copies.positions();
  for (std::size_t v = 0; v < rest.size(); ++v) {
    way = std::max(way, (expected[v] - rest[v]).norm());
    difference = std::max(difference, (expected[v] - found[v]).norm());
    to_scene = std::max(to_scene, (expected[v] - scene[v]).norm());
  }
  CHECK(difference < 2e-4F * way);
  CHECK(to_scene > 0.05F * way);
}

// Would catch gravity of a body that a factor passes by.
TEST_CASE("copy factors: gravity of a body is scaled, too", "[unit]") {
  const auto options = testing::small_steps({.method = SolverMethod::projection, .copies = 2});
  Scene scene;
  scene.add_body("cube", testing::make_box({1, 1, 1}, kSoftEdge), testing::neo_hookean(1e4F, 0.4F));
  Solver solver(scene, options);
  solver.set_gravity(0, {0, -2, 0});
  solver.set_factors({.gravity = 3}, 1);
  run(solver, 10, 1e-2F);
  CHECK(solver.velocities(0)[0].y() == Approx(-0.2).epsilon(1e-4));
  CHECK(solver.velocities(1)[0].y() == Approx(-0.6).epsilon(1e-4));
}

// Would catch factors that get lost, or come to another copy.
TEST_CASE("copy factors: stay through edits, compaction and a copy of all that moves", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(make_factored_scene(kSame), testing::small_steps({.method = method, .copies = 3}));
  solver.set_factors(kOther, 2);
  run(solver, 3);
  const Snapshot before = solver.snapshot(2);
  solver.restore(before, 2);
  solver.tissue().apply({.remove_tets = {5}});
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  CHECK(solver.factors(2) == kOther);
  CHECK(solver.factors(1) == kSame);
  Solver again = SolverCopy(solver).make(solver.tissue());
  CHECK(again.factors(2) == kSame);
  set_motion(again, motion_of(solver));
  CHECK(again.factors(2) == kOther);
  run(solver, 3);
  run(again, 3);
  CHECK(again.state_hash(2) == solver.state_hash(2));
}

// Would catch steps that are too long for the stiffest copy.
TEST_CASE("copy factors: automatic substeps follow the stiffest copy", "[unit]") {
  SolverOptions options;
  options.copies = 3;
  options.iterations = 1;
  options.coarse_correction = CoarseCorrection::off;
  const Scene scene = testing::make_bar(testing::neo_hookean(10e3F, 0.4F));
  Solver solver(scene, options);
  const float longest = solver.plan().longest_substep;
  const int soft = solver.step(5e-3F).substeps;
  solver.set_factors({.stiffness = 100, .density = 4}, 1);
  CHECK(solver.plan().longest_substep == Approx(longest / 5));
  const int stiff = solver.step(5e-3F).substeps;
  CHECK(stiff >= 5 * (soft - 1));
  CHECK(stiff <= 5 * soft + 1);
  solver.set_factors({}, 1);
  CHECK(solver.step(5e-3F).substeps == soft);
}

// Would catch factors that are taken where nothing follows them, and some that come in part.
TEST_CASE("copy factors: says what it refuses, and changes nothing", "[unit]") {
  const Scene scene = testing::make_bar(testing::neo_hookean(10e3F, 0.4F));
  SolverOptions options = testing::small_steps();
  options.copies = 2;
  Solver solver(scene, options);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuse = [](Solver& of, const CopyFactors& factors, Index copy, const char* what) {
    CHECK_THROWS_WITH(of.set_factors(factors, copy), ContainsSubstring(what));
    CHECK(of.factors() == kSame);
  };
  refuse(solver, {.stiffness = 0}, 1, "copy 1: the factor of stiffness is 0");
  refuse(solver, {.stiffness = 2, .density = nan}, 0, "copy 0: the factor of density is nan");
  refuse(solver, {.density = 2000}, 1, "copy 1: the factor of density is 2000");
  refuse(solver, {.gravity = nan}, 0, "the factor of gravity is nan");
  refuse(solver, {}, 2, "there is no copy 2");
  CHECK_THROWS_WITH(solver.factors(-1), ContainsSubstring("there is no copy -1"));

  solver.set_factors({.gravity = 2}, 1);
  const auto idle = std::make_shared<Idle>();
  solver.add_constraints(idle);
  refuse(solver, {.stiffness = 2}, 0, "custom constraints do not know of it");
  solver.remove_constraints(*idle);
  solver.set_factors({.stiffness = 2}, 1);
  CHECK_THROWS_WITH(solver.add_constraints(idle),
                    ContainsSubstring("does not know the material that copy 1 has of its own"));

  Scene springs;
  springs.add_body("block", testing::make_box({1, 1, 1}, kSoftEdge), testing::kSprings);
  Solver fractions(springs, SolverOptions::paper());
  refuse(fractions, {.stiffness = 2}, 0, "fraction mode has no stiffness");
  fractions.set_factors({.gravity = 2});
  Solver steps(scene, {.method = SolverMethod::explicit_steps});
  refuse(steps, {.density = 2}, 0, "explicit steps");
  steps.set_factors({.gravity = 2});
  SolverOptions automatic;
  automatic.coarse_correction = CoarseCorrection::off;
  automatic.iterations = 1;
  automatic.longest_step = 0.2F;
  Solver fine(scene, automatic);
  refuse(fine, {.stiffness = 1000, .density = 1e-3F}, 0, "copy 0 needs substeps of");
}

}  // namespace pbdsurg
