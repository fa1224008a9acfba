// SPDX-License-Identifier: Apache-2.0
// Sheets that shrink where they lose water and collagen.
#include <algorithm>
#include <optional>
#include <span>

#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

constexpr double kHeatedEdge = 1e-3;  // m
constexpr Index kCells = 16;

ThermalProperties contracting() {
  ThermalProperties membrane = tissues::membrane().heat;
  membrane.collagen_contraction = 0.3;
  return membrane;
}

// A sheet that a hook heats in the middle.
struct Heated {
  explicit Heated(Index limit = 0)
      : solver(scene(), {.damping = 20}),
        cautery(solver.tissue(), std::span(&body, 1), {.shrink_limit = limit}) {}

  static Scene scene() {
    const testing::SheetMesh mesh = testing::make_sheet({kCells, kCells}, kHeatedEdge, 0.1);
    Scene scene;
    scene.add_sheet("sheet", mesh.positions, mesh.triangles, {.damping = 1e-3F});
    scene.set_gravity({0, 0, 0});
    scene.fix_where(0, [](const Eigen::Vector3d& x) {
      return x.x() < 0.5 * kHeatedEdge || x.x() > (kCells - 0.5) * kHeatedEdge;
    });
    return scene;
  }

  CauteryReport update(const std::optional<GeneratorSettings>& generator, double dt = 5e-3) {
    const CauteryReport report = cautery.update(solver, tip, generator, dt);
    CHECK(report.edit.edit.rest_volumes.empty());
    most = std::max(most, static_cast<Index>(report.edit.edit.rest_areas.size()));
    testing::check_ledger(cautery);
    return report;
  }

  // m^2, by the law of shrinkage, of a triangle whose area was that of the mesh.
  [[nodiscard]] double expected_area(Index triangle) const {
    const HeatField& field = cautery.field();
    const Triangle& corners = solver.tissue().triangles()[static_cast<std::size_t>(triangle)];
    double length = 0;
    for (std::size_t i = 0; i < 3; ++i) {
      const auto a = static_cast<std::size_t>(corners[i]);
      const auto b = static_cast<std::size_t>(corners[(i + 1) % 3]);
      length += shrunk_length(body.properties, (field.water()[a] + field.water()[b]) / 2,
                              (field.collagen()[a] + field.collagen()[b]) / 2) /
                3;
    }
    return whole_area(triangle) * length * length;
  }

  [[nodiscard]] double whole_area(Index triangle) const {
    const auto x = solver.tissue().rest_positions();
    const auto& [a, b, c] = solver.tissue().triangles()[static_cast<std::size_t>(triangle)];
    return (x[b] - x[a]).cross(x[c] - x[a]).norm() / 2;
  }

  const ThermalBody body{0, contracting()};
  const Electrode tip = testing::point({8e-3F, 8e-3F, 0.2e-3F});
  Solver solver;
  Cautery cautery;
  Index most = 0;
};

}  // namespace

// Would catch triangles that keep their area, or shrink by another law than solids do; edits that
// are too small to matter; and a limit that does not count triangles, or forgets what waits.
TEST_CASE("sheet shrinking: triangles are as large as water and collagen say", "[unit]") {
  const Index limit = GENERATE(0, 3);
  Heated sheet(limit);
  for (int i = 0; i < 100; ++i) {
    sheet.update(coagulate_settings(25));
  }
  for (int i = 0; i < 2000; ++i) {
    if (sheet.update(std::nullopt).edit.edit.rest_areas.empty()) {
      break;
    }
  }
  CHECK((limit == 0 ? sheet.most > 3 : sheet.most == 3));
  constexpr double kRounding = 1e-4;
  Index shrunk = 0, untouched = 0;
  for (Index t = 0; t < static_cast<Index>(sheet.solver.tissue().triangles().size()); ++t) {
    if (!sheet.solver.tissue().is_triangle_alive(t)) {
      continue;
    }
    CAPTURE(t);
    const double now = sheet.solver.rest_area(t), expected = sheet.expected_area(t);
    CHECK(now >= (1 - kRounding) * expected);
    CHECK(0.99 * now <= (1 + kRounding) * expected);
    shrunk += now < 0.7 * sheet.whole_area(t) ? 1 : 0;
    untouched += now > (1 - kRounding) * sheet.whole_area(t) ? 1 : 0;
  }
  CHECK(shrunk > 4);
  CHECK(untouched > 10);
}

// Would catch rest areas that a solver does not pull towards.
TEST_CASE("sheet shrinking: what shrinks draws in what is around it", "[unit]") {
  Heated sheet;
  constexpr Index kBeside = kCells / 2 + 4 + (kCells + 1) * (kCells / 2);
  const float before = sheet.solver.positions()[static_cast<std::size_t>(kBeside)].x();
  for (int i = 0; i < 100; ++i) {
    sheet.update(coagulate_settings(25));
    sheet.solver.step(5e-3F);
  }
  CHECK(sheet.solver.tissue().triangles_at(kBeside).size() > 2);
  CHECK(sheet.solver.positions()[static_cast<std::size_t>(kBeside)].x() < before - 1e-4F);
}

// Would catch a cautery that remembers what an undo took back.
TEST_CASE("sheet shrinking: what is undone is asked for again", "[unit]") {
  Heated sheet;
  CauteryReport report;
  for (int i = 0; i < 200 && report.edit.edit.rest_areas.empty(); ++i) {
    report = sheet.update(coagulate_settings(25));
  }
  REQUIRE_FALSE(report.edit.edit.rest_areas.empty());
  const RestAreaChange change = report.edit.edit.rest_areas.front();
  const float after = sheet.solver.rest_area(change.triangle);
  CHECK(after == testing::Approx(change.rest_area));
  sheet.solver.tissue().undo();
  CHECK(sheet.solver.rest_area(change.triangle) > 1.005F * after);
  sheet.update(std::nullopt, 1e-6);
  CHECK(sheet.solver.rest_area(change.triangle) <= 1.0001F * after);
}

}  // namespace pbdsurg
