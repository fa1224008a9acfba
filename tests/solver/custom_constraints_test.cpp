// SPDX-License-Identifier: Apache-2.0
// Constraints of a program's own: what they do to tissue, by each method.
#include "pbdsurg/solver/custom_constraints.h"

#include <algorithm>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "bench/support/static_energy.h"
#include "examples/tether/tethers.h"
#include "tests/solver/custom_constraints_cases.h"
#include "tests/support/free_block.h"
#include "tests/support/instruction_set.h"

namespace pbdsurg {
namespace {

using testing::add_tethers;
using testing::any_recipe;
using testing::Approx;
using testing::kGravity;
using testing::kSoftEdge;
using testing::make_cubes;
using testing::mass_of;
using testing::neo_hookean;
using testing::Recipe;
using testing::run;

double extension(const Solver& solver, const Tether& tether) {
  const auto x = solver.positions();
  const Eigen::Vector3f end = tether.other == kInvalidIndex ? tether.point : x[tether.other];
  return double{(end - x[tether.vertex]).norm()} - double{tether.length};
}

}  // namespace

// Would catch a compliance that depends on substeps or on mass, forces that sweeps forget, and a
// multiplier that is not reset.
TEST_CASE("custom constraints: a weight on a tether stretches it by m g c", "[validation][long]") {
  const Recipe recipe = any_recipe();
  const bool is_between = GENERATE(false, true);  // two vertices
  const float compliance = GENERATE(1.0F, 0.05F, 0.0F);
  INFO(recipe.name << ", " << compliance << " m/N, between vertices " << is_between);
  const Scene scene = make_cubes(recipe, is_between);
  const Index top = testing::highest(scene, 0);
  const float length = 0.02F;
  const Eigen::Vector3f start = scene.positions()[top].cast<float>();
  Tether tether{.vertex = top, .point = start + Eigen::Vector3f(0, length, 0)};
  if (is_between) {
    tether.other = testing::lowest(scene, 1);
    REQUIRE(scene.is_fixed(tether.other));
  }
  tether.length = length;
  tether.compliance = compliance;
  Solver solver(scene, recipe.options);
  const auto tethers = add_tethers(solver, {tether});
  run(solver, 600, 5e-3F);
  const double weight = mass_of(scene, 0) * double{kGravity};
  CAPTURE(weight, extension(solver, tether), tethers->tension(0));
  CHECK(extension(solver, tether) ==
        Approx(weight * double{compliance}).epsilon(0.01).margin(1e-4 * double{length}));
  CHECK(tethers->tension(0) == Approx(weight).epsilon(0.01));
}

// Would catch a rope that pushes.
TEST_CASE("custom constraints: a slack tether changes nothing", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  const Scene scene = make_cubes(recipe, false);
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  Solver plain(scene, options), slack(scene, options), taken(scene, options);
  const Tether tether{.vertex = 3, .point = {0, 0.1F, 0}, .length = 1};
  const auto tethers = add_tethers(slack, {tether});
  const auto others = add_tethers(taken, {{.vertex = 3, .point = {0, 0.1F, 0}}});
  taken.remove_constraints(*others);
  for (Solver* const each : {&plain, &slack, &taken}) {
    run(*each, 3);
  }
  CHECK(plain.state_hash() == slack.state_hash());
  CHECK(plain.state_hash() == taken.state_hash());
  CHECK(tethers->tension(0) == 0);
}

// Would catch pushes that a method weighs differently at both ends, or that it takes for momentum
// that sweeps have made.
TEST_CASE("custom constraints: what a tether joins keeps its momentum", "[property]") {
  const Recipe recipe = any_recipe();
  const float compliance = GENERATE(0.2F, 0.0F);
  INFO(recipe.name << ", " << compliance << " m/N");
  Scene scene = make_cubes(recipe, true, false);
  scene.set_gravity(Eigen::Vector3f::Zero());
  SolverOptions options = recipe.options;
  options.damping = 0;
  Solver solver(scene, options);
  const Index a = testing::highest(scene, 0), b = testing::lowest(scene, 1);
  const auto length =
      static_cast<float>((scene.positions()[a] - scene.positions()[b]).norm() + 1e-3);
  const auto tethers =
      add_tethers(solver, {{.vertex = a, .other = b, .length = length, .compliance = compliance}});
  std::vector<Eigen::Vector3f> velocities;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    velocities.emplace_back(v < scene.body(1).first_vertex ? Eigen::Vector3f(0, -0.2F, 0)
                                                           : Eigen::Vector3f(0.05F, 0.3F, 0));
  }
  solver.write_velocities(velocities);
  const testing::Momenta before = testing::momenta(scene, solver);
  float tension = 0;
  for (int step = 0; step < 20; ++step) {
    run(solver, 1);
    tension = std::max(tension, tethers->tension(0));
  }
  const testing::Momenta after = testing::momenta(scene, solver);
  CHECK(tension > 0);
  // positions of fraction mode round
  const bool rounds = recipe.options.mode == ProjectionMode::fraction;
  CHECK((after.linear - before.linear).norm() < (rounds ? 1e-3 : 2e-5) * before.size);
  // a tether turns within a substep
  CHECK((after.angular - before.angular).norm() < 0.03 * before.angular_size);
  const double speed_apart =
      (testing::mean_velocity(solver, scene, 1) - testing::mean_velocity(solver, scene, 0)).y();
  CHECK(speed_apart < 0.35);  // 0.5 m/s at first
}

// Would catch forces that act in some sweeps only: tissue would come to rest elsewhere.
TEST_CASE("custom constraints: tissue that tethers pull rests where a static solution has it",
          "[validation][long]") {
  const Recipe recipe = any_recipe();
  if (recipe.options.mode == ProjectionMode::fraction) {
    return;  // has no static solution
  }
  const float compliance = GENERATE(0.1F, 0.0F);
  INFO(recipe.name << ", " << compliance << " m/N");
  Scene scene;
  scene.add_body("block", testing::make_box({4, 4, 4}, kSoftEdge, 0.1), neo_hookean(10e3F, 0.4F));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 0.5 * kSoftEdge; });
  std::vector<Tether> wanted;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const Eigen::Vector3d& x = scene.positions()[v];
    if (x.y() > 3.5 * kSoftEdge && x.x() > 2.5 * kSoftEdge) {
      const Eigen::Vector3d point = x + Eigen::Vector3d(0.02, 0.01, 0);
      wanted.push_back({.vertex = v,
                        .point = point.cast<float>(),
                        .length = static_cast<float>((point - x).norm() - 2e-3),
                        .compliance = compliance});
    }
  }
  REQUIRE(wanted.size() == 10);
  Solver solver(scene, recipe.options);
  const auto tethers = add_tethers(solver, wanted);
  run(solver, 300, 2e-3F);
  const auto x = solver.positions();

  bench::StaticEnergy energy(scene);
  double pull = 0;
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const Eigen::Vector3d way = (wanted[i].point - x[wanted[i].vertex]).cast<double>();
    const double tension = tethers->tension(i);
    energy.pull(wanted[i].vertex, tension * way.normalized());
    pull += tension;
    CHECK(extension(solver, wanted[i]) ==
          Approx(tension * double{compliance}).epsilon(0.02).margin(2e-5));
  }
  const bench::Positions rest = bench::find_equilibrium(
      energy, bench::Positions(scene.positions().begin(), scene.positions().end()));
  double largest_way = 0, largest_error = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    largest_way = std::max(largest_way, (rest[v] - scene.positions()[v]).norm());
    largest_error = std::max(largest_error, (x[v].cast<double>() - rest[v]).norm());
  }
  CAPTURE(1e3 * largest_way, 1e3 * largest_error, pull);
  CHECK(largest_way > 1e-3);
  CHECK(largest_error < 0.02 * largest_way);
}

// Would catch forces that lag behind where neighbours yield together: such tissue burst.
TEST_CASE("custom constraints: a face that is drawn together does not burst", "[property][long]") {
  const Recipe recipe = any_recipe();
  const float compliance = GENERATE(0.1F, 0.01F, 0.0F);
  INFO(recipe.name << ", " << compliance << " m/N");
  const Scene scene = make_cubes(recipe, false);
  std::vector<Tether> wanted;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const Eigen::Vector3f x = scene.positions()[v].cast<float>();
    if (x.y() > 1.5F * static_cast<float>(kSoftEdge)) {
      const Eigen::Vector3f point(4e-3F, 0.014F, 4e-3F);
      wanted.push_back(
          {.vertex = v, .point = point, .length = (x - point).norm(), .compliance = compliance});
    }
  }
  REQUIRE(wanted.size() == 9);
  Solver solver(scene, recipe.options);
  constexpr int kSteps = 200;
  std::shared_ptr<Tethers> tethers;
  for (int step = 0; step < kSteps; ++step) {
    for (Tether& tether : wanted) {
      tether.length += (3e-3F - tether.length) / static_cast<float>(kSteps - step);
    }
    if (tethers != nullptr) {
      solver.remove_constraints(*tethers);
    }
    tethers = add_tethers(solver, wanted);
    REQUIRE(run(solver, 1).non_finite_vertices == 0);
  }
  run(solver, 200, 5e-3F);
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    const float tension = tethers->tension(i);
    const double given = extension(solver, wanted[i]) - double{tension * compliance};
    CHECK(given < 1e-4);
    CHECK((tension == 0 || given > -1e-4));
  }
}

// Would catch a set that is called by several threads, or before these have met; and kernels that
// push other vertices.
TEST_CASE("custom constraints: the serial bits on any number of threads and any instruction set",
          "[equivalence]") {
  const Recipe recipe = any_recipe();
  const std::string set = GENERATE("AVX-512", "AVX2", "SSSE3");
  const Index copies = GENERATE(1, 3);
  const testing::InstructionSet only(set);
  const Scene scene = make_cubes(recipe, true);
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  options.composition = PlanComposition::separate;
  options.copies = copies;
  const std::vector<Tether> wanted{
      {.vertex = 2, .other = scene.body(1).first_vertex + 5, .length = 1e-3F, .compliance = 0.01F},
      {.vertex = 2, .point = {0, 0.05F, 0}, .length = 0.02F},
      {.vertex = 20, .other = 7, .compliance = 0.3F}};
  for (const int threads : {1, 3}) {
    options.executor = executor::threads(threads);
    Solver solver(scene, options);
    if (std::string(solver.backend_name()).find(set) == std::string::npos) {
      return;  // this processor has none
    }
    INFO(recipe.name << ", " << solver.backend_name() << ", copies " << copies);
    options.executor = executor::serial();
    Solver reference(scene, options);
    const ToolPose away(Eigen::Translation3f(0, 0, 0));
    for (Solver* const each : {&reference, &solver}) {
      const ToolId tool = each->add_tool({}, away);
      each->grasp(tool, std::array<Index, 2>{0, 2}, 0, copies - 1);
    }
    const auto expected = add_tethers(reference, wanted), found = add_tethers(solver, wanted);
    run(reference, 4);
    run(solver, 4);
    for (Index copy = 0; copy < copies; ++copy) {
      CHECK(solver.state_hash(copy) == reference.state_hash(copy));
      CHECK(solver.tool_force(ToolId(0), copy) == reference.tool_force(ToolId(0), copy));
      CHECK(found->tension(2, copy) == expected->tension(2, copy));
      CHECK(found->tension(2, copy) > 0);
    }
  }
}

// Would catch multipliers or loads of one copy in another.
TEST_CASE("custom constraints: each copy moves as a solver of its own", "[unit]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  const Scene scene = make_cubes(recipe, true);
  const Tether tether{.vertex = 2, .other = scene.body(1).first_vertex, .compliance = 0.05F};
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  options.executor = executor::threads(2);
  Solver alone(scene, options), pulled(scene, options);
  options.copies = 2;
  Solver both(scene, options);
  const auto of_alone = add_tethers(alone, {tether}), of_pulled = add_tethers(pulled, {tether}),
             of_both = add_tethers(both, {tether});
  const std::array<Index, 1> vertex{2};
  const std::array force{Eigen::Vector3f(2e-3F, 0, 0)};
  pulled.set_forces(vertex, force);
  both.set_forces(vertex, force, 1);
  for (Solver* const each : {&alone, &pulled, &both}) {
    run(*each, 5);
  }
  CHECK(both.state_hash(0) == alone.state_hash());
  CHECK(both.state_hash(1) == pulled.state_hash());
  CHECK(of_both->tension(0, 0) == of_alone->tension(0));
  CHECK(of_both->tension(0, 1) == of_pulled->tension(0));
  CHECK(of_both->tension(0, 0) != of_both->tension(0, 1));
}

// Would catch a tool that does not feel what a tether does to the vertex in its jaws.
TEST_CASE("custom constraints: a tool feels the tether of what it holds", "[validation]") {
  const Recipe recipe = any_recipe();
  INFO(recipe.name);
  const Scene scene = make_cubes(recipe, false);
  Solver solver(scene, recipe.options);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const Index v = testing::highest(scene, 0);
  solver.grasp(tool, std::array<Index, 1>{v});
  const Eigen::Vector3f point = scene.positions()[v].cast<float>() + Eigen::Vector3f(0.01F, 0, 0);
  const auto tethers = add_tethers(
      solver, {{.vertex = v, .point = point, .length = 5e-3F, .compliance = 0.5F}});  // 10 mN
  run(solver, 400, 5e-3F);
  const float weight = static_cast<float>(mass_of(scene, 0)) * kGravity;
  const Eigen::Vector3f force = solver.tool_force(tool);
  CHECK(tethers->tension(0) == Approx(0.01).epsilon(0.01));
  CHECK(force.x() == Approx(0.01).epsilon(0.01));
  CHECK(force.y() == Approx(-weight).epsilon(0.03));
}

}  // namespace pbdsurg
