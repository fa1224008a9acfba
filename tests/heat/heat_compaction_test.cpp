// SPDX-License-Identifier: Apache-2.0
// Heat and potentials whose tissue is compacted.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/solver/compaction.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kFat;
using testing::kLiver;
using testing::ledger_error;

}  // namespace

// Would catch temperatures, states, held vertices or warm regions that are lost in a compaction or
// go to others, and slivers or bodies that are gone and still count.
TEST_CASE("heat field: it goes along with a compaction", "[property]") {
  const TetMesh box = testing::make_box({4, 4, 4}, 1e-3, 0.05);
  Scene scene;
  scene.add_body("gone", box);
  scene.add_body("other", testing::make_box({2, 2, 2}, 1e-3));
  scene.add_body("block", box);
  Solver solver(scene, {.executor = executor::serial()});
  Tissue& tissue = solver.tissue();
  Tissue old_tissue(scene);  // has the same edits, and is not compacted
  const std::array bodies{ThermalBody{0, kFat}, ThermalBody{2, kLiver}};
  ThermalModel model;
  model.surface_transfer = 20;
  HeatField field(tissue, bodies, model, {.tolerance = 1e-12});
  HeatField unchanged(old_tissue, bodies, model, {.tolerance = 1e-12});
  const auto apply = [&](const TopologyEdit& edit) {
    tissue.apply(edit);
    old_tissue.apply(edit);
  };
  const Index first = tissue.body(2).first_vertex;
  const Index first_tet = tissue.body(2).first_tet;
  const Index held = first + 7, cold = first + box.vertex_count() - 1;
  const std::vector<HeatSource> sources{{5, 2.0}, {first + 62, 3.0}};
  for (HeatField* each : {&field, &unchanged}) {
    each->set_temperatures(std::array{held, cold}, std::array{80.0, 30.0});
    each->hold(std::array{held, Index{4}, cold});
    for (int i = 0; i < 20; ++i) {
      each->step(0.02, sources);
    }
  }
  for (Index i = 0; i < 4; ++i) {
    apply(testing::split_edge(solver, tissue.tet_edges(first_tet + 50 + 9 * i)[1], 0.4F));
    apply(testing::part_vertex(solver, first + 30 + i, 3));
  }
  TopologyEdit corner{.remove_bodies = {0}};
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (tissue.is_tet_alive(t) && testing::has_corner(tissue.tets()[t], cold)) {
      corner.remove_tets.push_back(t);
    }
  }
  corner.new_bodies.add_body("guest", box);
  apply(corner);
  REQUIRE(field.ledger().removed > 0);

  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  CHECK(field.mesh().vertex_count() == tissue.vertex_count());
  CHECK(field.mesh().tet_count() == static_cast<Index>(tissue.tets().size()));
  CHECK(field.mesh().version() != unchanged.mesh().version());
  CHECK(field.ledger().in == unchanged.ledger().in);
  const auto farthest = [&] {
    double most = 0;
    for (Index v = 0; v < unchanged.mesh().vertex_count(); ++v) {
      if (const Index id = ids.vertices[v]; id != kInvalidIndex) {
        most = std::max({most, std::abs(field.temperatures()[id] - unchanged.temperatures()[v]),
                         std::abs(field.peak_temperatures()[id] - unchanged.peak_temperatures()[v]),
                         std::abs(field.water()[id] - unchanged.water()[v]),
                         std::abs(field.survival()[id] - unchanged.survival()[v]),
                         std::abs(field.collagen()[id] - unchanged.collagen()[v]),
                         std::abs(field.charred()[id] - unchanged.charred()[v])});
      }
    }
    return most;
  };
  CHECK(farthest() == 0);
  // the region is the same: heat that it left out would show
  const HeatSource old_source{first + 62, 3.0}, source{ids.vertices[first + 62], 3.0};
  for (int i = 0; i < 50; ++i) {
    const HeatReport report = field.step(0.05, {&source, 1});
    const HeatReport expected = unchanged.step(0.05, {&old_source, 1});
    CHECK(report.slivers == expected.slivers);
    REQUIRE(farthest() < 1e-8);
  }
  CHECK(field.temperatures()[ids.vertices[held]] == 80);
  CHECK(field.ledger().in == Approx(unchanged.ledger().in).epsilon(1e-10));
  CHECK(field.ledger().sensible == Approx(unchanged.ledger().sensible).epsilon(1e-10));
  CHECK(field.ledger().latent == Approx(unchanged.ledger().latent).epsilon(1e-10));
  CHECK(field.ledger().surface == Approx(unchanged.ledger().surface).epsilon(1e-10));
  CHECK(std::abs(ledger_error(field.ledger())) < 1e-12 * field.ledger().in);
}

// Would catch a potential that takes ids of one numbering for those of another, and ground that
// gives way to a ball because its tissue has gone.
TEST_CASE("heat field: a potential goes along with a compaction of its mesh", "[unit]") {
  const TetMesh box = testing::make_box({6, 6, 6}, 1e-3, 0.05);
  Scene scene;
  scene.add_body("gone", testing::make_box({2, 2, 2}, 1e-3));
  scene.add_body("block", box);
  Solver solver(scene, {.executor = executor::serial()});
  Tissue& tissue = solver.tissue();
  Tissue old_tissue(scene);  // has the same edit, and is not compacted
  const std::array bodies{ThermalBody{1, kLiver}};
  const ThermalMesh mesh(tissue, bodies), old_mesh(old_tissue, bodies);
  PotentialField potential(mesh, {.tolerance = 1e-10});
  PotentialField expected(old_mesh, {.tolerance = 1e-10});
  const Index first = tissue.body(1).first_vertex, last = first + box.vertex_count() - 1;
  const bool loses_ground = GENERATE(false, true);
  TopologyEdit edit{.remove_bodies = {0}};
  for (Index t = tissue.body(1).first_tet; t < static_cast<Index>(tissue.tets().size()); ++t) {
    if (loses_ground && testing::has_corner(tissue.tets()[t], last)) {
      edit.remove_tets.push_back(t);
    }
  }
  for (PotentialField* each : {&potential, &expected}) {
    each->set_patch(std::array{PatchVertex{first, 1}, PatchVertex{first + 1, 0.5}}, 1e-6);
    each->set_ground(std::array{last});
  }
  tissue.apply(edit);
  old_tissue.apply(edit);
  const auto solve = [](PotentialField& field, const ThermalMesh& of) {
    return field.solve(std::vector<double>(static_cast<std::size_t>(of.tet_count()), 0.3));
  };
  const double conductance = solve(expected, old_mesh).conductance;
  CHECK((conductance == 0) == loses_ground);
  solve(potential, mesh);

  Compaction compaction(solver);
  compaction.build();
  CHECK(potential.report().conductance == conductance);
  compaction.finish(solver);
  CHECK(potential.vertices().empty());
  CHECK(potential.report().conductance == 0);  // until the next solve()
  CHECK(solve(potential, mesh).conductance == Approx(conductance).epsilon(1e-9));
}

}  // namespace pbdsurg
