// SPDX-License-Identifier: Apache-2.0
// Tissue with fibres: against closed forms and static solutions, through edits, and what is
// refused.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/solver/tet_stress.h"
#include "pbdsurg/tissue/tissue.h"

#include "bench/support/neo_hookean.h"
#include "bench/support/static_energy.h"
#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/fibre_program.h"
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
using testing::Recipe;
using testing::run;

constexpr std::array<Index, 3> kFibreCells{6, 2, 2};
constexpr double kFibreLength = kFibreCells[0] * kSoftEdge;
constexpr double kFibreModulus = 20e3;  // Pa, of fibres; of the matrix half of that
const Eigen::Vector3f kAlong(1, 0, 0), kAcross(0, 1, 0);

Material matrix() {
  return testing::neo_hookean(10e3F, 0.4F);
}

// A strip along x that nothing holds or weighs down.
Scene make_fibre_strip(const Eigen::Vector3f& direction, double stiffness) {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_body("strip", testing::make_box(kFibreCells, kSoftEdge), matrix());
  scene.set_fibres(
      0, std::vector<Fibre>(scene.tets().size(), {direction, static_cast<float>(stiffness)}));
  return scene;
}

// N, of a traction on both ends: a third of each triangle's at its corners, so that an even stretch
// balances it.
// @param stress  Pa
std::vector<Eigen::Vector3f> ends_pulled(const Scene& scene, double stress) {
  std::vector<Eigen::Vector3d> forces(scene.positions().size(), Eigen::Vector3d::Zero());
  const auto& x = scene.positions();
  for (const Tet& tet : scene.tets()) {
    for (const auto& [a, b, c] : kTetTriangles) {
      const std::array<Index, 3> face{tet[a], tet[b], tet[c]};
      for (const double end : {0.0, kFibreLength}) {
        if (std::ranges::all_of(face, [&](Index v) { return std::abs(x[v].x() - end) < 1e-9; })) {
          const double area = (x[face[1]] - x[face[0]]).cross(x[face[2]] - x[face[0]]).norm() / 2;
          for (const Index v : face) {
            forces[v].x() += (end > 0 ? 1 : -1) * stress * area / 3;
          }
        }
      }
    }
  }
  std::vector<Eigen::Vector3f> loads;
  std::ranges::transform(forces, std::back_inserter(loads),
                         [](const Eigen::Vector3d& f) { return f.cast<float>(); });
  return loads;
}

std::vector<Index> all_vertices(const Scene& scene) {
  std::vector<Index> vertices;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    vertices.push_back(v);
  }
  return vertices;
}

Recipe any_fibre_recipe() {
  return GENERATE(
      Recipe{"default", {.damping = 30}},
      Recipe{"vertex blocks",
             {.method = SolverMethod::vertex_block, .iterations = 30, .damping = 30}},
      Recipe{"projections", {.method = SolverMethod::projection, .iterations = 10, .damping = 30}},
      Recipe{"projections, serial",
             {.method = SolverMethod::projection,
              .iterations = 10,
              .damping = 30,
              .executor = executor::serial()}},
      Recipe{"explicit", {.method = SolverMethod::explicit_steps, .damping = 30}});
}

// The stretch of a strip along x at rest under a traction on its ends.
double stretch_of(const Scene& scene, const SolverOptions& options, double stress) {
  Solver solver(scene, options);
  solver.set_forces(all_vertices(scene), ends_pulled(scene, stress));
  run(solver, 400, 2e-3F);
  double first = 0, last = 0;
  int ends = 0;
  const auto x = solver.positions();
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() < 1e-9) {
      first += x[v].x();
      ++ends;
    } else if (scene.positions()[v].x() > kFibreLength - 1e-9) {
      last += x[v].x();
    }
  }
  return (last - first) / (ends * kFibreLength);
}

// A bar of oblique fibres that is held at its start and sags.
constexpr float kStiff = 100e3F;  // Pa
Scene make_oblique_bar() {
  Scene scene = testing::make_bar(matrix(), kFibreCells);
  scene.set_fibres(0, std::vector<Fibre>(scene.tets().size(),
                                         {Eigen::Vector3f(2, 1, 0.5F).normalized(), kStiff}));
  return scene;
}

float farthest_between(const std::vector<Eigen::Vector3f>& a,
                       const std::vector<Eigen::Vector3f>& b) {
  float largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    largest = std::max(largest, (a[v] - b[v]).norm());
  }
  return largest;
}

// Where a short block rests whose fibres run from the face that is held to the one that is pulled.
// @param pull  N
std::vector<Eigen::Vector3f> block_under(const SolverOptions& options, float stiffness,
                                         float pull) {
  constexpr std::array<Index, 3> cells{2, 3, 3};
  Scene scene = testing::make_bar(matrix(), cells);
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.set_fibres(0, std::vector<Fibre>(scene.tets().size(), {kAlong, stiffness}));
  std::vector<Index> face;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > (cells[0] - 0.5) * kSoftEdge) {
      face.push_back(v);
    }
  }
  Solver solver(scene, options);
  const Eigen::Vector3f share(pull / static_cast<float>(face.size()), 0, 0);
  solver.set_forces(face, std::vector<Eigen::Vector3f>(face.size(), share));
  run(solver, 300, 2e-3F);
  return solver.positions();
}

SolverOptions strict(SolverMethod method, const Executor& executor) {
  return {.method = method,
          .substeps = 3,
          .iterations = 2,
          .executor = executor,
          .math = MathMode::strict,
          .composition = PlanComposition::separate};
}

}  // namespace

// Would catch fibres of a wrong stiffness, of a wrong measure of length or of a wrong volume, in
// each method.
TEST_CASE("fibres: a strip pulled along them stretches as its closed form", "[property]") {
  const Recipe recipe = any_fibre_recipe();
  INFO(recipe.name);
  const bench::NeoHookeanModuli moduli(matrix());
  const double stress = bench::uniaxial_stress(moduli, kFibreModulus, 1.25);
  const double stretch =
      stretch_of(make_fibre_strip(kAlong, kFibreModulus), recipe.options, stress);
  CHECK(stretch - 1 == Approx(0.25).epsilon(0.01));
  // fibres count: without, it would be twice as long
  CHECK(bench::uniaxial_stretch(moduli, 0, stress) > 1.5);
}

// Would catch fibres that push, and fibres that resist what does not lengthen them.
TEST_CASE("fibres: tissue pulled across or pushed along them is as without", "[property]") {
  const Recipe recipe = any_fibre_recipe();
  INFO(recipe.name);
  const double pull = bench::uniaxial_stress(bench::NeoHookeanModuli(matrix()), 0, 1.25);
  CHECK(stretch_of(make_fibre_strip(kAcross, kFibreModulus), recipe.options, pull) - 1 ==
        Approx(0.25).epsilon(0.01));
  constexpr float kForce = 0.1F;  // N, which shortens the block by 7 %
  const auto rest = block_under(recipe.options, kStiff, 0);
  const auto pushed = block_under(recipe.options, 0, -kForce);
  const float way = farthest_between(pushed, rest);
  CHECK(farthest_between(block_under(recipe.options, kStiff, -kForce), pushed) < 0.02F * way);
  CHECK(farthest_between(block_under(recipe.options, kStiff, kForce), rest) < 0.5F * way);
}

// Would catch directions that are taken in the wrong frame, and what couples stretch and shear.
TEST_CASE("fibres: a bar with oblique ones rests where a static solution has it", "[property]") {
  const Recipe recipe = any_fibre_recipe();
  INFO(recipe.name);
  Scene scene = make_oblique_bar();
  scene.set_gravity({0, -30, 0});
  const bench::StaticEnergy energy(scene);
  const bench::Positions at_rest(scene.positions().begin(), scene.positions().end());
  const bench::Positions expected = bench::find_equilibrium(energy, at_rest);
  Solver solver(scene, recipe.options);
  run(solver, 800, 2e-3F);
  const double way = largest_distance(at_rest, solver.positions());
  CHECK(largest_distance(expected, solver.positions()) < 0.02 * way);
  Scene plain = scene;
  plain.set_fibres(0, std::vector<Fibre>(scene.tets().size()));
  const bench::Positions without = bench::find_equilibrium(bench::StaticEnergy(plain), at_rest);
  CHECK(largest_distance(without, solver.positions()) > 0.1 * way);
}

// Would catch the term left out, or of the area at rest; and forces that are none of a convergence.
TEST_CASE("fibres: stress of an even stretch has its closed form", "[unit]") {
  Scene scene = make_fibre_strip(Eigen::Vector3f(1, 2, -2) / 3, kFibreModulus);
  Scene plain = scene;
  plain.set_fibres(0, std::vector<Fibre>(scene.tets().size()));
  Eigen::Matrix3d stretch;
  stretch << 1.3, 0.2, 0, 0, 0.9, 0.1, -0.1, 0, 1.1;
  std::vector<Eigen::Vector3f> x;
  for (const Eigen::Vector3d& at : scene.positions()) {
    x.push_back((stretch * at).cast<float>());
  }
  Solver solver(scene, testing::small_steps()), without(plain, testing::small_steps());
  solver.write_positions(x);
  without.write_positions(x);
  const Eigen::Vector3d along = stretch * Eigen::Vector3d(1, 2, -2) / 3;
  REQUIRE(along.norm() > 1);
  const Eigen::Matrix3d expected =
      kFibreModulus * (1 - 1 / along.norm()) / stretch.determinant() * along * along.transpose();
  const std::array<Index, 2> tets{3, 17};
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Matrix3d found =
        (tet_stresses(solver, tets)[i].stress - tet_stresses(without, tets)[i].stress)
            .cast<double>();
    CHECK((found - expected).norm() < 1e-3 * expected.norm());
  }
}

// Would catch a residual without fibres: it would not become small.
TEST_CASE("fibres: convergence counts their forces", "[unit]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = make_oblique_bar();
  Solver solver(scene, {.method = method, .substeps = 1, .iterations = 200, .damping = 30});
  run(solver, 30, 2e-3F);
  const Convergence found = solver.convergence(2e-3F)[0];
  REQUIRE(found.elastic > 0);
  CHECK(found.residual < 0.05 * found.elastic);
}

// Would catch lanes or threads that take fibres in another order, or a row that one of them lacks.
TEST_CASE("fibres: threads have the serial bits in strict mode", "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = make_oblique_bar();
  Solver serial(scene, strict(method, executor::serial()));
  Solver threads(scene, strict(method, executor::threads(3)));
  run(serial, 20);
  run(threads, 20);
  CHECK(serial.state_hash() == threads.state_hash());
}

// Would catch an edit or an undo that a backend that keeps the state hears too little of.
TEST_CASE("fibres: a device has the serial bits, through edits and undo", "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = testing::make_fibred_scene(GENERATE(0.0F, 1e-3F));
  SolverOptions options = strict(method, executor::serial());
  options.copies = 2;
  Solver serial(scene, options);
  options.executor = testing::fake_device();
  Solver device(scene, options);
  Index contacts = 0;
  for (Solver* const solver : {&serial, &device}) {
    testing::FibreProgram::begin(*solver, scene);
  }
  for (Index round = 0; round < 32; ++round) {
    INFO("round " << round);
    testing::FibreProgram::act(serial, round);
    testing::FibreProgram::act(device, round);
    const StepReport report = serial.step(testing::FibreProgram::kStep);
    device.step(testing::FibreProgram::kStep);
    contacts += report.contacts;
    REQUIRE(report.non_finite_vertices == 0);
    REQUIRE(device.state_hash(0) == serial.state_hash(0));
    REQUIRE(device.state_hash(1) == serial.state_hash(1));
  }
  CHECK(contacts > 0);
}

// Would catch fibres that a change of stiffness, of rest volume or of fibres leaves as they were,
// an undo that does, and one that comes where there was none: against a solver that has them from
// the start.
TEST_CASE("fibres: edits bring, change and take them, and undo does it back", "[property]") {
  const Recipe recipe = any_fibre_recipe();
  INFO(recipe.name);
  const Scene with = make_oblique_bar();
  Scene without = with;
  without.set_fibres(0, std::vector<Fibre>(with.tets().size()));
  TopologyEdit bring, take;
  for (std::size_t t = 0; t < with.tets().size(); ++t) {
    bring.fibres.push_back({static_cast<Index>(t), with.fibres()[t]});
    take.fibres.push_back({static_cast<Index>(t), {}});
  }
  const auto rest_of = [&](const Scene& scene) {
    Solver solver(scene, recipe.options);
    run(solver, 400, 2e-3F);
    return solver.positions();
  };
  const auto taut = rest_of(with), slack = rest_of(without);
  const float apart = farthest_between(taut, slack);
  REQUIRE(apart > 1e-4F);

  Solver solver(without, recipe.options);
  run(solver, 10, 2e-3F);
  const std::uint64_t before = solver.state_hash();
  solver.tissue().apply(bring);
  CHECK(solver.tissue().fibre(5).stiffness == kStiff);
  solver.tissue().undo();
  CHECK(solver.tissue().fibre(5).stiffness == 0);
  CHECK(solver.state_hash() == before);
  solver.tissue().apply(bring);
  run(solver, 400, 2e-3F);
  CHECK(farthest_between(solver.positions(), taut) < 0.03F * apart);
  solver.tissue().apply(take);
  run(solver, 400, 2e-3F);
  CHECK(farthest_between(solver.positions(), slack) < 0.03F * apart);
}

// Would catch fibres of parts that are longer or stiffer than those of the whole, and a compaction
// that loses some: an even stretch has the same stress whatever tissue is divided into.
TEST_CASE("fibres: parts of a tetrahedron and compacted tissue have them", "[property]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Scene scene = make_oblique_bar();
  Solver solver(scene, {.method = method, .substeps = 2, .iterations = 2});
  const Tet parent = solver.tissue().tets()[7];
  const Index added = solver.vertex_count();
  TopologyEdit split;
  split.new_vertices = {{parent[0], parent[1], 0.3F}};
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {  // all around the edge
    const Tet tet = solver.tissue().tets()[t];
    const auto has = [&](Index v) { return std::ranges::count(tet, v) > 0; };
    if (has(parent[0]) && has(parent[1])) {
      for (const Index gone : {parent[0], parent[1]}) {
        Tet part = tet;
        *std::ranges::find(part, gone) = added;
        split.new_tets.push_back({t, part});
      }
    }
  }
  solver.tissue().apply(split);
  const Index first = static_cast<Index>(scene.tets().size());
  CHECK(solver.tissue().fibre(first).stiffness == kStiff);
  CHECK(solver.tissue().fibre(first).direction == scene.fibres()[7].direction);
  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  std::vector<Eigen::Vector3f> x;
  Eigen::Matrix3d stretch;
  stretch << 1.3, 0.2, 0, 0, 0.9, 0.1, -0.1, 0, 1.1;
  for (const Eigen::Vector3d& at : solver.tissue().rest_positions()) {
    x.push_back((stretch * at).cast<float>());
  }
  solver.write_positions(x);
  // all forces of an even stretch balance at vertices within, so one short substep moves none
  const auto count = static_cast<Index>(solver.tissue().tets().size());
  for (Index t = 0; t < count; ++t) {
    CHECK(solver.tissue().fibre(t).stiffness == kStiff);
  }
  solver.set_gravity(Eigen::Vector3f::Zero());
  solver.step(1e-4F);
  const auto moved = solver.positions();
  const Eigen::AlignedBox3d box = bounding_box(testing::make_box(kFibreCells, kSoftEdge, 0.1));
  float within = 0, without = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    const Eigen::Vector3d& at = solver.tissue().rest_positions()[v];
    const double depth = std::min((at - box.min()).minCoeff(), (box.max() - at).minCoeff());
    (depth > 0.5 * kSoftEdge ? within : without) =
        std::max(depth > 0.5 * kSoftEdge ? within : without, (moved[v] - x[v]).norm());
  }
  REQUIRE(without > 0);
  CHECK(within < 0.2F * without);
}

// Would catch a solver that steps stiff fibres with the substeps of their matrix.
TEST_CASE("fibres: automatic substeps follow them", "[unit]") {
  SolverOptions options;
  options.coarse_correction = CoarseCorrection::off;
  options.iterations = 1;
  const double wave = 10e3 * 0.6 / (1.4 * 0.2);  // Pa, of pressure in the matrix
  Scene scene = make_fibre_strip(kAlong, 0);
  Solver solver(scene, options);
  const int soft = solver.step(5e-3F).substeps;
  solver.tissue().apply({.fibres = {{5, {kAlong, static_cast<float>(24 * wave)}}}});
  const int stiff = solver.step(5e-3F).substeps;
  CHECK(stiff >= 4 * soft);
  CHECK(stiff <= 6 * soft);
  solver.tissue().undo();
  CHECK(solver.step(5e-3F).substeps == soft);
  Solver at_start(make_fibre_strip(kAlong, 24 * wave), options);
  CHECK(std::abs(at_start.step(5e-3F).substeps - stiff) <= 1);
}

// Would catch fibres that nothing has, and some that are taken in silence.
TEST_CASE("fibres: says what it refuses, and changes nothing", "[unit]") {
  Scene scene = make_fibre_strip(kAlong, 0);
  scene.add_body("springs", testing::make_box({1, 1, 1}, kSoftEdge), testing::kSprings);
  const auto count = static_cast<std::size_t>(scene.body(0).tet_count);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuse = [&](Index body, const std::vector<Fibre>& fibres, const char* what) {
    CHECK_THROWS_WITH(scene.set_fibres(body, fibres), ContainsSubstring(what));
    CHECK(std::ranges::all_of(scene.fibres(), [](const Fibre& f) { return f.stiffness == 0; }));
  };
  refuse(1, std::vector<Fibre>(6), "body 'springs' cannot have fibres: only Neo-Hookean");
  refuse(2, {}, "there is no body 2");
  refuse(0, {Fibre{}}, "and got 1 fibres");
  std::vector<Fibre> bad(count, {kAlong, 1});
  bad[7].direction = {1, 1, 0};
  refuse(0, bad, "body 'strip': tet 7: the direction of its fibres has length 1.41");
  bad[7].direction = {nan, 0, 0};
  refuse(0, bad, "tet 7: the direction of its fibres has length nan");
  bad[7] = {kAlong, -1};
  refuse(0, bad, "tet 7: the stiffness of its fibres is -1 Pa");
  bad[7].stiffness = std::numeric_limits<float>::infinity();
  refuse(0, bad, "tet 7: the stiffness of its fibres is inf Pa");

  Solver solver(scene, testing::small_steps());
  const auto refuse_edit = [&](const TopologyEdit& edit, const char* what) {
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(what));
    CHECK(solver.tissue().version() == 0);
  };
  refuse_edit({.fibres = {{3, {kAlong, nan}}}}, "tet 3: the stiffness of its fibres is nan");
  refuse_edit({.fibres = {{3, {{0, 0, 0}, 1}}}}, "tet 3: the direction of its fibres has length 0");
  refuse_edit({.fibres = {{3, {}}, {3, {}}}}, "tet 3 is listed twice");
  refuse_edit({.fibres = {{-1, {}}}}, "tet -1 does not exist");
  refuse_edit({.fibres = {{scene.body(1).first_tet, {}}}}, "body 'springs' cannot have fibres");
  CHECK_THROWS_WITH(static_cast<void>(solver.tissue().fibre(10'000)),
                    ContainsSubstring("tet 10000"));
}

}  // namespace pbdsurg
