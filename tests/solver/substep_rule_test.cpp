// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/substep_rule.h"

#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/digest.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_digest.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;

// s, of a mesh of cubes of six tetrahedra each, and a Poisson's ratio of 0.45
double crossing_time(double edge, double youngs_modulus) {
  const double modulus = youngs_modulus * 0.55 / (1.45 * 0.1);
  return std::cbrt(std::sqrt(2.0)) * edge * std::sqrt(1000 / modulus);
}

SolverOptions automatic(SolverMethod method = SolverMethod::vertex_block) {
  return {.method = method, .substeps = kAutomatic, .iterations = kAutomatic};
}

// Vertex blocks by sweeps alone.
SolverOptions plain() {
  SolverOptions options = automatic();
  options.coarse_correction = CoarseCorrection::off;
  return options;
}

// Each way that has automatic substeps of its own.
std::vector<SolverOptions> all_automatic() {
  return {automatic(), plain(), automatic(SolverMethod::projection)};
}

double sag_of(const Scene& scene, SolverOptions options, float dt, float seconds, float damping) {
  options.damping = damping;
  Solver solver(scene, options);
  run(solver, static_cast<int>(seconds / dt), dt);
  return scene.positions().back().y() - double{solver.positions().back().y()};
}

}  // namespace

TEST_CASE("substep rule: sqrt(10 ms t) with a coarse correction, t of a wave across an edge",
          "[unit]") {
  const double edge = 4e-3;
  const Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {6, 3, 3}, edge);
  const double usual = std::sqrt(1e-2 * crossing_time(edge, 2e4));
  const auto longest = [&](const SolverOptions& options) {
    return Solver(scene, options).plan().longest_substep;
  };
  CHECK(longest({}) == Approx(usual).epsilon(0.02));
  CHECK(longest(automatic()) == longest({}));
  CHECK(longest({.accuracy = 0.08F}) == Approx(2 * usual).epsilon(0.02));
  CHECK(longest({.iterations = 8}) == Approx(2 * usual).epsilon(0.02));  // given, substeps are not
  CHECK(longest({.longest_step = 1e-4F}) == 1e-4F);                      // in one substep
  CHECK(longest({.substeps = 10}) == 0);
  const Scene soft = make_bar(neo_hookean(1e3F, 0.3F), {6, 3, 3}, edge);
  CHECK(Solver(soft).plan().longest_substep == Approx(1.0 / 300));
  CHECK_THAT(Solver(soft).plan().name,
             ContainsSubstring(": 5 of 2 sweeps in a step of 16.6667 ms"));
}

TEST_CASE("substep rule: a share of the time in which waves cross an edge", "[unit]") {
  const double edge = 4e-3;
  const Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {6, 3, 3}, edge);
  const double crossing = crossing_time(edge, 2e4);
  const auto longest = [&](const SolverOptions& options) {
    return Solver(scene, options).plan().longest_substep;
  };
  CHECK(longest(plain()) == Approx(0.95 * crossing).epsilon(0.02));
  CHECK(longest(automatic(SolverMethod::projection)) == Approx(0.3 * crossing).epsilon(0.02));
  CHECK(longest({.iterations = 1}) == longest(plain()));  // no correction fits in one
  SolverOptions other = plain();
  other.accuracy = 0.08F;
  CHECK(longest(other) == Approx(1.9 * crossing).epsilon(0.02));
  other.iterations = 4;  // given, substeps are not
  CHECK(longest(other) == Approx(3.8 * crossing).epsilon(0.02));
  other.longest_step = 1e-4F;  // in one substep
  CHECK(longest(other) == 1e-4F);
  CHECK(longest({.substeps = 10, .iterations = 1}) == 0);

  Scene stiffer = scene;  // the stiffest body counts
  stiffer.add_body("wall", testing::make_box({2, 2, 2}, edge), neo_hookean(3.2e5F, 0.45F));
  CHECK(Solver(stiffer, plain()).plan().longest_substep == Approx(0.2375 * crossing).epsilon(0.02));
}

// Would catch a step that takes other substeps than the plan says.
TEST_CASE("substep rule: a step of any length has so many, and their bits", "[golden]") {
  const SolverOptions options = GENERATE(from_range(all_automatic()));
  const Scene scene = make_bar(neo_hookean(2e4F, 0.4F), {5, 2, 2});
  Solver solver(scene, options);
  const float longest = solver.plan().longest_substep;
  CHECK_THAT(solver.plan().name, ContainsSubstring("in a step of 16.6667 ms"));
  for (const float share : {0.3F, 1.0F, 1.2F, 7.0F, 50.5F}) {
    SolverOptions given = solver.options();
    given.substeps = static_cast<int>(std::ceil(share - 1e-3F));
    given.iterations = given.coarse_correction == CoarseCorrection::on ? 2 : 1;
    Solver same(scene, given);
    Solver one(scene, options);
    run(same, 3, share * longest);
    run(one, 3, share * longest);
    CHECK(one.state_hash() == same.state_hash());
  }
}

TEST_CASE("substep rule: tissue is as stiff at rest in steps of any length", "[validation]") {
  const float youngs_modulus = GENERATE(5e3F, 8e4F);
  const Scene scene = make_bar(neo_hookean(youngs_modulus, 0.45F), {6, 3, 3});
  const auto sag = [&](const SolverOptions& options, float dt) {
    return sag_of(scene, options, dt, 1.2F, 60);
  };
  const double expected =
      sag({.method = SolverMethod::vertex_block, .substeps = 4, .iterations = 20}, 2e-3F);
  REQUIRE(expected > 1e-5);
  for (const float dt : {1e-3F, 5e-3F, 16e-3F, 33e-3F}) {
    CHECK(sag({}, dt) == Approx(expected).epsilon(0.01));
    CHECK(sag(plain(), dt) == Approx(expected).epsilon(0.02));
  }
  CHECK(sag(automatic(SolverMethod::projection), 16e-3F) == Approx(expected).epsilon(0.04));
}

// What bends takes sweeps alone the longest to find. Would catch a correction that the default
// lacks, or substeps that it cannot do with.
TEST_CASE("substep rule: a slender cantilever comes to rest in steps of any length",
          "[validation]") {
  Scene scene = make_bar(neo_hookean(25e4F, 0.3F), {40, 2, 2});
  scene.set_gravity({0, -1, 0});
  const auto sag = [&](const SolverOptions& options, float dt) {
    return sag_of(scene, options, dt, 1.5F, 20);
  };
  const double expected =
      sag({.substeps = 8, .iterations = 8, .coarse_correction = CoarseCorrection::on}, 1e-3F);
  REQUIRE(expected > 1e-3);
  for (const float dt : {1e-3F, 5e-3F, 16e-3F, 33e-3F}) {
    CHECK(sag({}, dt) == Approx(expected).epsilon(0.01));
  }
}

TEST_CASE("substep rule: what cannot be met is refused, with the number", "[unit]") {
  const auto refuse = [](const Material& material, const SolverOptions& options,
                         const std::string& why) {
    CHECK_THROWS_WITH(Solver(make_bar(material, {3, 2, 2}), options), ContainsSubstring(why));
  };
  refuse(neo_hookean(5e13F, 0.3F), {}, "or less: more than 1000 in the longest step");
  refuse(neo_hookean(5e9F, 0.3F), plain(),
         "body 'bar' needs substeps of 1.61698e-06 s or less: more than 1000 in the longest step");
  refuse(testing::kSprings, automatic(SolverMethod::projection),
         "body 'bar' has springs of compliance 0");
  refuse(testing::kSprings, {}, "body 'bar' has springs of compliance 0");
  SolverOptions options = automatic(SolverMethod::projection);
  options.mode = ProjectionMode::fraction;
  refuse(testing::kSprings, options, "automatic; fraction mode has no stiffness");
  refuse(testing::kSprings, {.mode = ProjectionMode::fraction, .substeps = 2}, "name both");
  const Material soft = neo_hookean(1e4F, 0.3F);
  for (const float accuracy : {0.0F, -1.0F, 1.1F, std::nanf("")}) {
    options = {};
    options.accuracy = accuracy;
    refuse(soft, options, "it must be in [0.001, 1]");
  }
  for (const float step : {0.0F, -1.0F, std::nanf("")}) {
    options = {};
    options.longest_step = step;
    refuse(soft, options, "longest_step is");
  }
  const SolverOptions given{.substeps = 10, .iterations = 1};
  options = given;
  options.accuracy = 0.1F;
  refuse(soft, options, "accuracy is 0.100000, which nothing would read");
  options = given;
  options.longest_step = 0.1F;
  refuse(soft, options, "it needs automatic substeps or iterations");
  refuse(soft, {.substeps = -1}, "substeps is -1; it must be >= 1, or 0 for automatic ones");
  refuse(soft, {.iterations = -1}, "iterations is -1; it must be >= 1");
  refuse(neo_hookean(1e7F, 0.3F), {.substeps = 1, .coarse_correction = CoarseCorrection::off},
         "body 'bar' needs 212480 sweeps of a substep: more than 1000");
  refuse(neo_hookean(1e8F, 0.3F), {.substeps = 1}, "sweeps of a substep: more than 1000");
  Material sticky = soft;
  sticky.damping = 10;
  refuse(sticky, plain(), "sweeps of a substep: more than 1000");
  CHECK_NOTHROW(Solver(make_bar(sticky, {3, 2, 2})));
}

// Would catch a default that depends on the machine, and one that adds to numbers that are named.
TEST_CASE("substep rule: the correction is on where scene and options leave numbers to it",
          "[unit]") {
  const Scene scene = make_bar(neo_hookean(1e4F, 0.3F), {3, 2, 2});
  const auto chosen = [&](const SolverOptions& options) {
    return Solver(scene, options).options().coarse_correction;
  };
  const auto on = CoarseCorrection::on, off = CoarseCorrection::off;
  CHECK(chosen({}) == on);
  CHECK(chosen({.substeps = 4}) == on);
  CHECK(chosen({.iterations = 2}) == on);
  CHECK(chosen({.iterations = 1}) == off);
  CHECK(chosen({.substeps = 4, .iterations = 2}) == off);
  CHECK(chosen({.substeps = 4, .iterations = 2, .coarse_correction = on}) == on);
  CHECK(chosen({.coarse_correction = off}) == off);
  CHECK(chosen({.method = SolverMethod::projection}) == off);
  CHECK(chosen({.method = SolverMethod::explicit_steps}) == off);
  CHECK(Solver(Scene{}).options().coarse_correction == on);
  CHECK_NOTHROW(Solver(scene, Solver(scene).options()));

  const std::string name = Solver(scene, {.executor = executor::serial()}).plan().name;
  CHECK_THAT(name, ContainsSubstring(", coarse correction, substeps of "));
  for (const int threads : {1, 2, 3}) {
    CHECK(Solver(scene, {.executor = executor::threads(threads)}).plan().name == name);
  }
  const auto hash_of = [&](CoarseCorrection correction) {
    Solver solver(scene, {.substeps = 4, .iterations = 2, .coarse_correction = correction});
    run(solver, 3, 5e-3F);
    return solver.state_hash();
  };
  CHECK(hash_of(CoarseCorrection::automatic) == hash_of(off));
  CHECK(hash_of(on) != hash_of(off));
}

// Would catch pieces that are too soft because no node is theirs, and a number of nodes that the
// rule does not know of.
TEST_CASE("substep rule: no correction where pieces are more than nodes", "[unit]") {
  const TetMesh small = testing::make_box({2, 2, 2}, testing::kSoftEdge);  // 27 vertices
  const auto scene_of = [&](int count, bool has_links) {
    Scene scene;
    for (int i = 0; i < count; ++i) {
      scene.add_body(std::to_string(i), small, neo_hookean(1e4F, 0.3F));
    }
    for (Index i = 1; i < count && has_links; ++i) {
      scene.add_link({27 * (i - 1), 27 * i, 1e-3F, {}});
    }
    return scene;
  };
  for (const int count : {1, 47, 48}) {
    const Solver solver(scene_of(count, false));
    CHECK(solver.options().coarse_correction == CoarseCorrection::on);
    CHECK(testing::inspect(solver).coarse_space.piece_count() == count);
  }
  const Solver most(scene_of(49, false));
  CHECK(most.options().coarse_correction == CoarseCorrection::off);
  CHECK(most.plan().longest_substep == Solver(scene_of(1, false), plain()).plan().longest_substep);
  CHECK(Solver(scene_of(49, true)).options().coarse_correction == CoarseCorrection::on);

  const Scene many = scene_of(49, false);
  const Solver asked(many, {.coarse_correction = CoarseCorrection::on});
  CHECK(testing::inspect(asked).coarse_space.piece_count() == 48);
  CHECK(asked.plan().longest_substep ==
        Approx(std::sqrt(2) * most.plan().longest_substep).epsilon(1e-4));

  // what a cut parts into more pieces has no more nodes after a compaction
  Solver parted(scene_of(49, true));
  std::vector<Index> links;
  for (Index l = 0; l < static_cast<Index>(parted.tissue().links().size()); ++l) {
    links.push_back(l);
  }
  parted.tissue().apply({.remove_links = links});
  Compaction compaction(parted);
  compaction.build();
  compaction.finish(parted);
  CHECK(parted.plan().longest_substep ==
        Approx(std::sqrt(2) * most.plan().longest_substep).epsilon(1e-4));
}

// Would catch a default that cannot step what another method could.
TEST_CASE("substep rule: the method is the one that scene and options allow", "[unit]") {
  const auto method_of = [](const Material& material, const SolverOptions& options) {
    return Solver(make_bar(material, {3, 2, 2}), options).options().method;
  };
  const Material solid = neo_hookean(1e4F, 0.3F);
  Material springs = testing::kSprings;
  springs.stretch.compliance = 1e-3F;
  CHECK(method_of(solid, {}) == SolverMethod::vertex_block);
  CHECK(method_of(springs, {}) == SolverMethod::projection);  // volumes are rigid
  springs.volume.compliance = 1e-9F;
  CHECK(method_of(springs, {}) == SolverMethod::vertex_block);
  CHECK(method_of(solid, {.composition = PlanComposition::joint}) == SolverMethod::projection);
  CHECK(method_of(solid, {.coloring = {.max_colors = 20}}) == SolverMethod::projection);
  CHECK(method_of(springs, {.mode = ProjectionMode::fraction, .substeps = 1, .iterations = 9}) ==
        SolverMethod::projection);
  CHECK(Solver(Scene{}).options().method == SolverMethod::vertex_block);
  const SolverOptions took = Solver(make_bar(solid, {3, 2, 2})).options();
  CHECK(Solver(make_bar(solid, {3, 2, 2}), took).options().method == SolverMethod::vertex_block);
}

// Would catch substeps that are named and leave the scene softer than its material, in silence.
TEST_CASE("substep rule: sweeps make up for substeps that are too few", "[validation]") {
  SolverOptions options = GENERATE(from_range(all_automatic()));
  options.longest_step = 5e-3F;
  const Scene scene = make_bar(neo_hookean(8e4F, 0.45F), {6, 3, 3});
  const auto sag = [&] { return sag_of(scene, options, 5e-3F, 1.2F, 60); };
  const double expected = sag();
  REQUIRE(expected > 1e-5);
  for (const int substeps : {1, 3, 8, 20}) {
    if (substeps > 1 || options.method == SolverMethod::vertex_block) {
      options.substeps = substeps;
      CHECK(sag() == Approx(expected).epsilon(0.03));
    }
  }
}

TEST_CASE("substep rule: a body that an edit brings counts, until it is taken back", "[unit]") {
  const Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {4, 2, 2});
  Solver solver(scene, automatic());
  const StepPlan before = solver.plan();
  const TetMesh guest = testing::make_box({1, 1, 1}, testing::kSoftEdge);
  TopologyEdit stiff;
  stiff.new_bodies.add_body("guest", guest, neo_hookean(3.2e5F, 0.45F));
  solver.tissue().apply(stiff);
  // no mode moves it yet: as without a correction, but of two sweeps
  CHECK(solver.plan().longest_substep ==
        Approx(0.95 * std::sqrt(2) * crossing_time(testing::kSoftEdge, 3.2e5)).epsilon(0.02));
  CHECK(solver.plan().name != before.name);
  CHECK(solver.step(5e-3F).non_finite_vertices == 0);
  solver.tissue().undo();
  CHECK(solver.plan().longest_substep == before.longest_substep);
  CHECK(solver.plan().name == before.name);

  TopologyEdit rigid;
  rigid.new_bodies.add_body("rigid", guest, neo_hookean(2e10F, 0.45F));
  const std::uint64_t digest = testing::digest_of(testing::inspect(solver));
  CHECK_THROWS_WITH(solver.tissue().apply(rigid), ContainsSubstring("body 'rigid' needs substeps"));
  CHECK(testing::digest_of(testing::inspect(solver)) == digest);
}

}  // namespace pbdsurg
