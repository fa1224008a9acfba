// SPDX-License-Identifier: Apache-2.0
// Potentials of contacts, conductivities and tissue that change, as far as current has a way.
#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/heat/potential_field.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/potential_cases.h"
#include "tests/support/touched_block.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::area_of;
using testing::kTouchedEdge;
using testing::kTouchedSigma;
using testing::TouchedBlock;

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  return std::inner_product(
      a.begin(), a.end(), b.begin(), 0.0, [](double x, double y) { return std::max(x, y); },
      [](double x, double y) { return std::abs(x - y); });
}

bool is_quiet(const PotentialField& field) {
  return field.report().conductance == 0 && testing::sum(field.vertex_heat()) == 0 &&
         testing::sum(field.element_heat()) == 0;
}

}  // namespace

// Would catch a solution for nothing new, and one that is not found when it is due.
TEST_CASE("potential: it solves again only for what is new", "[unit]") {
  TouchedBlock block({10, 10, 6});
  block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
  CHECK(block.solve().is_new);
  const double before = block.field.report().conductance;
  const int iterations = block.field.report().iterations;
  CHECK_FALSE(block.solve().is_new);
  CHECK(block.field.report().iterations == iterations);

  const Index near = block.field.elements()[0];
  block.conductivities[near] *= 1.04;
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] *= 1.04;
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance > before);
  CHECK_FALSE(block.solve().is_new);

  block.remove({near});
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance < before);
  block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
  CHECK_FALSE(block.solve().is_new);
  block.field.set_patch(block.disk(block.centre, 0.1 * kTouchedEdge), area_of(kTouchedEdge));
  CHECK(block.solve().is_new);
}

// Would catch tissue that has gone and still conducts, where conductivities may change by as much.
TEST_CASE("potential: what goes is due however much conductivities may change", "[unit]") {
  TouchedBlock block({10, 10, 6}, 0, {.conductivity_change = 2});
  block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
  const double before = block.solve().conductance;
  const Index near = block.field.elements()[0];
  block.conductivities[near] *= 2.9;
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] = 0;
  CHECK(block.solve().is_new);
  const double without = block.field.report().conductance;
  CHECK(without < before);
  CHECK_FALSE(block.solve().is_new);
  block.conductivities[near] = kTouchedSigma;
  CHECK(block.solve().is_new);
  CHECK(block.field.report().conductance == Approx(before).epsilon(1e-3));
}

// Would catch what is left of earlier patches, conductivities and tissue in a solution, and a start
// that helps not at all.
TEST_CASE("potential: a contact that moves and burns is solved as if afresh", "[unit]") {
  const PotentialOptions tight{.tolerance = 1e-10, .most_iterations = 1000};
  TouchedBlock moving({14, 12, 7}, 0.1, tight);
  for (int frame = 0; frame < 8; ++frame) {
    const Eigen::Vector3d at = moving.centre + Eigen::Vector3d(0.6 * frame * kTouchedEdge, 0, 0);
    const std::vector<PatchVertex> patch = moving.disk(at, 1.2 * kTouchedEdge);
    moving.field.set_patch(patch, area_of(kTouchedEdge));
    for (const Index t : moving.tets_where(
             [&](const Eigen::Vector3d& x) { return (x - at).norm() < kTouchedEdge; })) {
      moving.conductivities[t] *= 0.6;
    }
    if (frame == 5) {
      moving.remove(moving.tets_where([&](const Eigen::Vector3d& x) {
        return (x - moving.centre).norm() < 1.2 * kTouchedEdge;
      }));
    }
    moving.solve();
    TouchedBlock fresh({14, 12, 7}, 0.1, tight);
    if (frame >= 5) {
      fresh.remove(fresh.tets_where([&](const Eigen::Vector3d& x) {
        return (x - fresh.centre).norm() < 1.2 * kTouchedEdge;
      }));
    }
    fresh.conductivities = moving.conductivities;
    fresh.field.set_patch(patch, area_of(kTouchedEdge));
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
  TouchedBlock burnt(kCells, 0.1, tight);
  const auto prepare = [&](TouchedBlock& block) {
    std::vector<Index> ground;
    for (const PatchVertex& v : testing::patch_where(
             block.mesh, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kTouchedEdge; })) {
      ground.push_back(v.vertex);
    }
    block.field.set_ground(ground);
    block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
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
        burnt.conductivities[t] = i % 8 == 3 ? 0 : kTouchedSigma;
      }
    } else {
      burnt.remove(some);
      if (i % 10 == 8 && i < 40) {
        burnt.solve();
        burnt.tissue.undo();
      }
    }
    const std::size_t listed = burnt.field.elements().size();
    const PotentialReport& report = burnt.solve();

    TouchedBlock fresh(kCells, 0.1, tight);
    prepare(fresh);
    fresh.conductivities = burnt.conductivities;
    fresh.remove(
        fresh.tets_where([&, t = 0](const auto&) mutable { return !burnt.mesh.is_alive(t++); }));
    const PotentialReport& expected = fresh.solve();
    REQUIRE(report.is_closed == expected.is_closed);
    REQUIRE(report.lost_count == expected.lost_count);
    REQUIRE(report.has_converged);
    REQUIRE(report.conductance == Approx(expected.conductance).epsilon(1e-8));
    const auto heat = [](const TouchedBlock& block) {
      return testing::spread(block.field, block.field.vertex_heat(), block.mesh.vertex_count());
    };
    CHECK(largest_difference(heat(burnt), heat(fresh)) <= 1e-6 * expected.conductance);
    kept +=
        burnt.field.elements().size() == listed && listed > fresh.field.elements().size() ? 1 : 0;
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
      testing::make_box({12, 3, 3}, kTouchedEdge),
      [](const auto& x) { return x.x() < 0.1 * kTouchedEdge; },
      [](const auto& x) { return x.x() > 11.9 * kTouchedEdge; }, kTouchedSigma);
  REQUIRE(bar.solve().is_closed);
  const auto cell = [&](Index t) {
    double middle = 0;
    for (const Index v : bar.mesh.tets()[t]) {
      middle += bar.mesh.rest_positions()[v].x() / 4;
    }
    return static_cast<int>(middle / kTouchedEdge);
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
  TouchedBlock block({14, 14, 8});
  const std::vector<PatchVertex> patch = block.disk(block.centre, 1.1 * kTouchedEdge);
  const auto near = [&](const Eigen::Vector3d& x) { return (x - block.centre).norm(); };

  SECTION("no patch at all, before and after a contact") {
    CHECK_FALSE(block.solve().is_closed);
    block.field.set_patch(patch, area_of(kTouchedEdge));
    CHECK(block.solve().is_closed);
    block.field.set_patch({}, 0);
    CHECK_FALSE(block.solve().is_closed);
  }
  SECTION("the tissue at the patch goes") {
    block.field.set_patch(patch, area_of(kTouchedEdge));
    block.solve();
    block.remove(block.tets_where([&](const auto& x) { return near(x) < 2.5 * kTouchedEdge; }));
    CHECK(block.solve().lost_count == static_cast<Index>(patch.size()));
  }
  SECTION("the patch is on an island") {
    block.field.set_patch(patch, area_of(kTouchedEdge));
    block.solve();
    block.remove(block.tets_where(
        [&](const auto& x) { return near(x) > 2 * kTouchedEdge && near(x) < 4.8 * kTouchedEdge; }));
    CHECK_FALSE(block.solve().is_closed);
    CHECK_FALSE(block.field.vertices().empty());
    for (const double u : block.field.potentials()) {
      CHECK(u == 1);
    }
  }
  SECTION("all is dry") {
    block.field.set_patch(patch, area_of(kTouchedEdge));
    block.solve();
    block.conductivities.assign(block.conductivities.size(), 0.0);
    block.solve();
  }
  SECTION("a shell around the patch does not conduct") {
    block.field.set_patch(patch, area_of(kTouchedEdge));
    block.solve();
    for (const Index t : block.tets_where([&](const auto& x) {
           return near(x) > 2 * kTouchedEdge && near(x) < 4.8 * kTouchedEdge;
         })) {
      block.conductivities[t] = 0;
    }
    CHECK_FALSE(block.solve().is_closed);
  }
  CHECK(is_quiet(block.field));

  // and it conducts once more when it may
  TouchedBlock whole({8, 8, 6});
  whole.field.set_patch(whole.disk(whole.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
  whole.conductivities.assign(whole.conductivities.size(), 0.0);
  CHECK_FALSE(whole.solve().is_closed);
  whole.conductivities.assign(whole.conductivities.size(), kTouchedSigma);
  CHECK(whole.solve().is_closed);
}

// Islands that the patch does not touch have no potential; would catch them in a singular system.
TEST_CASE("potential: an island beside the contact has no part in it", "[unit]") {
  TouchedBlock block({16, 14, 8});
  block.field.set_patch(block.disk(block.centre, 1.1 * kTouchedEdge), area_of(kTouchedEdge));
  const auto from_island = [&](const Eigen::Vector3d& x) {
    return (x - block.centre - Eigen::Vector3d(5 * kTouchedEdge, 0, 0)).norm();
  };
  block.remove(block.tets_where([&](const Eigen::Vector3d& x) {
    return from_island(x) > kTouchedEdge && from_island(x) < 3.7 * kTouchedEdge;
  }));
  CHECK(block.solve().is_closed);
  CHECK(block.field.report().has_converged);
  for (const Index v : block.field.vertices()) {
    CHECK(from_island(block.mesh.rest_positions()[v]) > 2.3 * kTouchedEdge);
  }
}

}  // namespace pbdsurg
