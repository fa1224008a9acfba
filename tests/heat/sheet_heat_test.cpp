// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_refused;
using testing::ledger_error;
using testing::SheetMesh;

constexpr double kThickness = 1.0 / 1024;  // m, without rounding

// Membrane whose conductivity does not depend on temperature.
ThermalProperties plain() {
  ThermalProperties properties = tissues::membrane().heat;
  properties.conductivity_rise = 0;
  return properties;
}

Scene scene_of(const SheetMesh& mesh) {
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles,
                  {.thickness = static_cast<float>(kThickness)});
  return scene;
}

// A sheet alone in its tissue, and its heat.
struct HeatedSheet {
  explicit HeatedSheet(const SheetMesh& mesh, const ThermalModel& model = {},
                       const ThermalProperties& properties = plain(),
                       const HeatOptions& options = {.active_rise = 0, .tolerance = 1e-12})
      : tissue(scene_of(mesh)),
        field(tissue, std::array{ThermalBody{0, properties}}, model, options) {}

  [[nodiscard]] std::vector<Index> where(const testing::Where& condition) const {
    std::vector<Index> found;
    for (Index v = 0; v < tissue.vertex_count(); ++v) {
      if (condition(tissue.rest_positions()[static_cast<std::size_t>(v)])) {
        found.push_back(v);
      }
    }
    return found;
  }

  Tissue tissue;
  HeatField field;
};

// Without blood and air.
ThermalModel conduction() {
  ThermalModel model;
  model.has_perfusion = false;
  model.surface_transfer = 0;
  return model;
}

}  // namespace

// Would catch another conductivity or capacity than that of the thickness, and coefficients of the
// wrong edges. After Carslaw and Jaeger, a half-space whose side is held at a temperature.
TEST_CASE("sheet heat: spreads from a held side as in closed form", "[property]") {
  constexpr double kEdge = 0.25e-3, kHot = 60, kDt = 0.02, kTime = 10;  // m, degrees Celsius, s
  HeatedSheet sheet(testing::make_sheet({80, 4}, kEdge, 0.2), conduction());
  const std::vector<Index> side = sheet.where([](const auto& x) { return x.x() < 0.1 * kEdge; });
  sheet.field.set_temperatures(side, std::vector<double>(side.size(), kHot));
  sheet.field.hold(side);
  for (int i = 0; i < std::lround(kTime / kDt); ++i) {
    REQUIRE(sheet.field.step(kDt, {}).converged);
  }
  const ThermalProperties properties = plain();
  const double diffusivity =
      properties.conductivity / (properties.density * properties.specific_heat);
  CHECK(testing::largest_error(sheet.field, [&](const Eigen::Vector3d& x) {
          return kBodyTemperature + (kHot - kBodyTemperature) *
                                        std::erfc(x.x() / (2 * std::sqrt(diffusivity * kTime)));
        }) < 0.01 * (kHot - kBodyTemperature));
}

// Would catch a face that loses nothing, or both that lose twice.
TEST_CASE("sheet heat: cools through both faces as in closed form", "[unit]") {
  ThermalModel model = conduction();
  model.surface_transfer = 50;  // W/(m^2 K)
  model.ambient_temperature = 20;
  HeatedSheet sheet(testing::make_sheet({5, 4}, 2e-3, 0.2), model);
  const std::vector<Index> all = sheet.where([](const auto&) { return true; });
  sheet.field.set_temperatures(all, std::vector<double>(all.size(), 60));
  constexpr double kTime = 20;  // s
  for (int i = 0; i < 2000; ++i) {
    sheet.field.step(kTime / 2000, {});
  }
  const ThermalProperties properties = plain();
  const double rate =
      2 * model.surface_transfer / (properties.density * properties.specific_heat * kThickness);
  const double expected = 20 + 40 * std::exp(-rate * kTime);
  for (const double temperature : sheet.field.temperatures()) {
    REQUIRE(temperature - 20 == Approx(expected - 20).epsilon(2e-3));
  }
  CHECK(std::abs(ledger_error(sheet.field.ledger())) < 1e-12 * sheet.field.ledger().in);
}

// Would catch a mass, conductance or latent heat that a slab of the same thickness does not have.
TEST_CASE("sheet heat: a slab as thick agrees", "[property]") {
  constexpr std::array<Index, 2> kCells{24, 3};
  const ThermalProperties properties = tissues::membrane().heat;
  HeatedSheet sheet(testing::make_sheet(kCells, kThickness), conduction(), properties);
  const TetMesh box = testing::make_box({kCells[0], kCells[1], 1}, kThickness);
  HeatField slab(box, properties, conduction(), {.active_rise = 0, .tolerance = 1e-12});
  const auto mass = [](const HeatField& field) {
    double sum = 0;
    for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
      sum += field.mesh().mass(v);
    }
    return sum;
  };
  CHECK(mass(sheet.field) == Approx(mass(slab)));
  const auto heat_side = [](HeatField& field) {
    std::vector<HeatSource> sources;
    double length = 0;
    const auto share = [&](Index v) {  // of the side, by mass
      return field.mesh().rest_positions()[static_cast<std::size_t>(v)].x() < 0.1 * kThickness
                 ? field.mesh().mass(v)
                 : 0;
    };
    for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
      length += share(v);
    }
    for (Index v = 0; v < field.mesh().vertex_count(); ++v) {
      if (share(v) > 0) {
        sources.push_back({v, 0.3 * share(v) / length});
      }
    }
    for (int i = 0; i < 1000; ++i) {
      field.step(0.02, sources);
    }
    return field.ledger();
  };
  const HeatLedger of_sheet = heat_side(sheet.field), of_slab = heat_side(slab);
  CHECK(of_sheet.in == Approx(of_slab.in).epsilon(1e-12));
  CHECK(of_sheet.latent > 0.05 * of_sheet.in);
  CHECK(of_sheet.latent == Approx(of_slab.latent).epsilon(0.05));
  for (Index i = 2; i <= kCells[0]; ++i) {
    CAPTURE(i);
    CHECK(sheet.field.temperatures()[i] - kBodyTemperature ==
          Approx(slab.temperatures()[i] - kBodyTemperature).epsilon(0.05).margin(0.3));
  }
}

// Would catch heat that a removed triangle takes along uncounted, or that an undo brings in twice,
// and steam or blood that is left out.
TEST_CASE("sheet heat: the ledger closes through boiling, removal and undo", "[property]") {
  ThermalModel model;
  model.has_perfusion = true;
  model.surface_transfer = 20;
  model.ambient_temperature = 22;
  HeatedSheet sheet(testing::make_sheet({12, 12}, 1e-3, 0.2), model, tissues::liver().heat,
                    {.active_rise = 0.1, .tolerance = 1e-6});
  HeatField& field = sheet.field;
  const Index middle = 6 * 13 + 6;
  const auto burn = [&](double power) {
    for (int i = 0; i < 50; ++i) {
      field.step(5e-3, std::vector<HeatSource>{{middle, power}, {middle + 1, power}});
    }
    CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
  };
  burn(5);
  CHECK(field.has_boiled(middle));
  CHECK(field.ledger().latent > 0);
  CHECK(field.ledger().perfusion > 0);
  CHECK(field.active_vertices().size() < 13 * 13 + 1);
  const double mass = field.mesh().mass(middle);
  const auto around = sheet.tissue.triangles_at(middle);
  sheet.tissue.apply({.remove_triangles = {around[0], around[1]}});
  CHECK(field.mesh().mass(middle) < mass);
  CHECK(field.ledger().removed > 0);
  burn(2);
  sheet.tissue.undo();
  CHECK(field.mesh().mass(middle) == mass);
  burn(2);
  // parting: the copy is as warm
  TopologyEdit rip{.new_vertices = {{middle, middle, 0}}};
  rip.triangle_moves = {
      {sheet.tissue.triangles_at(middle)[0], middle, sheet.tissue.vertex_count()}};
  sheet.tissue.apply(rip);
  CHECK(field.temperatures().back() == field.temperatures()[middle]);
  burn(0);
  sheet.tissue.apply({.remove_bodies = {BodyId(0)}});
  CHECK(std::abs(field.ledger().sensible) < 1e-12 * field.ledger().in);
  burn(1);
}

// Would catch masses, faces or tissue of triangles that do not follow an edit, its undo, bodies
// that come and go, or the ids of before.
TEST_CASE("sheet heat: a mesh follows edits as one that is made anew", "[property]") {
  const SheetMesh mesh = testing::make_sheet({6, 5}, 2e-3, 0.2);
  Scene scene = scene_of(mesh);
  scene.add_body("block", testing::make_box({2, 2, 1}, 2e-3));
  Tissue tissue(scene);
  const std::array bodies{ThermalBody{0, plain()}, ThermalBody{1, tissues::liver().heat}};
  const ThermalMesh followed(tissue, bodies);
  const auto check_same = [&] {
    const ThermalMesh fresh(tissue, bodies);
    REQUIRE(followed.triangle_count() == fresh.triangle_count());
    CHECK(followed.sliver_count() == 0);
    for (Index v = 0; v < tissue.vertex_count(); ++v) {
      REQUIRE(followed.has_tissue(v) == fresh.has_tissue(v));
      REQUIRE(followed.mass(v) == fresh.mass(v));
      REQUIRE(followed.surface_share(v) == fresh.surface_share(v));
    }
    for (Index t = 0; t < fresh.triangle_count(); ++t) {
      const Index element = element_of_triangle(t);
      REQUIRE(followed.is_alive(element) == fresh.is_alive(element));
      REQUIRE(followed.edge_coefficients(element) == fresh.edge_coefficients(element));
    }
  };
  const Index middle = 2 * 7 + 3;
  TopologyEdit edit{.remove_triangles = {3, 4, 40}, .new_vertices = {{middle, middle, 0}}};
  edit.triangle_moves = {{tissue.triangles_at(middle)[1], middle, tissue.vertex_count()}};
  const std::uint64_t version = followed.version();
  tissue.apply(edit);
  CHECK(followed.version() != version);
  check_same();
  tissue.undo();
  CHECK(followed.version() == version);
  check_same();
  tissue.apply(edit);
  TopologyEdit growth;
  growth.new_bodies.add_sheet("disc", mesh.positions, mesh.triangles, {});
  tissue.apply(growth);
  check_same();
  tissue.undo();
  check_same();
}

// Would catch a region that differs from what the whole sheet gives, or tears from the rim.
TEST_CASE("sheet heat: the active part gives what the whole sheet gives", "[equivalence]") {
  const SheetMesh mesh = testing::make_sheet({30, 30}, 1e-3, 0.2);
  HeatedSheet part(mesh, conduction(), plain(), {.active_rise = 1e-3, .tolerance = 1e-10});
  HeatedSheet whole(mesh, conduction());
  const std::vector<HeatSource> sources{{15 * 31 + 15, 0.2}};
  for (int i = 0; i < 100; ++i) {
    part.field.step(0.02, sources);
    whole.field.step(0.02, sources);
  }
  CHECK(part.field.active_vertices().size() < mesh.positions.size());
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    REQUIRE(std::abs(part.field.temperatures()[v] - whole.field.temperatures()[v]) < 0.02);
  }
}

// Would catch another resistance than length / (sigma width thickness), at rest and stretched, heat
// that does not sum to it, and current through triangles that have gone.
TEST_CASE("sheet heat: current through a strip is that of the closed form", "[property]") {
  constexpr double kEdge = 1e-3, kSigma = 0.3, kLength = 12e-3, kWidth = 5e-3;
  const SheetMesh mesh = testing::make_sheet({12, 5}, kEdge, 0.2);
  HeatedSheet strip(mesh);
  PotentialField potential(strip.field.mesh(), {.tolerance = 1e-12, .most_iterations = 5000});
  std::vector<PatchVertex> patch;
  for (const Index v : strip.where([](const auto& x) { return x.x() < 0.1 * kEdge; })) {
    patch.push_back({v, 1});
  }
  potential.set_patch(patch, 1e-6);
  potential.set_ground(strip.where([](const auto& x) { return x.x() > 11.9e-3; }));
  ElementValues<double> conductivities;
  conductivities.resize(0, static_cast<Index>(mesh.triangles.size()), kSigma);
  const PotentialReport& report = potential.solve(conductivities);
  const double expected = kSigma * kThickness * kWidth / kLength;
  CHECK(report.conductance == Approx(expected).epsilon(1e-9));
  double vertex_heat = 0, element_heat = 0;
  for (const double watts : potential.vertex_heat()) {
    vertex_heat += watts;
  }
  for (const double watts : potential.element_heat()) {
    element_heat += watts;
  }
  CHECK(vertex_heat == Approx(report.conductance).epsilon(1e-12));
  CHECK(element_heat == Approx(report.conductance).epsilon(1e-12));
  for (std::size_t i = 0; i < potential.elements().size(); ++i) {
    CHECK(potential.element_heat()[i] ==
          Approx(kSigma * strip.field.mesh().volume(potential.elements()[i]) / (kLength * kLength))
              .epsilon(1e-6));
  }
  std::vector<Eigen::Vector3f> stretched;
  for (const Eigen::Vector3d& x : mesh.positions) {
    stretched.emplace_back(static_cast<float>(2 * x.x()), 0.0F, static_cast<float>(x.y()));
  }
  CHECK(potential.solve(conductivities, stretched).conductance ==
        Approx(expected / 2).epsilon(1e-5));
  TopologyEdit cut;
  for (Index t = 0; t < static_cast<Index>(mesh.triangles.size()); ++t) {
    const auto center =
        (mesh.positions[mesh.triangles[t][0]] + mesh.positions[mesh.triangles[t][1]] +
         mesh.positions[mesh.triangles[t][2]]) /
        3;
    if (center.x() > 5e-3 && center.x() < 6e-3) {
      cut.remove_triangles.push_back(t);
    }
  }
  strip.tissue.apply(cut);
  CHECK_FALSE(potential.solve(conductivities).is_closed);
  check_refused([&] { potential.solve({}); }, "conductivities of triangles has 0 entries");
  conductivities.triangles[0] = -1;
  check_refused([&] { potential.solve(conductivities); },
                "triangle 0 has an electrical conductivity");
}

}  // namespace pbdsurg
