// SPDX-License-Identifier: Apache-2.0
// A cautery whose edits are refused or undone, and one beside other edits.
#include <algorithm>
#include <optional>
#include <thread>
#include <vector>

#include "pbdsurg/surgery/cautery.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/heat_tissues.h"
#include "tests/support/refusing_follower.h"

namespace pbdsurg {
namespace {

using testing::CauteryBlock;
using testing::kFat;
using testing::kLiver;
using testing::kOnTop;
using testing::RefusingFollower;

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

// Would catch heat that reads where tissue is now, or that goes on with positions of then.
TEST_CASE("cautery: positions that were read are those of the next heat alone", "[unit]") {
  const CauteryBlock block;
  Solver moved(block.scene), still(block.scene);
  const ThermalBody body{0, kFat};
  Cautery ahead(moved.tissue(), std::span(&body, 1)), usual(still.tissue(), std::span(&body, 1));
  TopologyEdit edit;
  ahead.read_positions(moved);
  std::vector<Eigen::Vector3f> away = moved.positions();
  for (Eigen::Vector3f& x : away) {
    x.z() -= 1;
  }
  moved.write_positions(away);
  const CauteryReport report = ahead.heat(moved, kOnTop, cut_settings(30), 2e-3, edit);
  CHECK(report.energy > 0);
  CHECK(report.energy == usual.heat(still, kOnTop, cut_settings(30), 2e-3, edit).energy);
  CHECK(std::ranges::equal(ahead.field().temperatures(), usual.field().temperatures()));
  CHECK(ahead.heat(moved, kOnTop, cut_settings(30), 2e-3, edit).energy == 0);

  ahead.read_positions(moved);
  CHECK_THROWS_AS(ahead.heat(moved, kOnTop, cut_settings(30), 0, edit), InvalidArgument);
  moved.write_positions(still.positions());
  ahead.read_positions(moved);
  CHECK(ahead.heat(moved, kOnTop, cut_settings(30), 2e-3, edit).energy > 0);
  CHECK_THROWS_AS(ahead.read_positions(still), InvalidArgument);
}

// Would catch, under a thread sanitizer, heat that reads what a step writes; and bits that depend
// on which of the two is first.
TEST_CASE("cautery: heat runs beside a step", "[unit]") {
  const CauteryBlock block;
  const auto run = [&](bool beside) {
    Solver solver(block.scene, {.damping = 20, .executor = executor::serial()});
    const ThermalBody body{0, kFat};
    Cautery cautery(solver.tissue(), std::span(&body, 1));
    for (int i = 0; i < 100; ++i) {
      TopologyEdit edit;
      CauteryReport report;
      cautery.read_positions(solver);
      const auto heat = [&] {
        report = cautery.heat(solver, kOnTop, cut_settings(40), 5e-3, edit);
      };
      if (beside) {
        std::thread thread(heat);
        solver.step(5e-3F);
        thread.join();
      } else {
        solver.step(5e-3F);
        heat();
      }
      solver.tissue().apply(edit);
      cautery.commit(report);
    }
    CHECK(cautery.removal_energy() > 0);
    return solver.state_hash();
  };
  CHECK(run(true) == run(false));
}

// Would catch a limit that takes those that are due least, or that loses those that wait.
TEST_CASE("cautery: an edit shrinks the farthest behind first, up to a limit", "[unit]") {
  const CauteryBlock block;
  Scene scene;
  scene.add_body("fat", block.mesh, {.model = ElasticModel::neo_hookean});
  Solver solver(scene);
  const ThermalBody body{0, kFat};
  constexpr std::size_t kLimit = 5;
  Cautery all(solver.tissue(), std::span(&body, 1));
  Cautery some(solver.tissue(), std::span(&body, 1), {.shrink_limit = kLimit});
  TopologyEdit due, limited;
  for (int i = 0; i < 500 && due.rest_volumes.size() <= 2 * kLimit; ++i) {
    due = limited = {};
    all.heat(solver, kOnTop, cut_settings(40), 2e-3, due);
    some.heat(solver, kOnTop, cut_settings(40), 2e-3, limited);
  }
  REQUIRE(due.rest_volumes.size() > 2 * kLimit);
  REQUIRE(limited.rest_volumes.size() == kLimit);
  const auto share = [&](const RestVolumeChange& change) {
    return change.rest_volume / solver.rest_volume(change.tet);
  };
  std::ranges::sort(due.rest_volumes, {}, share);
  float last = 0;
  for (const RestVolumeChange& change : limited.rest_volumes) {
    last = std::max(last, share(change));
  }
  CHECK(last == share(due.rest_volumes[kLimit - 1]));

  const auto rest = [&] {
    limited = {};
    CauteryReport report = some.heat(solver, kOnTop, std::nullopt, 1e-6, limited);
    solver.tissue().apply(limited);
    some.commit(report);
    return limited.rest_volumes.size();
  };
  std::size_t edits = 0;
  for (std::size_t count = rest(); count > 0; count = rest()) {
    CHECK(count <= kLimit);
    ++edits;
  }
  CHECK(edits >= due.rest_volumes.size() / kLimit);
}

}  // namespace pbdsurg
