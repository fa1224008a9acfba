// SPDX-License-Identifier: Apache-2.0
// Sheets that are stiffer in some places than in others, or become so.
#include <algorithm>
#include <array>
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

constexpr std::array<Index, 2> kSheetCells{8, 3};
constexpr double kSheetLength = kSheetCells[0] * kSheetEdge;

SheetMaterial material(float poissons_ratio = 0.45F) {
  return {.youngs_modulus = 50e3F, .poissons_ratio = poissons_ratio, .damping = 1e-3F};
}

// A strip along x without weight.
Scene make_strip(const SheetMaterial& sheet = material(), double jitter = 0) {
  const SheetMesh mesh = testing::make_sheet(kSheetCells, kSheetEdge, jitter);
  Scene scene;
  scene.add_sheet("strip", mesh.positions, mesh.triangles, sheet);
  scene.set_gravity({0, 0, 0});
  return scene;
}

// [triangle] those of the outer half.
std::vector<float> stiff_half_of_sheet(const Scene& scene, float factor) {
  std::vector<float> factors;
  for (const auto& [a, b, c] : scene.triangles()) {
    const auto x = scene.positions();
    factors.push_back((x[a] + x[b] + x[c]).x() / 3 > kSheetLength / 2 ? factor : 1);
  }
  return factors;
}

// [triangle] of several values.
std::vector<float> mixed(std::size_t count) {
  std::vector<float> factors;
  for (std::size_t t = 0; t < count; ++t) {
    factors.push_back(0.5F + 0.75F * static_cast<float>(t % 4));
  }
  return factors;
}

TopologyEdit sheet_stiffening(const std::vector<float>& factors) {
  TopologyEdit edit;
  for (std::size_t t = 0; t < factors.size(); ++t) {
    edit.triangle_stiffnesses.push_back({static_cast<Index>(t), factors[t]});
  }
  return edit;
}

// Of all its triangles and hinges.
void check_same_numbers(const Solver& a, const Solver& b) {
  const SolverData &one = inspect(a), &other = inspect(b);
  const auto check_near = [](const auto& left, const auto& right) {
    REQUIRE(left.has_value() == right.has_value());
    for (std::size_t i = 0; left && i < left->size(); ++i) {
      REQUIRE((*left)[i] == Approx((*right)[i]).epsilon(1e-5));
    }
  };
  for (Index t = 0; t < static_cast<Index>(a.tissue().triangles().size()); ++t) {
    check_near(one.sets.numbers_of_triangle(t), other.sets.numbers_of_triangle(t));
  }
  for (Index h = 0; h < static_cast<Index>(a.tissue().hinges().size()); ++h) {
    check_near(one.sets.numbers_of_hinge(h), other.sets.numbers_of_hinge(h));
  }
}

// Rows of vertex blocks are made of constraints, also where edits changed these.
void check_vertex_rows(const Solver& solver) {
  const SolverData& data = inspect(solver);
  if (data.options.method != SolverMethod::vertex_block) {
    return;
  }
  const VertexBlocks anew = make_vertex_blocks(
      data,
      std::vector<VertexTet>(data.vertex_blocks.tets().begin(), data.vertex_blocks.tets().end()));
  for (Index t = 0; t < static_cast<Index>(solver.tissue().triangles().size()); ++t) {
    const VertexTriangle &is = data.vertex_blocks.triangles()[t], &expected = anew.triangles()[t];
    REQUIRE(is.stiffness == expected.stiffness);
    REQUIRE(is.weights == expected.weights);
    REQUIRE(is.edge_damping == expected.edge_damping);
    REQUIRE(is.area_damping == expected.area_damping);
  }
  for (Index h = 0; h < static_cast<Index>(solver.tissue().hinges().size()); ++h) {
    REQUIRE(data.vertex_blocks.hinges()[h].stiffness == anew.hinges()[h].stiffness);
    REQUIRE(data.vertex_blocks.hinges()[h].damping == anew.hinges()[h].damping);
  }
}

}  // namespace

// Would catch moduli that a method reads from the sheet, at the start or once they change, and an
// undo that leaves some of it behind: two springs in series.
TEST_CASE("sheet stiffness: halves of a strip stretch as their moduli say", "[property]") {
  const SolverMethod method = any_sweeping_method();
  const bool from_start = GENERATE(true, false);
  SheetMaterial sheet = material(0);
  sheet.damping = 0;
  Scene scene = make_strip(sheet);
  scene.fix_where(0, [](const Eigen::Vector3d& x) {
    return x.x() < 0.5 * kSheetEdge || x.x() > kSheetLength - 0.5 * kSheetEdge;
  });
  const std::vector<float> factors = stiff_half_of_sheet(scene, 4);
  if (from_start) {
    scene.set_stiffnesses(0, factors);
  }
  Solver solver(scene, {.method = method, .damping = 20, .executor = executor::serial()});
  constexpr float kWay = 0.01F * kSheetLength;
  std::vector<Eigen::Vector3f> x = solver.positions();
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > kSheetLength - 0.5 * kSheetEdge) {
      x[v].x() += kWay;
    }
  }
  solver.write_positions(x);
  const auto check_middle = [&](double share) {
    run(solver, 300, kUsualStep);
    const auto now = solver.positions();
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      const double at = scene.positions()[v].x();
      if (std::abs(at - kSheetLength / 2) < 1e-6) {
        CHECK(now[v].x() - at == Approx(share * kWay).epsilon(0.02));
      }
    }
  };
  if (!from_start) {
    check_middle(0.5);
    solver.tissue().apply(sheet_stiffening(factors));
  }
  check_middle(0.8);
  if (!from_start) {
    solver.tissue().undo();
    check_middle(0.5);
  }
}

// Would catch a hinge that is not as stiff as its triangles, an inner friction that does not go
// along, and a substep that one of two sheets has alone.
TEST_CASE("sheet stiffness: a sheet that is four times as stiff is one of four times the modulus",
          "[equivalence]") {
  const SolverMethod method = any_sweeping_method();
  const auto moved = [&](const Scene& scene) {
    SolverOptions options{.method = method, .executor = executor::serial()};
    options.math = MathMode::strict;
    Solver solver(scene, options);
    std::vector<Eigen::Vector3f> velocities;
    for (const Eigen::Vector3f& x : solver.positions()) {
      velocities.emplace_back(x.x() * 3, 0, 20 * x.x() * x.x() + x.y());
    }
    solver.write_velocities(velocities);
    run(solver, 20, kUsualStep);
    return solver.state_hash();
  };
  SheetMaterial stiff = material();
  stiff.youngs_modulus *= 4;
  Scene scaled = make_strip();
  scaled.set_stiffnesses(0, std::vector<float>(scaled.triangles().size(), 4));
  CHECK(moved(scaled) == moved(make_strip(stiff)));
  CHECK(moved(scaled) != moved(make_strip()));
}

// Would catch a hinge between two triangles that follows one of them, the wrong two, or none.
TEST_CASE("sheet stiffness: a hinge is as stiff as both its triangles in the mean", "[unit]") {
  Scene scene = make_strip();
  const std::vector<float> factors = mixed(scene.triangles().size());
  const Solver plain(scene, small_serial_steps(SolverMethod::projection));
  scene.set_stiffnesses(0, factors);
  const Solver solver(scene, small_serial_steps(SolverMethod::projection));
  for (Index h = 0; h < static_cast<Index>(scene.hinges().size()); ++h) {
    const auto& hinge = scene.hinges()[static_cast<std::size_t>(h)].vertices;
    double sum = 0;
    for (std::size_t t = 0; t < factors.size(); ++t) {
      const auto shared = std::ranges::count_if(
          scene.triangles()[t], [&](Index v) { return std::ranges::count(hinge, v) > 0; });
      sum += shared == 3 ? factors[t] : 0;
    }
    const auto compliance = [&](const Solver& of) {
      return (*inspect(of).sets.numbers_of_hinge(h))[BendingConstraint::kStiffness];
    };
    REQUIRE(compliance(plain) / compliance(solver) == Approx(sum / 2));
  }
}

// Would catch an edit that leaves constraints, rows or substeps of a method as they were.
TEST_CASE("sheet stiffness: an edited solver is as one that is made anew", "[equivalence]") {
  const SolverMethod method = any_sweeping_method();
  Scene scene = make_strip(material(), 0.2);
  Solver edited(scene, small_serial_steps(method));
  const std::uint64_t before = digest_of(inspect(edited));
  const std::vector<float> factors = mixed(scene.triangles().size());
  edited.tissue().apply(sheet_stiffening(factors));
  CHECK(edited.tissue().triangle_stiffness(1) == factors[1]);
  check_vertex_rows(edited);
  scene.set_stiffnesses(0, factors);
  check_same_numbers(edited, Solver(scene, small_serial_steps(method)));
  check_same_numbers(edited, Solver(edited.tissue(), small_serial_steps(method)));
  CHECK(digest_of(inspect(edited)) != before);
  edited.tissue().undo();
  CHECK(edited.tissue().triangle_stiffness(1) == 1);
  CHECK(digest_of(inspect(edited)) == before);
}

// Would catch factors that get lost, or get to others, where triangles part, go, come or are
// compacted.
TEST_CASE("sheet stiffness: goes along with triangles", "[unit]") {
  const SolverMethod method = any_sweeping_method();
  Scene scene = make_strip(material(), 0.2), guests = make_strip(material());
  const std::vector<float> factors = mixed(scene.triangles().size());
  scene.set_stiffnesses(0, factors);
  Scene both;
  both.append(scene);
  CHECK(std::ranges::equal(both.triangle_stiffnesses(), factors));
  Solver solver(both, small_serial_steps(method));

  // in one edit: it parts, and what moves and what goes is to be stiffer
  TopologyEdit rip = testing::rip_vertex(solver, 12);
  REQUIRE(!rip.triangle_moves.empty());
  const Index moved = rip.triangle_moves[0].triangle;
  const Index gone = moved > 20 ? 0 : 40;
  rip.remove_triangles = {gone};
  rip.triangle_stiffnesses = {{moved, 7}, {gone, 3}};
  solver.tissue().apply(rip);
  CHECK(solver.tissue().triangle_stiffness(moved) == 7);
  check_vertex_rows(solver);
  check_same_numbers(solver, Solver(solver.tissue(), small_serial_steps(method)));

  // a body that comes
  TopologyEdit coming;
  Scene guest;
  const SheetMesh disc = testing::make_disc(2, 2 * kSheetEdge);
  guest.add_sheet("guest", disc.positions, disc.triangles, material());
  const std::vector<float> of_guest = mixed(disc.triangles.size());
  guest.set_stiffnesses(0, of_guest);
  coming.new_bodies = guest;
  const auto first = static_cast<Index>(solver.tissue().triangles().size());
  solver.tissue().apply(coming);
  for (std::size_t t = 0; t < of_guest.size(); ++t) {
    REQUIRE(solver.tissue().triangle_stiffness(first + static_cast<Index>(t)) == of_guest[t]);
  }
  check_vertex_rows(solver);
  check_same_numbers(solver, Solver(solver.tissue(), small_serial_steps(method)));

  std::vector<float> known;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().triangles().size()); ++t) {
    known.push_back(solver.tissue().triangle_stiffness(t));
  }
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  for (std::size_t t = 0; t < known.size(); ++t) {
    if (ids.triangles[t] != kInvalidIndex) {
      REQUIRE(solver.tissue().triangle_stiffness(ids.triangles[t]) == known[t]);
    }
  }
  CHECK(ids.triangles[static_cast<std::size_t>(gone)] == kInvalidIndex);
  check_same_numbers(solver, Solver(solver.tissue(), small_serial_steps(method)));
}

// Would catch a solver that steps a stiff sheet with the substeps of a soft one.
TEST_CASE("sheet stiffness: automatic substeps follow it", "[unit]") {
  Scene scene = make_strip();
  Solver solver(scene, {.executor = executor::serial()});
  const float soft = solver.plan().longest_substep;
  std::vector<float> factors(scene.triangles().size(), 1);
  factors[5] = 25;
  solver.tissue().apply(sheet_stiffening(factors));
  CHECK(solver.plan().longest_substep == Approx(soft / 5));
  solver.tissue().undo();
  CHECK(solver.plan().longest_substep == soft);
  scene.set_stiffnesses(0, factors);
  CHECK(Solver(scene, {.executor = executor::serial()}).plan().longest_substep == Approx(soft / 5));
  Solver other(Scene(), {.executor = executor::serial()});
  TopologyEdit edit;
  edit.new_bodies = scene;
  other.tissue().apply(edit);
  CHECK(other.plan().longest_substep == Approx(soft / 5));
}

// Would catch a stiffness that nothing has, and one that is taken in silence.
TEST_CASE("sheet stiffness: says what it refuses, and changes nothing", "[unit]") {
  Scene scene = make_strip();
  const std::size_t count = scene.triangles().size();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto refuse = [&](const std::vector<float>& factors, const char* what) {
    check_refused([&] { scene.set_stiffnesses(0, factors); }, what);
    CHECK(std::ranges::all_of(scene.triangle_stiffnesses(), [](float f) { return f == 1; }));
  };
  refuse({2, 2}, "body 'strip' has 48 triangles and got 2 stiffnesses; it needs one each");
  std::vector<float> bad(count, 2);
  bad[7] = 0;
  refuse(bad, "body 'strip': triangle 7 is to be 0 times as stiff");
  bad[7] = nan;
  refuse(bad, "triangle 7 is to be nan times");

  Solver solver(scene, small_serial_steps(SolverMethod::projection));
  const auto refuse_edit = [&](const TopologyEdit& edit, const char* what) {
    const std::uint64_t version = solver.tissue().version();
    check_refused([&] { solver.tissue().apply(edit); }, what);
    CHECK(solver.tissue().version() == version);
  };
  refuse_edit({.triangle_stiffnesses = {{3, 1001}}}, "triangle 3 is to be 1001 times as stiff");
  refuse_edit({.triangle_stiffnesses = {{3, 5e-4F}}}, "it must be in [0.001, 1000]");
  refuse_edit({.triangle_stiffnesses = {{3, 2}, {3, 3}}}, "triangle 3 is listed twice");
  refuse_edit({.triangle_stiffnesses = {{-1, 2}}}, "triangle -1 does not exist");
  check_refused([&] { (void)solver.tissue().triangle_stiffness(48); }, "there is no triangle 48");
  solver.tissue().apply({.remove_triangles = {3}});
  refuse_edit({.triangle_stiffnesses = {{3, 2}}}, "triangle 3 was removed before");
  Solver fine(make_strip(), {.longest_step = 0.1F, .executor = executor::serial()});
  check_refused(
      [&] {
        fine.tissue().apply({.triangle_stiffnesses = {{3, 1000}}});
      },
      "body 'strip' needs");
}

}  // namespace pbdsurg
