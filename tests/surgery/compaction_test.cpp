// SPDX-License-Identifier: Apache-2.0
// Everything that follows topology goes along with a compaction.
#include "pbdsurg/solver/compaction.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/surgery/cut.h"

#include "tests/support/catch.h"
#include "tests/support/slabs.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_views;
using testing::ContainsSubstring;
using testing::kSlabTimeStep;
using testing::Slabs;
using testing::World;

const SolverOptions kSerial = testing::small_steps({.damping = 20, .executor = executor::serial()});

// Whatever a linear solver starts from, it ends at the same.
const CauteryOptions kPrecise{
    .electrode_cooling = 0,
    .link_energy = 0.05,
    .heat = {.tolerance = 1e-12},
    .potential = {.region_radii = 6, .tolerance = 1e-11, .most_iterations = 2000}};

Renumbering compact(World& world) {
  Compaction compaction(world.solver);
  compaction.build();
  return compaction.finish(world.solver);
}

// Lies on the lower slab, among the strands, askew.
CauteryReport burn(World& world, float x, double power) {
  const Electrode electrode{{x, 3.7e-3F, 4.2e-3F}, {x + 0.3e-3F, 7.6e-3F, 4.25e-3F}};
  return world.cautery.update(world.solver, electrode, cut_settings(power), 20e-3);
}

// Burns, cuts, growth, a body that comes in and goes, and strands that part.
void work_on(World& world) {
  for (Index round = 0; round < 6; ++round) {
    // long enough to dry some tissue before the first cut may leave it without a way to ground
    for (int i = 0; i < (round == 0 ? 60 : 15); ++i) {
      burn(world, 6e-3F, 150);
    }
    world.strands.separate(world.solver);
    const CutOptions options{.style =
                                 round % 3 == 2 ? CutStyle::along_faces : CutStyle::through_tets};
    world.solver.tissue().apply(
        plan_cut(world.solver, testing::random_cut(3, round), options).edit);
    if (round == 2) {
      Scene guest;
      guest.add_body("guest", testing::make_box({2, 2, 2}, testing::kSlabEdge), testing::kSprings);
      world.solver.tissue().apply({.new_bodies = guest});
    }
    world.solver.step(kSlabTimeStep);
  }
  const auto guest = static_cast<Index>(world.solver.tissue().bodies().size()) - 1;
  world.solver.tissue().apply({.remove_bodies = {guest}});
}

std::vector<Index> renumbered(std::vector<Index> list, const std::vector<Index>& ids) {
  std::ranges::transform(list, list.begin(), [&](Index i) { return ids[i]; });
  std::ranges::sort(list);
  return list;
}

// An edit of removals and growth in other ids.
TopologyEdit renumbered(TopologyEdit edit, const Renumbering& ids) {
  edit.remove_tets = renumbered(edit.remove_tets, ids.tets);
  edit.remove_links = renumbered(edit.remove_links, ids.links);
  for (NewVertex& added : edit.new_vertices) {
    added.first = ids.vertices[added.first];
    added.second = ids.vertices[added.second];
  }
  for (CornerMove& move : edit.corner_moves) {
    move = {ids.tets[move.tet], ids.vertices[move.from], ids.vertices[move.to]};
  }
  for (LinkMove& move : edit.link_moves) {
    move = {ids.links[move.link], ids.vertices[move.from], ids.vertices[move.to]};
  }
  for (NewTet& added : edit.new_tets) {
    added.parent = ids.tets[added.parent];
    for (Index& v : added.vertices) {
      v = ids.vertices[v];
    }
  }
  return edit;
}

// What an edit is about to bring, in the same order on both sides.
void extend(Renumbering& ids, const Solver& now, const TopologyEdit& edit) {
  for (std::size_t i = 0; i < edit.new_vertices.size(); ++i) {
    ids.vertices.push_back(now.vertex_count() + static_cast<Index>(i));
  }
  for (std::size_t i = 0; i < edit.new_tets.size(); ++i) {
    ids.tets.push_back(static_cast<Index>(now.tissue().tets().size() + i));
  }
}

// How much two fields differ at most, where there is tissue: 0 if not at all.
double difference(const HeatField& before, const HeatField& now, const Renumbering& ids) {
  double most = 0;
  const auto compare = [&](std::span<const double> a, std::span<const double> b) {
    for (std::size_t v = 0; v < a.size(); ++v) {
      if (ids.vertices[v] != kInvalidIndex) {
        most = std::max(most, std::abs(a[v] - b[ids.vertices[v]]));
      }
    }
  };
  compare(before.temperatures(), now.temperatures());
  compare(before.peak_temperatures(), now.peak_temperatures());
  compare(before.water(), now.water());
  compare(before.survival(), now.survival());
  compare(before.collagen(), now.collagen());
  compare(before.charred(), now.charred());
  return most;
}

void check_ledger(const Cautery& before, const Cautery& now, double tolerance) {
  const HeatLedger &a = before.field().ledger(), &b = now.field().ledger();
  for (const auto& [was, is] : {std::pair(a.in, b.in),
                                {a.sensible, b.sensible},
                                {a.latent, b.latent},
                                {a.removed, b.removed},
                                {a.surface, b.surface},
                                {a.perfusion, b.perfusion},
                                {before.link_energy_spent(), now.link_energy_spent()},
                                {before.electrode_energy(), now.electrode_energy()},
                                {before.removal_energy(), now.removal_energy()}}) {
    REQUIRE(std::abs(is - was) <= tolerance * a.in);
  }
}

// Ids of all that lives, slots and pieces, and the geometry of heat.
void check_same_tissue(const World& before, const World& now, const Renumbering& ids) {
  const ThermalMesh &a = before.cautery.field().mesh(), &b = now.cautery.field().mesh();
  REQUIRE(b.vertex_count() == now.solver.vertex_count());
  REQUIRE(b.tet_count() == static_cast<Index>(now.solver.tissue().tets().size()));
  Index wrong = 0;
  for (Index v = 0; v < a.vertex_count(); ++v) {
    const Index id = ids.vertices[v];
    if (id == kInvalidIndex) {
      wrong += a.has_tissue(v);
      continue;
    }
    wrong += a.rest_positions()[v] != b.rest_positions()[id];
    wrong += a.tissue_of_vertex(v) != b.tissue_of_vertex(id);
    wrong += a.mass(v) != b.mass(id);
    wrong += a.surface_share(v) != b.surface_share(id);
    wrong += std::abs(before.cautery.field().capacity(v) / now.cautery.field().capacity(id) - 1) >
             1e-8;  // but of particles, which have none
  }
  for (Index t = 0; t < a.tet_count(); ++t) {
    const Index id = ids.tets[t];
    if (id == kInvalidIndex) {
      wrong += a.is_alive(t);
      continue;
    }
    wrong += a.is_alive(t) != b.is_alive(id) || a.tissue_of_element(t) != b.tissue_of_element(id);
    wrong += a.volume(t) != b.volume(id) || a.edge_coefficients(t) != b.edge_coefficients(id);
    wrong += before.cautery.state(t) != now.cautery.state(id);
  }
  REQUIRE(wrong == 0);
  for (std::size_t s = 0; s < 2; ++s) {
    const LiveSurface &was = before.surfaces[s], &is = now.surfaces[s];
    REQUIRE(was.slot_count() == is.slot_count());
    for (Index slot = 0; slot < was.slot_count(); ++slot) {
      const TetFace from = was.origins()[slot], to = is.origins()[slot];
      wrong += from.tet == kInvalidIndex ? to.tet != kInvalidIndex : ids.tets[from.tet] != to.tet;
      wrong += from.face != to.face;
    }
  }
  REQUIRE(wrong == 0);
}

// Pieces with ids below `end`. Of those that one edit freed from several bodies, the order follows
// the ids of tetrahedra, which is another where bodies had grown.
void check_same_pieces(const World& before, const World& now, const Renumbering& ids, Index end) {
  REQUIRE(before.pieces.count() == now.pieces.count());
  for (Index piece = 0; piece < end; ++piece) {
    REQUIRE(before.pieces.is_anchored(piece) == now.pieces.is_anchored(piece));
    REQUIRE(renumbered(before.pieces.tets(piece), ids.tets) == now.pieces.tets(piece));
  }
}

}  // namespace

// Would catch any heat, water, dose or due tissue that is lost or goes to others; slots and pieces
// that an application would no longer find; and growth, removal, parting links or undo that go
// wrong from then on.
TEST_CASE("compaction: heat goes on as it would have", "[property]") {
  const Slabs slabs;
  // of tetrahedra that share all that has boiled, rounding would choose which is torn first
  CauteryOptions burning = kPrecise;
  burning.tearing_rate = 1e3;
  burning.model.dry_water = 0.9;
  World world(slabs, kSerial, burning), unchanged(slabs, kSerial, burning);
  work_on(world);
  work_on(unchanged);
  const Index room = world.solver.vertex_count();
  Renumbering ids = compact(world);
  CHECK(world.solver.vertex_count() < room);
  CHECK(difference(unchanged.cautery.field(), world.cautery.field(), ids) == 0);
  check_ledger(unchanged.cautery, world.cautery, 0);
  check_same_tissue(unchanged, world, ids);
  const Index pieces = world.pieces.count();
  check_same_pieces(unchanged, world, ids, pieces);
  REQUIRE(unchanged.cautery.field().ledger().removed > 0);
  REQUIRE(unchanged.cautery.link_energy_spent() > 0);

  // nothing moves, so that what differs is not how steps are rounded
  Index removed = 0, parted = 0, resolved = 0;
  for (Index round = 0; round < 12; ++round) {
    const TopologyEdit cut =
        plan_cut(unchanged.solver, testing::random_cut(4, round),
                 {.style = round % 2 == 0 ? CutStyle::along_faces : CutStyle::through_tets})
            .edit;
    extend(ids, world.solver, cut);
    const TopologyEdit same = renumbered(cut, ids);
    unchanged.solver.tissue().apply(cut);
    world.solver.tissue().apply(same);
    world.solver.tissue().undo();
    world.solver.tissue().apply(same);

    const float x = 3e-3F + 0.05e-3F * static_cast<float>(round);
    for (int i = 0; i < 6; ++i) {
      const CauteryReport expected = burn(unchanged, x, 150), report = burn(world, x, 150);
      resolved += report.is_disk ? 0 : 1;
      REQUIRE(report.power == Approx(expected.power).epsilon(1e-8));
      REQUIRE(report.deferred == expected.deferred);
      REQUIRE(report.edit.edit.remove_tets == renumbered(expected.edit.edit.remove_tets, ids.tets));
      REQUIRE(report.edit.edit.remove_links ==
              renumbered(expected.edit.edit.remove_links, ids.links));
      removed += static_cast<Index>(report.edit.edit.remove_tets.size());
      parted += static_cast<Index>(report.edit.edit.remove_links.size());
    }
    REQUIRE(difference(unchanged.cautery.field(), world.cautery.field(), ids) < 1e-6);
    check_ledger(unchanged.cautery, world.cautery, 1e-9);
    check_same_tissue(unchanged, world, ids);
    check_same_pieces(unchanged, world, ids, pieces);
    check_views(world);
  }
  CHECK(removed > 5);
  CHECK(parted > 3);
  CHECK(resolved > 3);
}

// Would catch heat that depends on when dead ids are thrown away, through many compactions and
// steps that move tissue. What steam tears is chaotic: power changed by 1e-13 moves what boils by
// 2 %, without any compaction, and other roundings have moved it by 5; where sparks start and end,
// what comes in moves along.
TEST_CASE("compaction: a burn with compactions is the burn without", "[validation]") {
  const Slabs slabs(testing::kSprings);
  World world(slabs, kSerial, kPrecise), unchanged(slabs, kSerial, kPrecise);
  for (Index round = 0; round < 60; ++round) {
    for (World* each : {&world, &unchanged}) {
      burn(*each, 5e-3F + 0.02e-3F * static_cast<float>(round), 80);
      REQUIRE(each->solver.step(kSlabTimeStep).non_finite_vertices == 0);
    }
    if (round % 10 == 9) {
      compact(world);
    }
  }
  const HeatLedger &ledger = world.cautery.field().ledger(),
                   &expected = unchanged.cautery.field().ledger();
  REQUIRE(expected.removed > 0);
  CHECK(ledger.in == Approx(expected.in).epsilon(0.05));
  CHECK(ledger.latent + ledger.removed == Approx(expected.latent + expected.removed).epsilon(0.1));
  CHECK(ledger.sensible + ledger.latent + ledger.removed == Approx(ledger.in).epsilon(1e-9));
  CHECK(world.cautery.removal_energy() == Approx(unchanged.cautery.removal_energy()).epsilon(0.1));
}

// Would catch ids of one numbering read as those of another, and anything that is changed before it
// is refused.
TEST_CASE("compaction: one that cannot be finished is refused, and all stays as it was", "[unit]") {
  const Slabs slabs;
  World world(slabs, kSerial), other(slabs, kSerial), witness(slabs, kSerial);
  for (World* each : {&world, &other, &witness}) {
    for (int i = 0; i < 10; ++i) {
      burn(*each, 6e-3F, 8);
    }
    TopologyEdit edit{.remove_tets = {0, 1}};
    if (each == &other) {
      edit.remove_tets = {2, 3};  // as many, elsewhere
    }
    each->solver.tissue().apply(edit);
  }
  REQUIRE(world.solver.tissue().version() == other.solver.tissue().version());
  Compaction elsewhere(other.solver);
  elsewhere.build();
  CHECK_THROWS_AS(elsewhere.finish(world.solver), InvalidArgument);
  Compaction late(world.solver);
  late.build();
  for (World* each : {&world, &witness}) {
    each->solver.tissue().apply({.remove_tets = {4}});
  }
  CHECK_THROWS_AS(late.finish(world.solver), InvalidArgument);

  // world goes along as one that was never asked
  compact(world);
  compact(witness);
  burn(world, 6e-3F, 8);
  burn(witness, 6e-3F, 8);
  CHECK(std::ranges::equal(world.cautery.field().temperatures(),
                           witness.cautery.field().temperatures()));
  CHECK(world.cautery.field().ledger().in == witness.cautery.field().ledger().in);
  check_views(world);

  CHECK_THROWS_AS(late.finish(world.solver), InvalidArgument);
  CHECK_THROWS_WITH(world.solver.tissue().undo(), ContainsSubstring("no edit to undo"));
}

}  // namespace pbdsurg
