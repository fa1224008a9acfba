// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/potential_field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/library.h"

#include "lib/base/shared_work.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"
#include "tests/support/touched_block.h"

namespace pbdsurg {
namespace {

using std::numbers::pi;
using testing::Approx;
using testing::area_of;
using testing::ContainsSubstring;
using testing::kTouchedEdge;
using testing::kTouchedSigma;
using testing::TouchedBlock;

}  // namespace

// A disk of radius a on a half-space that ends in a ball of radius b = 10 a:
// R = atan(b / a) / (2 pi sigma a), on a mesh that knows the disk as a staircase. Would catch a
// region of a wrong size and ground in a wrong place.
TEST_CASE("potential: a contact on a block has nearly a disk's resistance", "[unit]") {
  TouchedBlock block({44, 44, 22});
  const double radius = 2 * kTouchedEdge;
  block.field.set_patch(block.disk(block.centre, 1.001 * radius), area_of(radius));
  const PotentialReport& report = block.solve();
  CHECK(report.has_converged);
  CHECK(report.is_closed);
  const double exact = 2 * pi * kTouchedSigma * radius / std::atan(10.0);
  CHECK(report.conductance == Approx(exact).epsilon(0.08));
  CHECK(report.vertex_count < block.mesh.vertex_count() / 2);
}

// One vertex of a regular surface stands for a disk of about half an edge; touched in part, for
// one of that part of the area: conductance goes with the root of the weight.
TEST_CASE("potential: one vertex, touched in part, is a smaller disk", "[unit]") {
  for (const double weight : {1.0, 0.5, 0.25, 0.05}) {
    TouchedBlock block({16, 16, 8});
    Index vertex = kInvalidIndex;
    for (const PatchVertex& found : block.disk(block.centre, 0.1 * kTouchedEdge)) {
      vertex = found.vertex;
    }
    const double radius = 0.5 * kTouchedEdge * std::sqrt(weight);
    block.field.set_patch(std::vector<PatchVertex>{{vertex, weight}}, area_of(radius));
    CHECK(block.solve().conductance == Approx(4 * kTouchedSigma * radius).epsilon(0.2));
    CHECK(testing::sum(block.field.vertex_heat()) ==
          Approx(block.field.report().conductance).epsilon(1e-12));
    CHECK(testing::sum(block.field.element_heat()) <=
          block.field.report().conductance * (1 + 1e-12));
  }
}

// Would catch a contact so good that it drowns the tolerance: what is solved then is the contact.
TEST_CASE("potential: a vertex that is touched but for a trifle is touched whole", "[unit]") {
  const auto conductance = [](double weight) {
    TouchedBlock block({16, 14, 8}, 0.1);
    std::vector<PatchVertex> patch = block.disk(block.centre, 1.1 * kTouchedEdge);
    for (PatchVertex& touched : patch) {
      touched.weight = weight;
    }
    block.field.set_patch(patch, area_of(kTouchedEdge));
    return block.solve().conductance;
  };
  CHECK(conductance(1 - 1e-9) == Approx(conductance(1)).epsilon(1e-9));
  CHECK(conductance(0.985) == Approx(conductance(1)).epsilon(0.01));  // no step where it begins
}

// Stopped early, power is still U^2 times the conductance that is reported, which exceeds the true
// one (the potential of least power is the solution); going on comes nearer.
TEST_CASE("potential: stopped early, heat still sums to what is reported", "[unit]") {
  TouchedBlock exact({14, 14, 8});
  TouchedBlock hurried({14, 14, 8}, 0, {.tolerance = 1e-9, .most_iterations = 3});
  for (TouchedBlock* block : {&exact, &hurried}) {
    block->field.set_patch(block->disk(block->centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
    block->solve();
  }
  CHECK_FALSE(hurried.field.report().has_converged);
  double before = 0;
  for (int i = 0; i < 5; ++i) {
    const PotentialReport& report = hurried.solve();
    CHECK(testing::sum(hurried.field.element_heat()) == Approx(report.conductance).epsilon(1e-12));
    CHECK(report.conductance > exact.field.report().conductance * (1 - 1e-5));
    CHECK((i == 0 || report.conductance <= before));
    before = report.conductance;
  }
  CHECK(before == Approx(exact.field.report().conductance).epsilon(0.01));
}

// A bar stretched to twice its length has half the conductance; turned, it has the same, and so has
// its mirror image; flat, it has no cross-section.
TEST_CASE("potential: the current shape of tissue counts when it is given", "[unit]") {
  const TetMesh bar = testing::make_box({6, 2, 2}, kTouchedEdge);
  testing::Conductor at(
      bar, [](const auto& x) { return x.x() < 0.1 * kTouchedEdge; },
      [](const auto& x) { return x.x() > 5.9 * kTouchedEdge; }, kTouchedSigma);
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
  const TetMesh regular = testing::make_box({10, 10, 6}, kTouchedEdge);
  std::vector<Eigen::Vector3d> points(regular.positions().begin(), regular.positions().end());
  const Index moved = 5 + 11 * (5 + 11 * 5);  // one cell below the middle of the upper face
  const Eigen::Vector3d start = points[moved];
  points[moved] = start + (1 - 1e-7) * kTouchedEdge * Eigen::Vector3d(0, 0, 1);
  const ThermalMesh mesh(TetMesh(points, {regular.tets().begin(), regular.tets().end()}),
                         tissues::liver().heat);
  PotentialField field(mesh);
  field.set_patch(testing::patch_where(mesh,
                                       [&](const Eigen::Vector3d& x) {
                                         return (x - points[moved]).norm() < 1.1 * kTouchedEdge;
                                       }),
                  area_of(kTouchedEdge));
  const std::vector<double> conductivities(regular.tets().size(), kTouchedSigma);
  const PotentialReport& report = field.solve(conductivities);
  CHECK(report.has_converged);
  const double rest = report.conductance;
  CHECK(rest == Approx(4 * kTouchedSigma * 1.25 * kTouchedEdge).epsilon(0.3));
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
  TouchedBlock block({8, 8, 6});
  block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
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
  const Index tet = block.field.elements()[3];
  for (const double bad : {-1.0, nan, std::numeric_limits<double>::infinity()}) {
    block.conductivities[tet] = bad;
    CHECK_THROWS_WITH(block.solve(), ContainsSubstring("tet " + std::to_string(tet) + " "));
  }
  block.conductivities[tet] = kTouchedSigma;
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
    TouchedBlock block({26, 26, 13}, 0.1, {.executor = executor::threads(threads)});
    std::vector<double> all;
    for (int frame = 0; frame < 3; ++frame) {
      const Eigen::Vector3d at = block.centre + Eigen::Vector3d(0.7 * frame * kTouchedEdge, 0, 0);
      block.field.set_patch(block.disk(at, 1.3 * kTouchedEdge), area_of(1.2 * kTouchedEdge));
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
