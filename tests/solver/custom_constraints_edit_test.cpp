// SPDX-License-Identifier: Apache-2.0
// Constraints of a program's own: edits, copies of the tissue, and what is refused.
#include <atomic>
#include <functional>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/custom_constraints.h"
#include "pbdsurg/solver/solver.h"

#include "examples/tether/tethers.h"
#include "tests/solver/custom_constraints_cases.h"
#include "tests/support/fake_device.h"

namespace pbdsurg {
namespace {

using testing::add_tethers;
using testing::any_recipe;
using testing::Approx;
using testing::ContainsSubstring;
using testing::make_cubes;
using testing::Recipe;
using testing::run;

constexpr float kNotANumber = std::numeric_limits<float>::quiet_NaN();

// Does in each sweep what a test wants.
struct Scripted final : CustomConstraints {
  explicit Scripted(std::function<void(ConstraintSweep&)> wanted, std::vector<Index> named = {0, 1})
      : act(std::move(wanted)), named_vertices(std::move(named)) {}

  [[nodiscard]] std::string name() const override { return "scripted"; }
  [[nodiscard]] std::span<const Index> vertices() const override { return named_vertices; }
  void begin_step(Index copies) override {
    copy_count = copies;
    substeps = 0;
  }
  void begin_substep(const ConstraintSweep&) override { ++substeps; }
  void project(ConstraintSweep& sweep) override { act(sweep); }
  void follow(const Tissue&, const TissueChange&) noexcept override { ++follows; }
  void undo(const Tissue&, const TissueChange&) noexcept override { ++undos; }
  void renumber(const Tissue&, const Renumbering&) noexcept override { ++renumberings; }

  std::function<void(ConstraintSweep&)> act;
  std::vector<Index> named_vertices;
  Index copy_count = 0;
  std::atomic<int> substeps = 0;  // of copies, which threads step at the same time
  int follows = 0, undos = 0, renumberings = 0;
};

std::vector<Index> tets_at(const Solver& solver, Index vertex) {
  const auto tets = solver.tissue().tets_at(vertex);
  return {tets.begin(), tets.end()};
}

SolverOptions strict(const Recipe& recipe) {
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  return options;
}

}  // namespace

// Would catch a tether that holds what is left by what is gone, and an undo that leaves a trace.
TEST_CASE("custom constraints: a tether ends with its tissue and comes back with it", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  const Scene scene = make_cubes(recipe, true);
  const Index a = testing::highest(scene, 0), b = testing::lowest(scene, 1);
  const Tether tether{.vertex = a, .other = b, .length = 0.02F, .compliance = 0.5F};
  Solver solver(scene, strict(recipe)), untouched(scene, strict(recipe));
  const auto tethers = add_tethers(solver, {tether}), same = add_tethers(untouched, {tether});
  run(solver, 20);
  run(untouched, 20);
  REQUIRE(tethers->tension(0) > 0);

  solver.tissue().apply({.remove_tets = tets_at(solver, a)});
  REQUIRE_FALSE(solver.tissue().has_tissue(a));
  solver.tissue().undo();
  run(solver, 3);
  run(untouched, 3);
  CHECK(solver.state_hash() == untouched.state_hash());
  CHECK(tethers->tension(0) == same->tension(0));

  solver.tissue().apply({.remove_tets = tets_at(solver, a)});
  const float speed = static_cast<float>(testing::mean_velocity(solver, scene, 0).y());
  const StepReport report = run(solver, 5);
  CHECK(report.non_finite_vertices == 0);
  CHECK(tethers->tension(0) == 0);
  CHECK(testing::mean_velocity(solver, scene, 0).y() < double{speed});  // it falls
}

// Would catch ids of before, or a set that the solver forgets.
TEST_CASE("custom constraints: tethers go along with a compaction", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  const Scene scene = make_cubes(recipe, true);
  const Index first = scene.body(1).first_vertex;
  // the body that stays hangs; the other goes
  Scene hanging = scene;
  Solver solver(hanging, recipe.options);
  const Index a = testing::highest(scene, 0);
  const Eigen::Vector3f point = scene.positions()[a].cast<float>() + Eigen::Vector3f(0, 0.01F, 0);
  const Tether kept{.vertex = a, .point = point, .length = 0.01F, .compliance = 0.2F};
  const auto tethers =
      add_tethers(solver, {{.vertex = 3, .other = first}, kept, {.vertex = first + 2}});
  solver.tissue().apply({.remove_bodies = {1}});
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  REQUIRE(tethers->all().size() == 1);
  CHECK(tethers->all()[0].vertex == ids.vertices[a]);
  CHECK(tethers->is_following());
  run(solver, 600, 5e-3F);
  const double weight = testing::mass_of(scene, 0) * 9.81;
  CHECK(tethers->tension(0) == Approx(weight).epsilon(0.01));
  CHECK((point - solver.positions()[ids.vertices[a]]).norm() - 0.01F ==
        Approx(0.2 * weight).epsilon(0.01));
}

TEST_CASE("custom constraints: a set is told of edits, and how often it is called", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  SolverOptions options = strict(recipe);
  options.copies = 2;
  options.executor = executor::serial();
  std::vector<int> indices;
  bool is_right = true;
  const auto set = std::make_shared<Scripted>([&](ConstraintSweep& sweep) {
    indices.push_back(sweep.index());
    is_right =
        is_right && !sweep.is_probe() && sweep.dt() > 0 && sweep.inverse_mass(0) > 0 &&
        sweep.copy() >= 0 && sweep.copy() < 2 && sweep.has_tissue(1) &&
        (sweep.position(1) - sweep.position(0) - sweep.way(0, 1)).norm() < 1e-6F &&
        (sweep.way_to(0, {1, 2, 3}) + sweep.position(0) - Eigen::Vector3f(1, 2, 3)).norm() < 1e-6F;
  });
  {
    Solver solver(make_cubes(recipe, false), options);
    solver.add_constraints(set);
    const int substeps = run(solver, 1).substeps;
    CHECK(is_right);
    CHECK(set->copy_count == 2);
    CHECK(set->substeps == 2 * substeps);
    const bool has_blocks = solver.options().method == SolverMethod::vertex_block;
    CHECK(indices.front() == (has_blocks ? -1 : 0));
    CHECK(indices.size() % static_cast<std::size_t>(2 * substeps) == 0);
    solver.tissue().apply({.remove_tets = {4}});
    solver.tissue().undo();
    Compaction compaction(solver);
    compaction.build();
    compaction.finish(solver);
    CHECK(set->follows == 1);
    CHECK(set->undos == 1);
    CHECK(set->renumberings == 1);
    solver.remove_constraints(*set);
    CHECK_FALSE(set->is_following());
    solver.add_constraints(set);
  }
  CHECK_FALSE(set->is_following());  // with its solver
}

// Would catch a step that a callback ends half-way, or an exception that threads lose.
TEST_CASE("custom constraints: what a callback throws leaves all as before the step", "[unit]") {
  const Recipe recipe = any_recipe();
  const Index copies = GENERATE(1, 3);
  const auto executor = GENERATE(executor::serial(), executor::threads(2));
  INFO(recipe.name << ", copies " << copies << ", " << executor.name());
  SolverOptions options = strict(recipe);
  options.copies = copies;
  options.executor = executor;
  const Scene scene = make_cubes(recipe, false);
  Solver solver(scene, options), untouched(scene, options);
  const ToolPose there(Eigen::Translation3f(1e-3F, 0, 0));
  bool throws = false;
  const auto set = std::make_shared<Scripted>([&](ConstraintSweep& sweep) {
    if (throws && sweep.copy() == copies - 1 && sweep.index() == 0) {
      throw std::runtime_error("not now");
    }
    sweep.push(0, {1e-4F, 0, 0});
  });
  solver.add_constraints(set);
  untouched.add_constraints(std::make_shared<Scripted>([&](ConstraintSweep& sweep) {
    sweep.push(0, {1e-4F, 0, 0});
  }));
  for (Solver* const each : {&solver, &untouched}) {
    const ToolId tool = each->add_tool({}, ToolPose::Identity());
    each->grasp(tool, std::array<Index, 2>{5, 6});
    run(*each, 2);
    each->move_tool(tool, there);
  }
  throws = true;
  CHECK_THROWS_WITH(solver.step(5e-3F), ContainsSubstring("not now"));
  CHECK(solver.state_hash(copies - 1) == untouched.state_hash(copies - 1));
  CHECK(solver.tool_pose(ToolId(0)).isApprox(ToolPose::Identity()));
  throws = false;
  run(solver, 2);
  run(untouched, 2);
  for (Index copy = 0; copy < copies; ++copy) {
    CHECK(solver.state_hash(copy) == untouched.state_hash(copy));
    CHECK(solver.tool_force(ToolId(0), copy) == untouched.tool_force(ToolId(0), copy));
  }
}

TEST_CASE("custom constraints: bad pushes are refused by set, vertex and number", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  Solver solver(make_cubes(recipe, false), recipe.options);
  const auto set = std::make_shared<Scripted>([](ConstraintSweep&) {});
  solver.add_constraints(set);
  run(solver, 1);
  const std::uint64_t before = solver.state_hash();
  const auto refuses = [&](const std::function<void(ConstraintSweep&)>& act, const char* why) {
    set->act = act;
    CHECK_THROWS_AS(solver.step(5e-3F), InvalidArgument);
    CHECK_THROWS_WITH(solver.step(5e-3F),
                      ContainsSubstring("constraint set 'scripted'") && ContainsSubstring(why));
    CHECK(solver.state_hash() == before);
  };
  refuses(
      [](ConstraintSweep& sweep) {
        sweep.push(1, {0, kNotANumber, 0});
      },
      "vertex 1 would go nowhere under a force of (0, nan, 0) N");
  refuses(
      [](ConstraintSweep& sweep) {
        sweep.push(1, {3e38F, 0, 3e38F});
      },
      "vertex 1 would go nowhere");
  refuses(
      [](ConstraintSweep& sweep) {
        sweep.push(7, {0, 0, 1});
      },
      "vertex 7 is not among its vertices()");
  refuses([](ConstraintSweep& sweep) { static_cast<void>(sweep.position(27)); },
          "there is no vertex 27; ids must be in [0, 27)");
  refuses([](ConstraintSweep& sweep) { sweep.push(-1, {0, 0, 1}); }, "there is no vertex -1");
  const auto satisfies = [](float value, float compliance) {
    return [=](ConstraintSweep& sweep) {
      const std::array<ConstraintSweep::Corner, 1> corners{{{1, {0, 1, 0}}}};
      static_cast<void>(sweep.satisfy(corners, value, compliance, 0));
    };
  };
  refuses(satisfies(kNotANumber, 0), "vertex 1 has a constraint of value nan");
  refuses(satisfies(1e-3F, -1), "compliance -1");
  set->act = [](ConstraintSweep&) {};
  set->named_vertices = {3, 27};
  CHECK_THROWS_WITH(solver.step(5e-3F),
                    ContainsSubstring("constraint set 'scripted' names vertex 27; ids must be in "
                                      "[0, 27)"));
  set->named_vertices = {3};
  CHECK(solver.state_hash() == before);
  CHECK(run(solver, 1).non_finite_vertices == 0);
}

TEST_CASE("custom constraints: sets that a solver cannot have are refused", "[unit]") {
  const Recipe recipe = any_recipe();
  const Scene scene = make_cubes(recipe, false);
  Solver solver(scene, recipe.options), other(scene, recipe.options);
  const auto set = add_tethers(solver, {{.vertex = 1}});
  CHECK_THROWS_WITH(solver.add_constraints(set),
                    ContainsSubstring("'tethers' was added to this solver already"));
  CHECK_THROWS_WITH(other.add_constraints(set),
                    ContainsSubstring("'tethers' follows a tissue already"));
  CHECK_THROWS_WITH(solver.add_constraints(nullptr), ContainsSubstring("null pointer"));
  CHECK_THROWS_WITH(other.remove_constraints(*set),
                    ContainsSubstring("'tethers' was not added to this solver"));
  CHECK(other.plan().phases.size() + 1 == solver.plan().phases.size());
  CHECK(set->is_following());

  const auto fresh = std::make_shared<Tethers>(std::vector<Tether>{{.vertex = 1}});
  const Scene solids = make_cubes({}, false);
  Solver explicit_steps(solids, {.method = SolverMethod::explicit_steps});
  CHECK_THROWS_WITH(explicit_steps.add_constraints(fresh),
                    ContainsSubstring("explicit steps have none"));
  Solver device(solids, {.executor = testing::fake_device()});
  CHECK_THROWS_AS(device.add_constraints(fresh), BackendUnavailable);
  CHECK_THROWS_WITH(device.add_constraints(fresh),
                    ContainsSubstring("'tethers' is called on a CPU; fake device"));
  CHECK_FALSE(fresh->is_following());
}

// Would catch a probe that counts what tethers hold as out of balance, or that changes a bit.
TEST_CASE("custom constraints: a probe of convergence projects them and leaves them out",
          "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  if (recipe.options.mode == ProjectionMode::fraction) {
    return;
  }
  Solver solver(make_cubes(recipe, false), recipe.options);
  const auto tethers = add_tethers(
      solver,
      {{.vertex = 26, .point = {8e-3F, 0.03F, 8e-3F}, .length = 0.022F, .compliance = 0.1F}});
  int probes = 0;
  solver.add_constraints(std::make_shared<Scripted>(
      [&](ConstraintSweep& sweep) { probes += sweep.is_probe() ? 1 : 0; }, std::vector<Index>{}));
  run(solver, 300);
  CHECK(probes == 0);
  const std::uint64_t before = solver.state_hash();
  const Convergence probe = solver.convergence(5e-3F).at(0);
  CHECK(probes > 0);
  CHECK(solver.state_hash() == before);
  CHECK(probe.vertex_count == 26);
  CHECK(probe.ratio() < 0.1);
}

}  // namespace pbdsurg
