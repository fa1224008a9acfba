// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/heat_field.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "pbdsurg/core/error.h"

#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

double sum(const HeatLedger& ledger) {
  return ledger.sensible + ledger.latent + ledger.removed;
}

}  // namespace

// A slab heated evenly at one end: T - T0 = 2 q/k sqrt(a t/pi) ierfc-like profile, at the face
// 2 q/k sqrt(a t / pi) (Carslaw and Jaeger 1959, section 2.9).
TEST_CASE("heat field: a half space under constant flux follows its closed form", "[validation]") {
  constexpr double kStep = 0.25e-3;
  const TetMesh bar = testing::make_box({60, 2, 2}, kStep);
  const TissueProperties dry{1000, 3600, 0.5, 0};
  HeatField field(bar, dry);
  const double flux = 5e3;  // W/m^2
  const double width = 2 * kStep;
  // a face vertex takes the flux through a third of each triangle around it
  std::vector<HeatSource> sources;
  std::vector<double> areas(bar.positions().size(), 0.0);
  for (const BoundaryTriangle& triangle : find_boundary(bar.tets())) {
    const auto& v = triangle.vertices;
    if (bar.positions()[v[0]].x() == 0 && bar.positions()[v[1]].x() == 0 &&
        bar.positions()[v[2]].x() == 0) {
      for (const Index corner : v) {
        areas[corner] += kStep * kStep / 6;
      }
    }
  }
  double area = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    if (areas[v] > 0) {
      sources.push_back({static_cast<Index>(v), flux * areas[v]});
      area += areas[v];
    }
  }
  REQUIRE(area == Approx(width * width));
  const double time = 4;
  for (int i = 0; i < 400; ++i) {
    field.step(time / 400, sources);
  }

  const double diffusivity = dry.conductivity / (dry.density * dry.specific_heat);
  const auto rise = [&](double x) {
    const double s = std::sqrt(diffusivity * time);
    return 2 * flux / dry.conductivity *
           (s / std::sqrt(3.14159265358979) * std::exp(-x * x / (4 * s * s)) -
            x / 2 * std::erfc(x / (2 * s)));
  };
  for (int i = 0; i <= 12; i += 3) {
    const double measured = field.temperatures()[i] - kBodyTemperature;
    CHECK(measured == Approx(rise(i * kStep)).epsilon(0.02).margin(0.01 * rise(0)));
  }
  CHECK(sum(field.ledger()) == Approx(flux * area * time));
}

// Would catch heat made or lost by conduction, boiling or removal.
TEST_CASE("heat field: every joule is accounted for", "[property]") {
  const TetMesh block = testing::make_box({6, 6, 6}, 1e-3, 0.1);
  Scene scene;
  scene.add_body("block", block);
  Solver solver(scene);
  HeatField field(block, kFat);
  EditParticipant* participants[] = {&field};
  std::vector<HeatSource> sources;
  for (const Index v : block.tets()[500]) {
    sources.push_back({v, 1.5});
  }
  for (int i = 0; i < 100; ++i) {
    field.step(5e-3, sources);
    if (i == 60) {
      TopologyEdit edit;
      for (Index t = 0; t < block.tet_count(); ++t) {
        if (field.boiling_vertices(t) == 4) {
          edit.remove_tets.push_back(t);
        }
      }
      REQUIRE_FALSE(edit.remove_tets.empty());
      apply_edit(solver, edit, participants);
    }
    CHECK(sum(field.ledger()) == Approx(field.ledger().in).epsilon(1e-9));
  }
  CHECK(field.ledger().latent > 0);
  CHECK(field.ledger().removed > 0);
}

TEST_CASE("heat field: temperature waits at 100 degrees until the water is gone", "[unit]") {
  const TetMesh block = testing::make_box({1, 1, 1}, 1e-3);
  HeatField field(block, kLiver);
  std::vector<HeatSource> everywhere;
  const std::vector<double> masses = lumped_masses(block, kLiver.density);
  for (Index v = 0; v < 8; ++v) {
    everywhere.push_back({v, 1e6 * masses[v]});  // 1 MW/kg
  }
  const double to_boil = 63 * kLiver.specific_heat / 1e6;                  // s
  const double to_dry = kLiver.water_fraction * kLatentHeatOfWater / 1e6;  // s

  field.step(0.99 * to_boil, everywhere);
  CHECK(field.temperatures()[3] < kBoilingTemperature);
  CHECK(field.water()[3] == 1);
  field.step(0.01 * to_boil + 0.5 * to_dry, everywhere);
  CHECK(field.temperatures()[3] == kBoilingTemperature);
  CHECK(field.water()[3] == Approx(0.5));
  field.step(0.6 * to_dry, everywhere);
  CHECK(field.water()[3] == 0);
  CHECK(field.temperatures()[3] ==
        Approx(kBoilingTemperature + 0.1 * to_dry * 1e6 / kLiver.specific_heat));
  CHECK(field.boiling_vertices(0) == 4);
}

// Would catch an unstable explicit step: flat and obtuse tetrahedra need tiny steps and have
// negative conductances, and must neither blow up nor cool below what surrounds them.
TEST_CASE("heat field: temperatures stay between those around, on the worst of meshes",
          "[property]") {
  const double height = GENERATE(1.0, 0.1, 0.03);  // of a cell, relative to its width
  const double dt = GENERATE(5e-3, 0.5);
  const TetMesh block = testing::make_box({6, 6, 4}, 1e-3, 0.2);
  std::vector<Eigen::Vector3d> points(block.positions().begin(), block.positions().end());
  for (Eigen::Vector3d& p : points) {
    p.z() *= height;
  }
  const TetMesh flat(points, {block.tets().begin(), block.tets().end()});
  HeatField field(flat, kLiver);
  field.step(5e-3, std::vector<HeatSource>{{100, 0.05}});
  const double peak = *std::max_element(field.temperatures().begin(), field.temperatures().end());
  REQUIRE(peak > kBodyTemperature);
  for (int i = 0; i < 200; ++i) {
    field.step(dt, {});
    for (const double t : field.temperatures()) {
      REQUIRE(t >= kBodyTemperature - 1e-9);
      REQUIRE(t <= peak + 1e-9);
    }
  }
  CHECK(sum(field.ledger()) == Approx(field.ledger().in));
  if (height < 0.1 && dt > 0.1) {
    CHECK(field.limited_edge_count() > 0);
  }
}

TEST_CASE("heat field: it follows an edit of its own body only", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, 1e-3);
  scene.add_body("first", block);
  const Index second = scene.add_body("second", block);
  Solver solver(scene);
  HeatField field(block, kFat, scene.body(second).first_tet);
  field.step(0.01, std::vector<HeatSource>{{13, 1.0}});
  EditParticipant* participants[] = {&field};

  apply_edit(solver, {.remove_tets = {0, 1, 2}}, participants);
  CHECK(field.ledger().removed == 0);

  TopologyEdit rest;
  for (Index t = 0; t < block.tet_count(); ++t) {
    rest.remove_tets.push_back(scene.body(second).first_tet + t);
  }
  apply_edit(solver, rest, participants);
  CHECK(field.ledger().removed == Approx(0.01));
  CHECK_FALSE(field.has_tissue(13));
  field.step(0.01, std::vector<HeatSource>{{13, 1.0}});
  CHECK(field.ledger().in == Approx(0.01));  // nothing to heat any more
}

TEST_CASE("heat field: bad values are refused by name", "[unit]") {
  const TetMesh block = testing::make_box({1, 1, 1}, 1e-3);
  CHECK_THROWS_WITH(HeatField(block, {0, 1, 1, 0}), ContainsSubstring("density"));
  CHECK_THROWS_WITH(HeatField(block, {1, 1, 1, 1.5}), ContainsSubstring("water fraction is 1.5"));
  HeatField field(block, kFat);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK_THROWS_AS(field.step(0, {}), InvalidArgument);
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{8, 1}}), ContainsSubstring("vertex 8"));
  CHECK_THROWS_WITH(field.step(1, std::vector<HeatSource>{{1, nan}}), ContainsSubstring("power"));
  CHECK(field.ledger().in == 0);
}

}  // namespace pbdsurg
