// SPDX-License-Identifier: Apache-2.0
// Everything that follows topology, through the same edits: cuts, burns, strands that part, undo.
#include <algorithm>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/surgery/cut.h"

#include "tests/support/catch.h"
#include "tests/support/slabs.h"

namespace pbdsurg {
namespace {

using testing::check_views;
using testing::kSlabTimeStep;
using testing::random_cut;
using testing::shown_by;
using testing::Slabs;
using testing::World;

void check_heat(const World& world, double energy_before) {
  const HeatField& field = world.cautery.field();
  REQUIRE(std::ranges::all_of(field.temperatures(), [](double t) { return t > 0 && t < 101; }));
  const HeatLedger& ledger = field.ledger();
  const double energy = ledger.sensible + ledger.latent + ledger.removed;
  REQUIRE(energy == testing::Approx(energy_before).epsilon(1e-9).margin(1e-12));
}

}  // namespace

// Would catch a holder of topology that misreads a cut: what it holds would differ from what is
// found afresh, or energy would come from nowhere; and tissue that bursts when it is cut.
TEST_CASE("transaction: all that follows topology follows cuts", "[property]") {
  const Slabs slabs;
  World world(slabs);
  Index divided = 0;
  for (Index round = 0; round < 12; ++round) {
    world.burn_and_tear({6e-3F, 6e-3F, 4.2e-3F});
    const HeatLedger before = world.cautery.field().ledger();
    const CutOptions options{.style =
                                 round % 3 == 2 ? CutStyle::along_faces : CutStyle::through_tets};
    const TopologyEdit cut = plan_cut(world.solver, random_cut(1, round), options).edit;
    divided += static_cast<Index>(world.solver.tissue().apply(cut).removed_tets.size());
    check_views(world);
    check_heat(world, before.sensible + before.latent + before.removed);
    REQUIRE(world.solver.step(kSlabTimeStep).non_finite_vertices == 0);
  }
  CHECK(divided > 100);
  CHECK(world.pieces.count() > 2);
}

// Would catch anything that an undo leaves behind anywhere: the world that tried edits and took
// them back would sooner or later differ from the one that never did.
TEST_CASE("transaction: a world that takes edits back goes on as one that never made them",
          "[property]") {
  const Slabs slabs;
  World tries(slabs), goes_on(slabs);
  for (Index round = 0; round < 40; ++round) {
    const Eigen::Vector3f tip(6e-3F, 6e-3F, 4.2e-3F + 1e-5F * static_cast<float>(round));
    tries.burn_and_tear(tip);
    goes_on.burn_and_tear(tip);
    TopologyEdit edit;
    if (round % 2 == 0) {
      edit = plan_cut(tries.solver, random_cut(2, round)).edit;
    } else {
      for (Index t = 0; t < static_cast<Index>(tries.solver.tissue().tets().size()); ++t) {
        if (tries.solver.tissue().is_tet_alive(t) && random_unit(5, t, round) < 0.02) {
          edit.remove_tets.push_back(t);
        }
      }
      for (Index l = 0; l < static_cast<Index>(tries.solver.tissue().links().size()); ++l) {
        if (tries.solver.tissue().is_link_alive(l) && random_unit(6, l, round) < 0.02) {
          edit.remove_links.push_back(l);
        }
      }
    }
    tries.solver.tissue().apply(edit);
    tries.solver.tissue().undo();
    tries.solver.step(kSlabTimeStep);
    goes_on.solver.step(kSlabTimeStep);
    REQUIRE(tries.solver.state_hash() == goes_on.solver.state_hash());
    REQUIRE(tries.strands.whole_count() == goes_on.strands.whole_count());
    REQUIRE(tries.cautery.field().ledger().sensible == goes_on.cautery.field().ledger().sensible);
    REQUIRE(tries.cautery.field().ledger().removed == goes_on.cautery.field().ledger().removed);
    for (Index body = 0; body < 2; ++body) {
      REQUIRE(shown_by(tries.surfaces[body]) == shown_by(goes_on.surfaces[body]));
    }
    REQUIRE(tries.pieces.count() == goes_on.pieces.count());
  }
  CHECK(goes_on.strands.whole_count() < static_cast<Index>(slabs.strands.strands().size()));
}

// Would catch ids that are read as those of another topology.
TEST_CASE("transaction: who does not follow the tissue is refused", "[unit]") {
  const Slabs slabs;
  World world(slabs), other(slabs);
  const Electrode middle{{6e-3F, 6e-3F, 4.2e-3F}, {6e-3F, 6e-3F, 4.2e-3F}};
  const auto refuse = [&](auto call) {
    CHECK_THROWS_WITH(call(), testing::ContainsSubstring("does not follow this tissue"));
  };
  refuse([&] { other.cautery.update(world.solver, middle, cut_settings(8), kSlabTimeStep); });
  refuse([&] { other.strands.separate(world.solver); });
  ConnectiveTissue copy = world.strands;
  refuse([&] { copy.separate(world.solver); });
  TopologyEdit edit{.remove_tets = {0}};
  refuse([&] { other.pieces.add_crumbs(world.solver.tissue(), edit, 1); });
  CHECK(other.cautery.field().ledger().in == 0);
  CHECK(world.solver.tissue().version() == 0);

  HeatField field = world.cautery.field();  // a copy, too
  field.step(kSlabTimeStep, {});
  world.solver.tissue().apply(edit);
  CHECK_THROWS_WITH(field.step(kSlabTimeStep, {}),
                    testing::ContainsSubstring("is at topology version"));
  world.cautery.update(world.solver, middle, cut_settings(8), kSlabTimeStep);
  world.strands.separate(world.solver);
}

}  // namespace pbdsurg
