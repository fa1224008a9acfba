// SPDX-License-Identifier: Apache-2.0
// Sheets whose triangles get another rest area.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/vertex_method.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/cuts.h"
#include "tests/support/inspect.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/solver_digest.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::any_sweeping_method;
using testing::Approx;
using testing::check_refused;
using testing::digest_of;
using testing::inspect;
using testing::kSheetEdge;
using testing::kUsualStep;
using testing::run;
using testing::SheetMesh;
using testing::small_serial_steps;

// A square without weight, and without a place where it must be.
Scene make_square(double scale = 1) {
  const SheetMesh mesh = testing::make_sheet({6, 6}, scale * kSheetEdge, 0.2);
  Scene scene;
  scene.add_sheet("square", mesh.positions, mesh.triangles,
                  {.youngs_modulus = 50e3F, .damping = 1e-4F});
  scene.set_gravity({0, 0, 0});
  return scene;
}

// All triangles, to a share of their area.
TopologyEdit shrinking(const Solver& solver, float share) {
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().triangles().size()); ++t) {
    edit.rest_areas.push_back({t, share * solver.rest_area(t)});
  }
  return edit;
}

double area_of(const Solver& solver) {
  const auto x = solver.positions();
  double area = 0;
  for (const auto& [a, b, c] : solver.tissue().triangles()) {
    area += (x[b] - x[a]).cross(x[c] - x[a]).cast<double>().norm() / 2;
  }
  return area;
}

}  // namespace

// Would catch a shape that shrinks by another share or along one axis alone, rows that do not
// follow, and an undo that leaves some of it behind.
TEST_CASE("sheet rest area: a sheet comes to rest with the area that it has at rest",
          "[property]") {
  const SolverMethod method = any_sweeping_method();
  const Scene scene = make_square();
  Solver solver(scene, {.method = method, .damping = 20, .executor = executor::serial()});
  const double whole = area_of(solver);
  CHECK(whole == Approx(36 * kSheetEdge * kSheetEdge));
  const auto side = [&] {
    const auto x = solver.positions();
    return double{(x.back() - x.front()).norm()} / std::sqrt(2);
  };
  solver.tissue().apply(shrinking(solver, 0.64F));
  run(solver, 200, kUsualStep);
  CHECK(area_of(solver) == Approx(0.64 * whole).epsilon(0.002));
  CHECK(side() == Approx(0.8 * 6 * kSheetEdge).epsilon(0.001));
  solver.tissue().undo();
  run(solver, 200, kUsualStep);
  CHECK(area_of(solver) == Approx(whole).epsilon(0.002));
  CHECK(side() == Approx(6 * kSheetEdge).epsilon(0.001));
}

// Would catch a patch that pulls at the sheet around it by another strain than its own: a disc in a
// ring that is held. Of the same plane-stress tissue, the disc of radius a in a ring up to b, which
// would be shorter by a share e without it, is left with a radial displacement -u(a) of
// e a (1 + nu) / 2 (1 - (a/b)^2): Timoshenko and Goodier 1951, "Theory of Elasticity", section 28.
TEST_CASE("sheet rest area: a patch that shrinks draws in what is around it", "[property]") {
  const SolverMethod method = any_sweeping_method();
  constexpr Index kRings = 16, kInner = 8;
  constexpr double kRadius = 16 * 1.5e-3, kShare = 0.01;  // m, of lengths
  const SheetMesh mesh = testing::make_disc(kRings, kRadius);
  const SheetMaterial material{.thickness = 1e-3F, .youngs_modulus = 50e3F, .poissons_ratio = 0.3F};
  Scene scene;
  scene.add_sheet("disc", mesh.positions, mesh.triangles, material);
  scene.set_gravity({0, 0, 0});
  scene.fix_where(0,
                  [](const Eigen::Vector3d& x) { return x.norm() > kRadius * (1 - 0.5 / kRings); });
  Solver solver(scene, {.method = method, .damping = 20, .executor = executor::serial()});
  const double inner = kRadius * kInner / kRings;
  TopologyEdit edit;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const Eigen::Vector3d center = (mesh.positions[a] + mesh.positions[b] + mesh.positions[c]) / 3;
    if (center.norm() < inner) {
      const auto id = static_cast<Index>(t);
      edit.rest_areas.push_back(
          {id, static_cast<float>((1 - kShare) * (1 - kShare) * solver.rest_area(id))});
    }
  }
  solver.tissue().apply(edit);
  run(solver, 400, kUsualStep);
  const auto x = solver.positions();
  double sum = 0;
  int count = 0;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    const double radius = mesh.positions[v].norm();
    if (std::abs(radius - inner) < 1e-6) {
      sum += radius - x[v].cast<double>().norm();
      ++count;
    }
  }
  REQUIRE(count == 6 * kInner);
  const double ratio = material.poissons_ratio;
  const double expected =
      kShare * inner * (1 + ratio) / 2 * (1 - std::pow(double{kInner} / kRings, 2));
  CHECK(sum / count == Approx(expected).epsilon(0.01));
}

// Would catch moduli, friction or hinges that are not those of a sheet that was made so small.
TEST_CASE("sheet rest area: a shrunk sheet is as one that was made as small", "[equivalence]") {
  const SolverMethod method = any_sweeping_method();
  Solver shrunk(make_square(), small_serial_steps(method));
  const Solver small(make_square(0.8), small_serial_steps(method));
  const std::uint64_t before = digest_of(inspect(shrunk));
  shrunk.tissue().apply(shrinking(shrunk, 0.64F));
  CHECK(shrunk.rest_area(5) == Approx(small.rest_area(5)));
  const SolverData &one = inspect(shrunk), &other = inspect(small);
  const auto check_near = [](const auto& left, const auto& right) {
    const float size =
        std::abs(*std::ranges::max_element(right, {}, [](float value) { return std::abs(value); }));
    for (std::size_t i = 0; i < right.size(); ++i) {
      REQUIRE(left[i] == Approx(right[i]).epsilon(1e-4).margin(1e-5 * size));
    }
  };
  for (Index t = 0; t < 72; ++t) {
    check_near(*one.sets.numbers_of_triangle(t), *other.sets.numbers_of_triangle(t));
  }
  for (Index h = 0; h < static_cast<Index>(shrunk.tissue().hinges().size()); ++h) {
    check_near(*one.sets.numbers_of_hinge(h), *other.sets.numbers_of_hinge(h));
  }
  for (Index t = 0; t < 72 && method == SolverMethod::vertex_block; ++t) {
    const VertexTriangle &is = one.vertex_blocks.triangles()[t],
                         &expected = other.vertex_blocks.triangles()[t];
    REQUIRE(is.stiffness == Approx(expected.stiffness).epsilon(1e-4));
    REQUIRE(is.target == Approx(expected.target).epsilon(1e-4));
    check_near(is.weights, expected.weights);
    check_near(is.edge_damping, expected.edge_damping);
  }
  shrunk.tissue().undo();
  CHECK(digest_of(inspect(shrunk)) == before);
}

// Would catch areas that get lost, or get to others, where triangles stiffen, part, go or are
// compacted.
TEST_CASE("sheet rest area: goes along with triangles", "[unit]") {
  const SolverMethod method = any_sweeping_method();
  Solver solver(make_square(), small_serial_steps(method));
  TopologyEdit edit = testing::rip_vertex(solver, 16);
  REQUIRE(!edit.triangle_moves.empty());
  const Index moved = edit.triangle_moves[0].triangle;
  const Index gone = moved > 30 ? 0 : 60;
  const float area = 0.5F * solver.rest_area(moved), at_first = solver.rest_area(gone);
  edit.remove_triangles = {gone};
  edit.rest_areas = {{moved, area}, {gone, at_first / 2}};
  edit.triangle_stiffnesses = {{moved, 3}};
  const std::uint64_t before = digest_of(inspect(solver));
  solver.tissue().apply(edit);
  CHECK(solver.rest_area(moved) == Approx(area));
  check_refused([&] { (void)solver.rest_area(gone); }, "was removed");
  const auto stiffness = [&](Index t) {
    return (*inspect(solver).sets.numbers_of_triangle(t))[MembraneConstraint::kStiffness];
  };
  // mu t A
  const double expected = 3 * 50e3 / (2 * 1.45) * SheetMaterial{}.thickness * area;
  CHECK(stiffness(moved) == Approx(expected).epsilon(1e-4));
  solver.tissue().undo();
  CHECK(digest_of(inspect(solver)) == before);
  CHECK(solver.rest_area(gone) == at_first);
  solver.tissue().apply(edit);
  run(solver, 4, kUsualStep);
  const auto numbers = inspect(solver).sets.numbers_of_triangle(moved);
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  CHECK(inspect(solver).sets.numbers_of_triangle(ids.triangles[static_cast<std::size_t>(moved)]) ==
        numbers);
  REQUIRE(testing::run(solver, 4, kUsualStep).non_finite_vertices == 0);
}

// Would catch hinges that stay pulls where a sheet gets too thick for its triangles, and are then
// stiffer than they should be; or that stay angles, at five times the cost.
TEST_CASE("sheet rest area: hinges are pulls where the sheet is thin", "[unit]") {
  const auto made = [](float thickness) {
    const SheetMesh mesh = testing::make_sheet({6, 6}, kSheetEdge, 0.2);
    Scene scene;
    scene.add_sheet("square", mesh.positions, mesh.triangles, {.thickness = thickness});
    return Solver(scene, small_serial_steps(SolverMethod::vertex_block));
  };
  const auto with_angle = [](const Solver& solver) {
    return std::ranges::count_if(inspect(solver).vertex_blocks.hinges(),
                                 [](const VertexHinge& hinge) { return hinge.stiffness > 0; });
  };
  Solver thin = made(0.1F * static_cast<float>(kSheetEdge));
  const auto all = static_cast<std::ptrdiff_t>(thin.tissue().hinges().size());
  CHECK(with_angle(thin) == 0);
  CHECK(with_angle(made(static_cast<float>(kSheetEdge))) == all);
  thin.tissue().apply(shrinking(thin, 0.03F));
  CHECK(with_angle(thin) == all);
  thin.tissue().undo();
  CHECK(with_angle(thin) == 0);
}

// Would catch an area that nothing can have, and one that is taken in silence.
TEST_CASE("sheet rest area: says what it refuses, and changes nothing", "[unit]") {
  Solver solver(make_square(), small_serial_steps(SolverMethod::projection));
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinite = std::numeric_limits<float>::infinity();
  const auto refuse = [&](const TopologyEdit& edit, const char* what) {
    const std::uint64_t version = solver.tissue().version();
    check_refused([&] { solver.tissue().apply(edit); }, what);
    CHECK(solver.tissue().version() == version);
  };
  refuse({.rest_areas = {{3, 0}}},
         "triangle 3: the new rest area is 0.000000; it must be positive");
  refuse({.rest_areas = {{3, -1e-6F}}}, "it must be positive and finite");
  refuse({.rest_areas = {{3, nan}}}, "triangle 3: the new rest area is nan");
  refuse({.rest_areas = {{3, infinite}}}, "triangle 3: the new rest area is inf");
  refuse({.rest_areas = {{3, 1e-6F}, {3, 1e-6F}}}, "triangle 3 is listed twice");
  refuse({.rest_areas = {{72, 1e-6F}}}, "triangle 72 does not exist");
  check_refused([&] { (void)solver.rest_area(72); }, "there is no triangle 72");
  solver.tissue().apply({.remove_triangles = {3}});
  refuse({.rest_areas = {{3, 1e-6F}}}, "triangle 3 was removed before");
}

}  // namespace pbdsurg
