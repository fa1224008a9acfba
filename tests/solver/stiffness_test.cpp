// SPDX-License-Identifier: Apache-2.0
// Tissue that is stiffer in some places than in others, or becomes so, and its stress.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/solver/tet_stress.h"
#include "pbdsurg/tissue/tissue.h"

#include "bench/support/static_energy.h"
#include "tests/support/catch.h"
#include "tests/support/largest_distance.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;
using testing::largest_distance;
using testing::neo_hookean;
using testing::Recipe;
using testing::run;

constexpr std::array<Index, 3> kBarCells{6, 2, 2};
constexpr double kBarLength = kBarCells[0] * kSoftEdge;
const float kPull = 0.02F;  // N, on the end

// A bar along x, held at its start, without weight.
Scene make_weightless_bar(float poissons_ratio = 0.4F) {
  Scene scene = testing::make_bar(neo_hookean(10e3F, poissons_ratio), kBarCells);
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

// [tet] the outer half of the bar is so many times as stiff.
std::vector<float> stiff_half(const Scene& scene, float factor) {
  std::vector<float> factors;
  for (const Tet& tet : scene.tets()) {
    double x = 0;
    for (const Index v : tet) {
      x += scene.positions()[v].x() / 4;
    }
    factors.push_back(x > kBarLength / 2 ? factor : 1);
  }
  return factors;
}

TopologyEdit stiffening(const std::vector<float>& factors) {
  TopologyEdit edit;
  for (std::size_t t = 0; t < factors.size(); ++t) {
    if (factors[t] != 1) {
      edit.stiffnesses.push_back({static_cast<Index>(t), factors[t]});
    }
  }
  return edit;
}

std::vector<Index> end_of(const Scene& scene) {
  std::vector<Index> end;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > kBarLength - 0.5 * kSoftEdge) {
      end.push_back(v);
    }
  }
  return end;
}

std::vector<Eigen::Vector3f> shared_pull(const std::vector<Index>& end) {
  return std::vector<Eigen::Vector3f>(
      end.size(), Eigen::Vector3f(kPull / static_cast<float>(end.size()), 0, 0));
}

Recipe any_recipe_at_rest() {
  return GENERATE(
      Recipe{"default", {.damping = 30}},
      Recipe{"vertex blocks",
             {.method = SolverMethod::vertex_block, .iterations = 30, .damping = 30}},
      Recipe{"projections", {.method = SolverMethod::projection, .iterations = 10, .damping = 30}},
      Recipe{"explicit", {.method = SolverMethod::explicit_steps, .damping = 30}});
}

}  // namespace

// Would catch stiffness that a method reads from the body, at the start or once it changes, and an
// undo that leaves some of it behind.
TEST_CASE("stiffness: a bar that is stiffened on its way rests where a static solution has it",
          "[property]") {
  const Recipe recipe = any_recipe_at_rest();
  INFO(recipe.name);
  const Scene soft = make_weightless_bar();
  const std::vector<float> factors = stiff_half(soft, 4);
  Scene stiff = make_weightless_bar();
  stiff.set_stiffnesses(0, factors);
  const std::vector<Index> end = end_of(soft);
  const auto rest_of = [&](const Scene& scene) {
    bench::StaticEnergy energy(scene);
    for (const Index v : end) {
      energy.pull(v, shared_pull(end)[0].cast<double>());
    }
    return bench::find_equilibrium(
        energy, bench::Positions(scene.positions().begin(), scene.positions().end()));
  };
  const bench::Positions soft_rest = rest_of(soft), stiff_rest = rest_of(stiff);
  const double way = (soft_rest[end[0]] - stiff_rest[end[0]]).norm();
  REQUIRE(way > 0.2e-3);

  Solver solver(soft, recipe.options), from_start(stiff, recipe.options);
  for (Solver* each : {&solver, &from_start}) {
    each->set_forces(end, shared_pull(end));
    run(*each, 300, 2e-3F);
  }
  CHECK(largest_distance(soft_rest, solver.positions()) < 0.02 * way);
  CHECK(largest_distance(stiff_rest, from_start.positions()) < 0.02 * way);
  solver.tissue().apply(stiffening(factors));
  const auto tet = static_cast<Index>(std::ranges::max_element(factors) -
                                      factors.begin());  // the first of the stiff ones
  CHECK(solver.tissue().stiffness(tet) == 4);
  run(solver, 300, 2e-3F);
  CHECK(largest_distance(stiff_rest, solver.positions()) < 0.02 * way);
  solver.tissue().undo();
  CHECK(solver.tissue().stiffness(tet) == 1);
  run(solver, 300, 2e-3F);
  CHECK(largest_distance(soft_rest, solver.positions()) < 0.02 * way);
}

// Would catch halves that do not carry one force: the closed form of two springs in series.
TEST_CASE("stiffness: halves of a bar stretch as their moduli say", "[unit]") {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("bar", testing::make_box(kBarCells, kSoftEdge), neo_hookean(10e3F, 0));
  scene.fix_where(0, [](const Eigen::Vector3d& x) {
    return x.x() < 0.5 * kSoftEdge || x.x() > kBarLength - 0.5 * kSoftEdge;
  });
  scene.set_stiffnesses(0, stiff_half(scene, 4));
  Solver solver(scene, {.method = SolverMethod::vertex_block, .iterations = 30, .damping = 30});
  constexpr float kWay = 0.01F * kBarLength;
  std::vector<Eigen::Vector3f> x = solver.positions();
  for (const Index v : end_of(scene)) {
    x[v].x() += kWay;
  }
  solver.write_positions(x);
  run(solver, 200, 2e-3F);
  x = solver.positions();
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const double at = scene.positions()[v].x();
    if (std::abs(at - kBarLength / 2) < 1e-6) {
      CHECK(x[v].x() - at == Approx(0.8 * kWay).epsilon(0.02));
    }
  }
}

// Would catch wrong entries of a tensor, moduli that it does not follow, and volumes left out.
TEST_CASE("stiffness: stress of an even stretch has its closed form", "[unit]") {
  Scene scene = make_weightless_bar();
  scene.set_stiffnesses(0, std::vector<float>(scene.tets().size(), 3));
  Solver solver(scene, testing::small_steps());
  Eigen::Matrix3d stretch;
  stretch << 1.3, 0.2, 0, 0, 0.9, 0.1, -0.1, 0, 1.1;
  std::vector<Eigen::Vector3f> x;
  for (const Eigen::Vector3d& at : scene.positions()) {
    x.push_back((stretch * at).cast<float>());
  }
  solver.write_positions(x);
  const double modulus = 30e3, ratio = 0.4;
  const double mu = modulus / (2 * (1 + ratio));
  const double lambda = modulus * ratio / ((1 + ratio) * (1 - 2 * ratio));
  const double volume = stretch.determinant();
  // of the energy mu/2 (|F|^2 - 3) + (lambda + mu)/2 (J - 1 - mu/(lambda + mu))^2, derived by hand
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d expected =
      mu / volume * stretch * stretch.transpose() + ((lambda + mu) * (volume - 1) - mu) * one;
  const std::array<Index, 2> tets{3, 17};
  for (const TetStress& each : tet_stresses(solver, tets)) {
    CHECK((each.deformation.cast<double>() - stretch).norm() < 1e-5);
    CHECK((each.strain.cast<double>() - 0.5 * (stretch.transpose() * stretch - one)).norm() < 1e-5);
    CHECK((each.stress.cast<double>() - expected).norm() < 1e-4 * expected.norm());
  }
}

// Would catch a stress that is none of the forces that the solver balances: in equilibrium, stress
// times volume sums up to pulls times the places where they pull.
TEST_CASE("stiffness: stress balances what pulls", "[property]") {
  const Recipe recipe = any_recipe_at_rest();
  INFO(recipe.name);
  Scene scene = make_weightless_bar();
  scene.set_stiffnesses(0, stiff_half(scene, 4));
  const std::vector<Index> end = end_of(scene);
  Solver solver(scene, recipe.options);
  solver.set_forces(end, shared_pull(end));
  run(solver, 400, 2e-3F);
  std::vector<Index> tets(scene.tets().size());
  for (std::size_t t = 0; t < tets.size(); ++t) {
    tets[t] = static_cast<Index>(t);
  }
  const auto x = solver.positions();
  double sum = 0, pulls = 0;
  const std::vector<TetStress> stresses = tet_stresses(solver, tets);
  for (const Index t : tets) {
    const double volume =
        solver.rest_volume(t) * stresses[t].deformation.cast<double>().determinant();
    sum += volume * stresses[t].stress(0, 0);
  }
  for (const Index v : end) {
    pulls += double{shared_pull(end)[0].x()} * x[v].x();
  }
  CHECK(sum == Approx(pulls).epsilon(0.02));
}

// Would catch a solver that steps stiff tissue with the substeps of soft tissue.
TEST_CASE("stiffness: automatic substeps follow it", "[unit]") {
  SolverOptions options;
  options.coarse_correction = CoarseCorrection::off;
  options.iterations = 1;
  const Scene scene = make_weightless_bar();
  Solver solver(scene, options);
  const int soft = solver.step(5e-3F).substeps;
  std::vector<float> factors(scene.tets().size(), 1);
  factors[5] = 25;
  solver.tissue().apply(stiffening(factors));
  const int stiff = solver.step(5e-3F).substeps;
  CHECK(stiff >= 4 * soft);
  CHECK(stiff <= 6 * soft);
  solver.tissue().undo();
  CHECK(solver.step(5e-3F).substeps == soft);
  Scene at_start = make_weightless_bar();
  at_start.set_stiffnesses(0, factors);
  CHECK(std::abs(Solver(at_start, options).step(5e-3F).substeps - stiff) <= 1);
  options.substeps = 10;
  Solver with_ten(scene, options);
  with_ten.tissue().apply(stiffening(factors));
  CHECK(with_ten.step(5e-3F).substeps == 10);
}

// Would catch a stiffness that nothing has, and one that is taken in silence.
TEST_CASE("stiffness: says what it refuses, and changes nothing", "[unit]") {
  Scene scene = make_weightless_bar();
  scene.add_body("springs", testing::make_box({1, 1, 1}, kSoftEdge), testing::kSprings);
  const auto count = static_cast<std::size_t>(scene.body(0).tet_count);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuse = [&](Index body, const std::vector<float>& factors, const char* what) {
    CHECK_THROWS_WITH(scene.set_stiffnesses(body, factors), ContainsSubstring(what));
    CHECK(std::ranges::all_of(scene.stiffnesses(), [](float factor) { return factor == 1; }));
  };
  refuse(1, std::vector<float>(6, 2), "body 'springs', which is not Neo-Hookean");
  refuse(2, {}, "there is no body 2");
  refuse(0, {2}, "and got 1 stiffnesses");
  std::vector<float> bad(count, 2);
  bad[7] = 0;
  refuse(0, bad, "body 'bar': tet 7 is to be 0 times as stiff");
  bad[7] = nan;
  refuse(0, bad, "tet 7 is to be nan times");

  Solver solver(scene, testing::small_steps());
  const auto refuse_edit = [&](const TopologyEdit& edit, const char* what) {
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(what));
    CHECK(solver.tissue().version() == 0);
  };
  refuse_edit({.stiffnesses = {{3, 1001}}}, "tet 3 is to be 1001 times as stiff");
  refuse_edit({.stiffnesses = {{3, 2}, {3, 3}}}, "tet 3 is listed twice");
  refuse_edit({.stiffnesses = {{-1, 2}}}, "tet -1 does not exist");
  refuse_edit({.stiffnesses = {{scene.body(1).first_tet, 2}}}, "is not Neo-Hookean");
  const std::array<Index, 1> of_springs{scene.body(1).first_tet};
  CHECK_THROWS_WITH(tet_stresses(solver, of_springs), ContainsSubstring("is not Neo-Hookean"));
  solver.tissue().apply({.remove_tets = {3}});
  CHECK_THROWS_WITH(solver.tissue().apply({.stiffnesses = {{3, 2}}}),
                    ContainsSubstring("tet 3 was removed before"));
  const std::array<Index, 1> gone{3};
  CHECK_THROWS_WITH(tet_stresses(solver, gone), ContainsSubstring("tet 3 was removed"));
  SolverOptions automatic;
  automatic.longest_step = 0.1F;
  automatic.coarse_correction = CoarseCorrection::off;
  automatic.iterations = 1;
  Solver fine(make_weightless_bar(), automatic);
  CHECK_THROWS_WITH(fine.tissue().apply({.stiffnesses = {{3, 1000}}}),
                    ContainsSubstring("body 'bar' needs substeps of"));
}

}  // namespace pbdsurg
