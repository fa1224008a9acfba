// SPDX-License-Identifier: Apache-2.0
// A cautery whose edits are refused or undone, and one beside other edits.
#include <optional>
#include <vector>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/refusing_follower.h"

namespace pbdsurg {
namespace {

using testing::CauteryBlock;
using testing::kOnTop;
using testing::RefusingFollower;

const ThermalProperties& kLiver = tissues::liver().heat;
const ThermalProperties& kFat = tissues::fat().heat;

}  // namespace

// Would catch tissue that steam tore and that is forgotten, as it no longer boils so fast, where
// the edit was refused or undone.
TEST_CASE("cautery: torn tissue goes once it may, after a refusal and after an undo", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene, {.damping = 20});
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.tearing_rate = 0.1, .tearing_loss = 0.01});
  RefusingFollower refusing;
  solver.tissue().add_follower(refusing);
  bool was_refused = false;
  for (int i = 0; i < 300 && !was_refused; ++i) {
    try {
      cautery.update(solver, kOnTop, cut_settings(40), 5e-3);
    } catch (const InvalidArgument&) {
      was_refused = !refusing.refused.remove_tets.empty();
    }
  }
  REQUIRE(was_refused);
  refusing.refuses = false;
  const auto rest = [&] { return cautery.update(solver, kOnTop, std::nullopt, 1e-3); };
  CauteryReport report = rest();
  CHECK(report.torn > 0);
  CHECK(report.edit.edit.remove_tets == refusing.refused.remove_tets);
  const double paid = cautery.removal_energy();

  solver.tissue().undo();
  CHECK(cautery.removal_energy() == 0);
  CHECK(rest().edit.edit.remove_tets == refusing.refused.remove_tets);
  CHECK(cautery.removal_energy() == paid);
}

TEST_CASE("cautery: it follows edits made before and beside it", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
  const ThermalBody body{0, kFat};
  TopologyEdit half, rest;
  for (Index t = 0; t < block.mesh.tet_count(); ++t) {
    (t % 2 == 0 ? half : rest).remove_tets.push_back(t);
  }
  solver.tissue().apply(half);
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  CHECK(cautery.field().ledger().removed == 0);
  solver.tissue().apply(rest);

  CHECK(cautery.update(solver, kOnTop, cut_settings(30), 0.01).energy == 0);
}

// Would catch tables of rest values and doses that grow or stay behind, fields left out, and a
// budget that counts what came back.
TEST_CASE("cautery: it goes back with an undo", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene, {.damping = 20});
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  CauteryReport report;
  double paid = 0;
  while (report.edit.removed_tets.empty()) {
    paid = cautery.removal_energy();
    report = cautery.update(solver, kOnTop, cut_settings(40), 5e-3);
    CHECK(report.edit.edit.remove_tets == report.edit.removed_tets);
  }
  CHECK(cautery.removal_energy() > paid);
  solver.tissue().undo();
  CHECK(cautery.removal_energy() == paid);

  const HeatLedger before = cautery.field().ledger();
  std::vector<double> capacities;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    capacities.push_back(cautery.field().capacity(v));
  }
  TopologyEdit edit;
  for (Index t = 0; t < block.mesh.tet_count(); t += 3) {
    edit.remove_tets.push_back(t);
  }
  solver.tissue().apply(edit);
  CHECK(cautery.field().ledger().removed > before.removed);
  solver.tissue().undo();

  CHECK(cautery.field().ledger().removed == before.removed);
  CHECK(cautery.field().ledger().sensible == before.sensible);
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    REQUIRE(cautery.field().capacity(v) == capacities[v]);
  }
}

}  // namespace pbdsurg
