// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/potential_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/library.h"

#include "lib/base/shared_work.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"
#include "tests/support/scenes.h"

namespace pbdsurg {
namespace {

using std::numbers::pi;
using testing::Approx;
using testing::ContainsSubstring;

constexpr double kSigma = 0.3;  // S/m
constexpr double kEdge = 1e-3;  // m

// A block whose upper face an electrode touches.
struct Block {
  explicit Block(std::array<Index, 3> cells, double jitter = 0,
                 const PotentialOptions& options = {})
      : shape(testing::make_box(cells, kEdge, jitter)),
        tissue(testing::scene_of(shape)),
        mesh(tissue, std::array{ThermalBody{0, tissues::liver().heat}}),
        conductivities(shape.tets().size(), kSigma),
        field(mesh, options),
        top(cells[2] * kEdge),
        centre(cells[0] / 2 * kEdge, cells[1] / 2 * kEdge, top) {}

  // Vertices of the upper face within a radius of a point of it.
  [[nodiscard]] std::vector<PatchVertex> disk(const Eigen::Vector3d& middle, double radius) const {
    return testing::patch_where(mesh, [&](const Eigen::Vector3d& x) {
      return x.z() > top - 0.3 * kEdge && (x - middle).norm() < radius;
    });
  }

  void remove(const std::vector<Index>& tets) { tissue.apply({.remove_tets = tets}); }

  [[nodiscard]] std::vector<Index> tets_where(const testing::Where& where) const {
    std::vector<Index> found;
    for (Index t = 0; t < mesh.tet_count(); ++t) {
      Eigen::Vector3d middle = Eigen::Vector3d::Zero();
      for (const Index v : mesh.tets()[t]) {
        middle += mesh.rest_positions()[v] / 4;
      }
      if (where(middle)) {
        found.push_back(t);
      }
    }
    return found;
  }

  const PotentialReport& solve() { return field.solve(conductivities); }

  TetMesh shape;
  Tissue tissue;
  ThermalMesh mesh;
  std::vector<double> conductivities;  // [tet_count] S/m
  PotentialField field;
  double top;              // m
  Eigen::Vector3d centre;  // m, of the upper face
};

double area_of(double radius) {
  return pi * radius * radius;
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(
      a.begin(), a.end(), b.begin(), 0.0, [](double x, double y) { return std::max(x, y); },
      [](double x, double y) { return std::abs(x - y); });
}

bool is_quiet(const PotentialField& field) {
  return field.report().conductance == 0 && testing::sum(field.vertex_heat()) == 0 &&
         testing::sum(field.tet_heat()) == 0;
}

}  // namespace

// A disk of radius a on a half-space that ends in a ball of radius b = 10 a:
// R = atan(b / a) / (2 pi sigma a), on a mesh that knows the disk as a staircase. Would catch a
// region of a wrong size and ground in a wrong place.
TEST_CASE("potential: a contact on a block has nearly a disk's resistance", "[unit]") {
  Block block({44, 44, 22});
  const double radius = 2 * kEdge;
  block.field.set_patch(block.disk(block.centre, 1.001 * radius), area_of(radius));
  const PotentialReport& report = block.solve();
  CHECK(report.has_converged);
  CHECK(report.is_closed);
  const double exact = 2 * pi * kSigma * radius / std::atan(10.0);
  CHECK(report.conductance == Approx(exact).epsilon(0.08));
  CHECK(report.vertex_count < block.mesh.vertex_count() / 2);
}

// One vertex of a regular surface stands for a disk of about half an edge; touched in part, for
// one of that part of the area: conductance goes with the root of the weight.
TEST_CASE("potential: one vertex, touched in part, is a smaller disk", "[unit]") {
  for (const double weight : {1.0, 0.5, 0.25, 0.05}) {
    Block block({16, 16, 8});
    Index vertex = kInvalidIndex;
    for (const PatchVertex& found : block.disk(block.centre, 0.1 * kEdge)) {
      vertex = found.vertex;
    }
    const double radius = 0.5 * kEdge * std::sqrt(weight);
    block.field.set_patch(std::vector<PatchVertex>{{vertex, weight}}, area_of(radius));
    CHECK(block.solve().conductance == Approx(4 * kSigma * radius).epsilon(0.2));
    CHECK(testing::sum(block.field.vertex_heat()) ==
          Approx(block.field.report().conductance).epsilon(1e-12));
    CHECK(testing::sum(block.field.tet_heat()) <= block.field.report().conductance * (1 + 1e-12));
  }
}

// Would catch a contact so good that it drowns the tolerance: what is solved then is the contact.
TEST_CASE("potential: a vertex that is touched but for a trifle is touched whole", "[unit]") {
  const auto conductance = [](double weight) {
    Block block({16, 14, 8}, 0.1);
    std::vector<PatchVertex> patch = block.disk(block.centre, 1.1 * kEdge);
    for (PatchVertex& touched : patch) {
      touched.weight = weight;
    }
    block.field.set_patch(patch, area_of(kEdge));
    return block.solve().conductance;
  };
  CHECK(conductance(1 - 1e-9) == Approx(conductance(1)).epsilon(1e-9));
  CHECK(conductance(0.985) == Approx(conductance(1)).epsilon(0.01));  // no step where it begins
}

// Would catch a solution for nothing new, and one that is not found when it is due.
TEST_CASE("potential: it solves again only for what is new", "[unit]") {
  Block block({10, 10, 6});
  block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  CHECK(block.solve().is_new);
  const double before = block.field.report().conductance;
  const int iterations = block.field.report().iterations;
  CHECK_FALSE(block.solve().is_new);
  CHECK(block.field.report().iterations == iterations);

  const Index near = block.field.tets()[0];
  block.conductivities[near] *= 1.04;
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] *= 1.04;
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance > before);
  CHECK_FALSE(block.solve().is_new);

  block.remove({near});
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance < before);
  block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  CHECK_FALSE(block.solve().is_new);
  block.field.set_patch(block.disk(block.centre, 0.1 * kEdge), area_of(kEdge));
  CHECK(block.solve().is_new);
}

// Would catch tissue that has gone and still conducts, where conductivities may change by as much.
TEST_CASE("potential: what goes is due however much conductivities may change", "[unit]") {
  Block block({10, 10, 6}, 0, {.conductivity_change = 2});
  block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  const double before = block.solve().conductance;
  const Index near = block.field.tets()[0];
  block.conductivities[near] *= 2.9;
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] = 0;
  CHECK(block.solve().is_new);
  const double without = block.field.report().conductance;
  CHECK(without < before);
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] = kSigma;
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance == Approx(before).epsilon(1e-3));
}

// Would catch what is left of earlier patches, conductivities and tissue in a solution, and a start
// that helps not at all.
TEST_CASE("potential: a contact that moves and burns is solved as if afresh", "[unit]") {
  const PotentialOptions tight{.tolerance = 1e-10, .most_iterations = 1000};
  Block moving({14, 12, 7}, 0.1, tight);
  for (int frame = 0; frame < 8; ++frame) {
    const Eigen::Vector3d at = moving.centre + Eigen::Vector3d(0.6 * frame * kEdge, 0, 0);
    const std::vector<PatchVertex> patch = moving.disk(at, 1.2 * kEdge);
    moving.field.set_patch(patch, area_of(kEdge));
    for (const Index t :
         moving.tets_where([&](const Eigen::Vector3d& x) { return (x - at).norm() < kEdge; })) {
      moving.conductivities[t] *= 0.6;
    }
    if (frame == 5) {
      moving.remove(moving.tets_where(
          [&](const Eigen::Vector3d& x) { return (x - moving.centre).norm() < 1.2 * kEdge; }));
    }
    moving.solve();
    Block fresh({14, 12, 7}, 0.1, tight);
    if (frame >= 5) {
      fresh.remove(fresh.tets_where(
          [&](const Eigen::Vector3d& x) { return (x - fresh.centre).norm() < 1.2 * kEdge; }));
    }
    fresh.conductivities = moving.conductivities;
    fresh.field.set_patch(patch, area_of(kEdge));
    fresh.solve();
    // a region that is kept is one ball, the fresh one another
    if (moving.field.report().vertex_count == fresh.field.report().vertex_count) {
      CHECK(moving.field.report().conductance ==
            Approx(fresh.field.report().conductance).epsilon(1e-6));
    } else {
      CHECK(moving.field.report().conductance ==
            Approx(fresh.field.report().conductance).epsilon(0.03));
    }
  }
}

// A region from which tetrahedra go in any order, by edits or as they cease to conduct, against one
// that is searched for. Would catch what has gone and still conducts, rows that hang on nothing, an
// island or an open circuit seen late, and tissue that comes back unseen.
TEST_CASE("potential: a region that tissue goes from is what a search would find", "[property]") {
  const std::uint64_t seed = GENERATE(range(1, 7));
  constexpr std::array<Index, 3> kCells{5, 5, 3};
  const PotentialOptions tight{.tolerance = 1e-11, .most_iterations = 1000};
  Block burnt(kCells, 0.1, tight);
  const auto prepare = [&](Block& block) {
    std::vector<Index> ground;
    for (const PatchVertex& v : testing::patch_where(
             block.mesh, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kEdge; })) {
      ground.push_back(v.vertex);
    }
    block.field.set_ground(ground);
    block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  };
  prepare(burnt);
  burnt.solve();
  const auto last = static_cast<double>(burnt.mesh.tet_count());
  const double middle_layer = last / 3;  // of the cells, the first of its tetrahedra
  int kept = 0, opened = 0;
  for (std::uint64_t i = 0; i < 80; ++i) {
    std::vector<Index> some;
    for (std::uint64_t k = 0; k < 4; ++k) {
      const auto t = static_cast<Index>(i < 40 ? random_unit(seed, i, k) * last
                                               : middle_layer + 4 * (i - 40) + k);
      if (burnt.mesh.is_alive(t)) {
        some.push_back(t);
      }
    }
    std::ranges::sort(some);
    some.erase(std::unique(some.begin(), some.end()), some.end());
    if (i % 4 == 3 && i < 40) {
      for (const Index t : some) {
        burnt.conductivities[t] = i % 8 == 3 ? 0 : kSigma;
      }
    } else {
      burnt.remove(some);
      if (i % 10 == 8 && i < 40) {
        burnt.solve();
        burnt.tissue.undo();
      }
    }
    const std::size_t listed = burnt.field.tets().size();
    const PotentialReport& report = burnt.solve();

    Block fresh(kCells, 0.1, tight);
    prepare(fresh);
    fresh.conductivities = burnt.conductivities;
    fresh.remove(
        fresh.tets_where([&, t = 0](const auto&) mutable { return !burnt.mesh.is_alive(t++); }));
    const PotentialReport& expected = fresh.solve();
    REQUIRE(report.is_closed == expected.is_closed);
    REQUIRE(report.lost_count == expected.lost_count);
    REQUIRE(report.has_converged);
    REQUIRE(report.conductance == Approx(expected.conductance).epsilon(1e-8));
    const auto heat = [](const Block& block) {
      return testing::spread(block.field, block.field.vertex_heat(), block.mesh.vertex_count());
    };
    CHECK(largest_difference(heat(burnt), heat(fresh)) <= 1e-6 * expected.conductance);
    kept += burnt.field.tets().size() == listed && listed > fresh.field.tets().size() ? 1 : 0;
    opened += expected.is_closed ? 0 : 1;
  }
  CHECK(kept > 5);  // or nothing here was tried
  CHECK(opened > 0);
}

// Would catch a cut that no tetrahedron spans by itself: of a slab two cells thick, tetrahedra of
// either side meet in vertices alone that hang on nothing now.
TEST_CASE("potential: a cut of any thickness opens the circuit", "[unit]") {
  const int thickness = GENERATE(1, 2, 3);
  const bool is_one_edit = GENERATE(true, false);
  testing::Conductor bar(
      testing::make_box({12, 3, 3}, kEdge), [](const auto& x) { return x.x() < 0.1 * kEdge; },
      [](const auto& x) { return x.x() > 11.9 * kEdge; }, kSigma);
  REQUIRE(bar.solve().is_closed);
  const auto cell = [&](Index t) {
    double middle = 0;
    for (const Index v : bar.mesh.tets()[t]) {
      middle += bar.mesh.rest_positions()[v].x() / 4;
    }
    return static_cast<int>(middle / kEdge);
  };
  std::vector<std::vector<Index>> edits(1);
  for (Index t = 0; t < bar.mesh.tet_count(); ++t) {
    if (cell(t) >= 5 && cell(t) < 5 + thickness) {
      edits.back().push_back(t);
      edits.resize(is_one_edit ? 1 : edits.size() + 1);
    }
  }
  for (const std::vector<Index>& tets : edits) {
    bar.tissue.apply({.remove_tets = tets});
  }
  CHECK_FALSE(bar.solve().is_closed);
  CHECK(bar.field.report().conductance == 0);
  CHECK(is_quiet(bar.field));
}

// Current has no way: nothing may be heated, and nothing be other than finite.
TEST_CASE("potential: without a way for current there is no heat", "[unit]") {
  Block block({14, 14, 8});
  const std::vector<PatchVertex> patch = block.disk(block.centre, 1.1 * kEdge);
  const auto near = [&](const Eigen::Vector3d& x) { return (x - block.centre).norm(); };

  SECTION("no patch at all, before and after a contact") {
    CHECK_FALSE(block.solve().is_closed);
    block.field.set_patch(patch, area_of(kEdge));
    CHECK(block.solve().is_closed);
    block.field.set_patch({}, 0);
    CHECK_FALSE(block.solve().is_closed);
  }
  SECTION("the tissue at the patch goes") {
    block.field.set_patch(patch, area_of(kEdge));
    block.solve();
    block.remove(block.tets_where([&](const auto& x) { return near(x) < 2.5 * kEdge; }));
    CHECK(block.solve().lost_count == static_cast<Index>(patch.size()));
  }
  SECTION("the patch is on an island") {
    block.field.set_patch(patch, area_of(kEdge));
    block.solve();
    block.remove(block.tets_where(
        [&](const auto& x) { return near(x) > 2 * kEdge && near(x) < 4.8 * kEdge; }));
    CHECK_FALSE(block.solve().is_closed);
    CHECK_FALSE(block.field.vertices().empty());
    for (const double u : block.field.potentials()) {
      CHECK(u == 1);
    }
  }
  SECTION("all is dry") {
    block.field.set_patch(patch, area_of(kEdge));
    block.solve();
    block.conductivities.assign(block.conductivities.size(), 0.0);
    block.solve();
  }
  SECTION("a shell around the patch does not conduct") {
    block.field.set_patch(patch, area_of(kEdge));
    block.solve();
    for (const Index t : block.tets_where(
             [&](const auto& x) { return near(x) > 2 * kEdge && near(x) < 4.8 * kEdge; })) {
      block.conductivities[t] = 0;
    }
    CHECK_FALSE(block.solve().is_closed);
  }
  CHECK(is_quiet(block.field));

  // and it conducts once more when it may
  Block whole({8, 8, 6});
  whole.field.set_patch(whole.disk(whole.centre, 1.1 * kEdge), area_of(kEdge));
  whole.conductivities.assign(whole.conductivities.size(), 0.0);
  CHECK_FALSE(whole.solve().is_closed);
  whole.conductivities.assign(whole.conductivities.size(), kSigma);
  CHECK(whole.solve().is_closed);
}

// Islands that the patch does not touch have no potential; would catch them in a singular system.
TEST_CASE("potential: an island beside the contact has no part in it", "[unit]") {
  Block block({16, 14, 8});
  block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  const auto from_island = [&](const Eigen::Vector3d& x) {
    return (x - block.centre - Eigen::Vector3d(5 * kEdge, 0, 0)).norm();
  };
  block.remove(block.tets_where([&](const Eigen::Vector3d& x) {
    return from_island(x) > kEdge && from_island(x) < 3.7 * kEdge;
  }));
  CHECK(block.solve().is_closed);
  CHECK(block.field.report().has_converged);
  for (const Index v : block.field.vertices()) {
    CHECK(from_island(block.mesh.rest_positions()[v]) > 2.3 * kEdge);
  }
}

// Stopped early, power is still U^2 times the conductance that is reported, which exceeds the true
// one (the potential of least power is the solution); going on comes nearer.
TEST_CASE("potential: stopped early, heat still sums to what is reported", "[unit]") {
  Block exact({14, 14, 8});
  Block hurried({14, 14, 8}, 0, {.tolerance = 1e-9, .most_iterations = 3});
  for (Block* block : {&exact, &hurried}) {
    block->field.set_patch(block->disk(block->centre, 1.1 * kEdge), area_of(kEdge));
    block->solve();
  }
  CHECK_FALSE(hurried.field.report().has_converged);
  double before = 0;
  for (int i = 0; i < 5; ++i) {
    const PotentialReport& report = hurried.solve();
    CHECK(testing::sum(hurried.field.tet_heat()) == Approx(report.conductance).epsilon(1e-12));
    CHECK(report.conductance > exact.field.report().conductance * (1 - 1e-5));
    CHECK((i == 0 || report.conductance <= before));
    before = report.conductance;
  }
  CHECK(before == Approx(exact.field.report().conductance).epsilon(0.01));
}

// A bar stretched to twice its length has half the conductance; turned, it has the same, and so has
// its mirror image; flat, it has no cross-section.
TEST_CASE("potential: the current shape of tissue counts when it is given", "[unit]") {
  const TetMesh bar = testing::make_box({6, 2, 2}, kEdge);
  testing::Conductor at(
      bar, [](const auto& x) { return x.x() < 0.1 * kEdge; },
      [](const auto& x) { return x.x() > 5.9 * kEdge; }, kSigma);
  const double rest = at.solve().conductance;
  const auto solve_mapped = [&](const Eigen::Matrix3f& map) {
    std::vector<Eigen::Vector3f> positions;
    for (const Eigen::Vector3d& x : bar.positions()) {
      positions.emplace_back(map * x.cast<float>());
    }
    return at.field.solve(at.conductivities, positions).conductance;
  };
  const Eigen::AngleAxisf turn(0.7F, Eigen::Vector3f(1, 2, 3).normalized());
  CHECK(solve_mapped(turn.toRotationMatrix()) == Approx(rest).epsilon(1e-5));
  CHECK(solve_mapped(Eigen::Vector3f(2, 1, 1).asDiagonal()) == Approx(rest / 2).epsilon(1e-5));
  CHECK(solve_mapped(Eigen::Vector3f(1, -1, 1).asDiagonal()) == Approx(rest).epsilon(1e-5));
  CHECK(solve_mapped(Eigen::Vector3f(1, 0, 1).asDiagonal()) == Approx(0).margin(1e-9 * rest));
  CHECK(std::isfinite(solve_mapped(Eigen::Vector3f(0, 0, 0).asDiagonal())));
  CHECK(at.solve().conductance == Approx(rest).epsilon(1e-9));
}

// A vertex drawn almost into the opposite face of a tetrahedron under the contact. Would catch
// coefficients that are not finite, and a solution that slivers spoil.
TEST_CASE("potential: slivers under the contact leave it finite", "[unit]") {
  const TetMesh regular = testing::make_box({10, 10, 6}, kEdge);
  std::vector<Eigen::Vector3d> points(regular.positions().begin(), regular.positions().end());
  const Index moved = 5 + 11 * (5 + 11 * 5);  // one cell below the middle of the upper face
  const Eigen::Vector3d start = points[moved];
  points[moved] = start + (1 - 1e-7) * kEdge * Eigen::Vector3d(0, 0, 1);
  const ThermalMesh mesh(TetMesh(points, {regular.tets().begin(), regular.tets().end()}),
                         tissues::liver().heat);
  PotentialField field(mesh);
  field.set_patch(
      testing::patch_where(
          mesh, [&](const Eigen::Vector3d& x) { return (x - points[moved]).norm() < 1.1 * kEdge; }),
      area_of(kEdge));
  const std::vector<double> conductivities(regular.tets().size(), kSigma);
  const PotentialReport& report = field.solve(conductivities);
  CHECK(report.has_converged);
  const double rest = report.conductance;
  CHECK(rest == Approx(4 * kSigma * 1.25 * kEdge).epsilon(0.3));
  CHECK(testing::sum(field.vertex_heat()) == Approx(rest).epsilon(1e-12));

  // given as positions, too; and where the mesh is a point, there is no current
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : points) {
    positions.push_back(x.cast<float>());
  }
  CHECK(field.solve(conductivities, positions).has_converged);
  CHECK(report.conductance == Approx(rest).epsilon(0.01));
  CHECK(testing::sum(field.vertex_heat()) == Approx(report.conductance).epsilon(1e-12));
  positions.assign(positions.size(), Eigen::Vector3f::Zero());
  CHECK(field.solve(conductivities, positions).conductance == 0);
}

// Would catch a message that names nothing, and a half-done change.
TEST_CASE("potential: bad input is refused and changes nothing", "[unit]") {
  Block block({8, 8, 6});
  block.field.set_patch(block.disk(block.centre, 1.1 * kEdge), area_of(kEdge));
  block.solve();
  const double before = block.field.report().conductance;
  const std::vector<double> heat(block.field.vertex_heat().begin(),
                                 block.field.vertex_heat().end());
  using Patch = std::vector<PatchVertex>;
  const double nan = std::nan("");
  CHECK_THROWS_AS(block.field.set_patch(Patch{{-1, 1}}, 1e-6), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{block.mesh.vertex_count(), 1}}, 1e-6),
                  InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, 0}}, 1e-6), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, 1.1}}, 1e-6), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, nan}}, 1e-6), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, 1}, {0, 1}}, 1e-6), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, 1}}, 0), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_patch(Patch{{0, 1}}, nan), InvalidArgument);
  CHECK_THROWS_AS(block.field.set_ground(std::vector<Index>{-1}), InvalidArgument);
  CHECK_THROWS_AS(block.field.solve({}), InvalidArgument);
  const Index tet = block.field.tets()[3];
  for (const double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
    block.conductivities[tet] = bad;
    CHECK_THROWS_WITH(block.solve(), ContainsSubstring("tet " + std::to_string(tet) + " "));
  }
  block.conductivities[tet] = kSigma;
  std::vector<Eigen::Vector3f> positions(block.mesh.rest_positions().size(),
                                         Eigen::Vector3f::Zero());
  positions[block.field.vertices()[2]].y() = std::numeric_limits<float>::infinity();
  CHECK_THROWS_AS(block.field.solve(block.conductivities, positions), InvalidArgument);
  CHECK_FALSE(block.solve().is_new);
  CHECK(block.field.report().conductance == before);
  CHECK(std::equal(heat.begin(), heat.end(), block.field.vertex_heat().begin()));

  for (const PotentialOptions& bad :
       {PotentialOptions{.region_radii = 1}, PotentialOptions{.tolerance = 0},
        PotentialOptions{.tolerance = 1}, PotentialOptions{.most_iterations = -1},
        PotentialOptions{.conductivity_change = nan}, PotentialOptions{.device_rows = -1}}) {
    CHECK_THROWS_AS(PotentialField(block.mesh, bad), InvalidArgument);
  }
}

// Would catch sums whose pieces depend on who works, in a region large enough for threads.
TEST_CASE("potential: any number of threads gives the same bits", "[unit]") {
  std::vector<double> expected;
  for (const int threads : {1, 2, 3}) {
    Block block({26, 26, 13}, 0.1, {.executor = executor::threads(threads)});
    std::vector<double> all;
    for (int frame = 0; frame < 3; ++frame) {
      const Eigen::Vector3d at = block.centre + Eigen::Vector3d(0.7 * frame * kEdge, 0, 0);
      block.field.set_patch(block.disk(at, 1.3 * kEdge), area_of(1.2 * kEdge));
      CHECK(block.solve().has_converged);
      CHECK(block.field.report().vertex_count * block.field.report().iterations >
            kVisitsWorthThreads);
      all.insert(all.end(), block.field.vertex_heat().begin(), block.field.vertex_heat().end());
    }
    if (threads == 1) {
      expected = all;
    }
    CHECK(all == expected);
  }
}

}  // namespace pbdsurg
