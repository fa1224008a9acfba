// SPDX-License-Identifier: Apache-2.0
// Tissue that stiffens where it coagulates.
#include <algorithm>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

using testing::CauteryBlock;
using testing::kOnTop;

constexpr float kStiffness = 7, kStep = 1.1F;  // times as stiff

ThermalProperties stiffening(double factor) {
  ThermalProperties liver = tissues::liver().heat;
  liver.coagulated_stiffness = factor;
  return liver;
}

// A block in which a hook coagulates for half a second.
struct Coagulated {
  explicit Coagulated(double factor, Index limit = 0, float before = 1,
                      const Material& material = tissues::liver().mechanics)
      : solver(scene(before, material), {.damping = 20}),
        body{0, stiffening(factor)},
        cautery(solver.tissue(), std::span(&body, 1), {.shrink_limit = limit}) {
    for (int i = 0; i < 100; ++i) {
      const CauteryReport report = cautery.update(solver, kOnTop, coagulate_settings(25), 5e-3);
      const auto count = static_cast<Index>(report.edit.edit.stiffnesses.size());
      most_changes = std::max(most_changes, count);
      changes += count;
    }
  }

  static Scene scene(float before, const Material& material) {
    Scene scene;
    scene.add_body("block", CauteryBlock().mesh, material);
    if (before != 1) {
      scene.set_stiffnesses(0, std::vector<float>(scene.tets().size(), before));
    }
    return scene;
  }

  [[nodiscard]] double survival(Index tet) const {
    double sum = 0;
    for (const Index v : solver.tissue().tets()[static_cast<std::size_t>(tet)]) {
      sum += cautery.field().survival()[static_cast<std::size_t>(v)] / 4;
    }
    return sum;
  }

  Solver solver;
  ThermalBody body;
  Cautery cautery;
  Index most_changes = 0, changes = 0;
};

}  // namespace

// Would catch a factor that is taken twice, of what is stiff already, and a law other than the
// documented one; and edits that are too small to matter.
TEST_CASE("stiffening: tissue is as stiff as what of it has coagulated says", "[unit]") {
  Coagulated block(double{kStiffness});
  const Tissue& tissue = block.solver.tissue();
  Index coagulated = 0, untouched = 0;
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (!tissue.is_tet_alive(t)) {
      continue;
    }
    const auto expected = static_cast<float>(stiffened(block.body.properties, block.survival(t)));
    CAPTURE(t, expected);
    CHECK(tissue.stiffness(t) <= expected);
    CHECK(tissue.stiffness(t) * kStep > expected);
    coagulated += tissue.stiffness(t) > 0.9F * kStiffness ? 1 : 0;
    untouched += tissue.stiffness(t) == 1 ? 1 : 0;
  }
  CHECK(coagulated > 10);
  CHECK(untouched > 10);
  CHECK(block.changes < 22 * static_cast<Index>(tissue.tets().size()));  // 1.1^21 > 7
}

// Would catch scar or tumour that heat softens.
TEST_CASE("stiffening: what was stiffer stays as it is, and what stiffens by nothing, and springs",
          "[unit]") {
  CHECK(Coagulated(double{kStiffness}, 0, 8).changes == 0);
  CHECK(Coagulated(1).changes == 0);
  const Material soft = springs(CauteryBlock().mesh, tissues::liver().mechanics);
  CHECK(Coagulated(double{kStiffness}, 0, 1, soft).changes == 0);
}

// Would catch an edit that costs more than was asked for, and what waits and is forgotten.
TEST_CASE("stiffening: no more tetrahedra stiffen in an update than the limit", "[unit]") {
  Coagulated block(double{kStiffness}, 3);
  CHECK(block.most_changes == 3);
  Index waiting = 0;
  do {
    const CauteryReport report = block.cautery.update(block.solver, kOnTop, std::nullopt, 1e-3);
    waiting = static_cast<Index>(report.edit.edit.stiffnesses.size());
    CHECK(waiting <= 3);
  } while (waiting > 0);
  const Tissue& tissue = block.solver.tissue();
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (tissue.is_tet_alive(t)) {
      CHECK(tissue.stiffness(t) * kStep >
            static_cast<float>(stiffened(block.body.properties, block.survival(t))));
    }
  }
}

// Would catch sheets that stay as soft as they were, another law than that of solids, and elements
// of one kind that a limit does not count.
TEST_CASE("stiffening: a sheet is as stiff as what of it has coagulated says", "[unit]") {
  const Index limit = GENERATE(0, 3);
  const testing::SheetMesh mesh = testing::make_sheet({16, 16}, 1e-3, 0.1);
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles, {.damping = 1e-3F});
  std::vector<float> factors(mesh.triangles.size(), 1);
  constexpr Index kScar = 16 * 16 + 16;  // in the middle
  factors[kScar] = 10;
  scene.set_stiffnesses(0, factors);
  scene.set_gravity({0, 0, 0});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5e-3 || x.x() > 15.5e-3; });
  Solver solver(scene, {.damping = 20});
  const ThermalBody body{0, stiffening(double{kStiffness})};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.shrink_limit = limit});
  const Electrode tip = testing::point({8e-3F, 8e-3F, 0.2e-3F});
  Index most = 0, last = 0;
  const auto update = [&](const std::optional<GeneratorSettings>& generator) {
    const CauteryReport report = cautery.update(solver, tip, generator, 5e-3);
    CHECK(report.edit.edit.stiffnesses.empty());
    last = static_cast<Index>(report.edit.edit.triangle_stiffnesses.size());
    most = std::max(most, last);
  };
  for (int i = 0; i < 100; ++i) {
    update(coagulate_settings(25));
  }
  for (int i = 0; i < 2000 && (i == 0 || last > 0); ++i) {
    update(std::nullopt);
  }
  CHECK((limit == 0 ? most > 3 : most == 3));
  const Tissue& tissue = solver.tissue();
  Index coagulated = 0, untouched = 0;
  for (Index t = 0; t < static_cast<Index>(tissue.triangles().size()); ++t) {
    if (!tissue.is_triangle_alive(t)) {
      continue;
    }
    double survival = 0;
    for (const Index v : tissue.triangles()[static_cast<std::size_t>(t)]) {
      survival += cautery.field().survival()[static_cast<std::size_t>(v)] / 3;
    }
    const auto expected = static_cast<float>(stiffened(body.properties, survival));
    CAPTURE(t, expected);
    if (t == kScar) {
      CHECK(tissue.triangle_stiffness(t) == 10);
      continue;
    }
    CHECK(tissue.triangle_stiffness(t) <= expected);
    CHECK(tissue.triangle_stiffness(t) * kStep > expected);
    coagulated += tissue.triangle_stiffness(t) > 0.9F * kStiffness ? 1 : 0;
    untouched += tissue.triangle_stiffness(t) == 1 ? 1 : 0;
  }
  CHECK(coagulated > 10);
  CHECK(untouched > 10);
}

// Would catch a cautery that remembers what an undo took back.
TEST_CASE("stiffening: what is undone is asked for again", "[unit]") {
  Coagulated block(double{kStiffness});
  CauteryReport report;
  for (int i = 0; i < 100 && report.edit.edit.stiffnesses.empty(); ++i) {
    report = block.cautery.update(block.solver, kOnTop, coagulate_settings(25), 5e-3);
  }
  REQUIRE_FALSE(report.edit.edit.stiffnesses.empty());
  const StiffnessChange change = report.edit.edit.stiffnesses.front();
  CHECK(block.solver.tissue().stiffness(change.tet) == change.factor);
  block.solver.tissue().undo();
  CHECK(block.solver.tissue().stiffness(change.tet) < change.factor);
  block.cautery.update(block.solver, kOnTop, std::nullopt, 1e-6);
  CHECK(block.solver.tissue().stiffness(change.tet) >= change.factor);
}

}  // namespace pbdsurg
