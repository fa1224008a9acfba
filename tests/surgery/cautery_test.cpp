// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cautery.h"

#include <algorithm>
#include <map>

#include "pbdsurg/core/error.h"

#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

constexpr double kEdge = 1e-3;

struct Setup {
  TetMesh mesh = testing::make_box({8, 8, 4}, kEdge, 0.05);
  Scene scene;

  Setup() {
    scene.add_body("fat", mesh);
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.1 * kEdge; });
  }
};

}  // namespace

// The whole chain: a tetrahedron goes through the states in order, shrinks while it burns, and
// goes.
TEST_CASE("cautery: tissue passes through heated and burning before it vaporises", "[validation]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, &setup.mesh, kFat};
  Cautery cautery(solver, std::span(&body, 1));
  const Eigen::Vector3f tip(4e-3F, 4e-3F, 4.2e-3F);

  std::vector<HeatState> before(setup.mesh.tet_count(), HeatState::normal);
  std::map<std::pair<HeatState, HeatState>, int> passages;
  Index removed = 0;
  bool shrank = false, shortened = false;
  for (int i = 0; i < 300; ++i) {
    const CauteryReport report = cautery.update(solver, tip, 8, 5e-3);
    removed += static_cast<Index>(report.edit.tets.size());
    solver.step(5e-3F);
    for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
      const HeatState now = cautery.state(t);
      if (now != before[t]) {
        ++passages[{before[t], now}];
      }
      before[t] = now;
      if (now == HeatState::burning) {
        shrank = shrank || solver.rest_volume(t) <
                               0.9 * tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
        for (const Index e : solver.tet_edges(t)) {
          const auto [a, b] = solver.edges()[e];
          const double before_burning =
              (setup.mesh.positions()[a] - setup.mesh.positions()[b]).norm();
          shortened = shortened || solver.rest_length(e) < 0.95 * before_burning;
        }
      }
    }
    const HeatLedger ledger = cautery.field().ledger();
    CHECK(ledger.sensible + ledger.latent + ledger.removed ==
          Approx(ledger.in + cautery.link_energy_spent()).epsilon(1e-9));
  }

  CHECK(removed > 10);
  CHECK(shrank);
  CHECK(shortened);
  CHECK(passages[{HeatState::normal, HeatState::heated}] > 10);
  CHECK(passages[{HeatState::heated, HeatState::burning}] > 10);
  CHECK(passages[{HeatState::burning, HeatState::vaporised}] > 10);
  CHECK(passages[{HeatState::normal, HeatState::vaporised}] == 0);
  CHECK(passages[{HeatState::heated, HeatState::vaporised}] == 0);

  // what went cannot have cost less than warming and boiling it
  const double per_volume =
      kFat.density * (63 * kFat.specific_heat + 0.95 * kFat.water_fraction * kLatentHeatOfWater);
  double volume = 0;
  for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
    if (!solver.is_tet_alive(t)) {
      volume += tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
    }
  }
  CHECK(volume * per_volume < cautery.field().ledger().in);
}

TEST_CASE("cautery: neo-hookean tissue shrinks by its volumes and vaporises", "[validation]") {
  const Setup setup;
  Scene scene;
  scene.add_body("fat", setup.mesh, {.model = ElasticModel::neo_hookean});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.1 * kEdge; });
  Solver solver(scene, {.damping = 20});
  const ThermalBody body{0, &setup.mesh, kFat};
  Cautery cautery(solver, std::span(&body, 1));
  Index removed = 0;
  bool shrank = false;
  for (int i = 0; i < 300; ++i) {
    const CauteryReport report = cautery.update(solver, {4e-3F, 4e-3F, 4.2e-3F}, 8, 5e-3);
    removed += static_cast<Index>(report.edit.tets.size());
    CHECK(solver.step(5e-3F).non_finite_vertices == 0);
    for (Index t = 0; t < setup.mesh.tet_count() && !shrank; ++t) {
      shrank =
          solver.is_tet_alive(t) &&
          solver.rest_volume(t) < 0.9 * tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
    }
  }
  CHECK(removed > 10);
  CHECK(shrank);
}

TEST_CASE("cautery: a tip that touches nothing delivers nothing", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, &setup.mesh, kFat};
  Cautery cautery(solver, std::span(&body, 1));

  const CauteryReport report = cautery.update(solver, {1, 1, 1}, 30, 0.01);

  CHECK(report.contact_vertices == 0);
  CHECK(report.energy == 0);
  CHECK(cautery.field().ledger().in == 0);
}

TEST_CASE("cautery: links part when they have taken their energy, the near ones first", "[unit]") {
  Scene scene;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 6; ++i) {
    points.push_back({1e-3 * i, 0, 0});
    points.push_back({1e-3 * i, 1e-3, 0});
  }
  scene.add_particles("ends", points, 1e-4);
  for (Index i = 0; i < 6; ++i) {
    scene.add_link({2 * i, 2 * i + 1, 1e-3F, {}});
  }
  Solver solver(scene);
  Cautery cautery(solver, {}, {.contact_radius = 1.4e-3, .link_energy = 0.5});

  std::vector<Index> order;
  double energy = 0;
  for (int i = 0; i < 400; ++i) {
    const CauteryReport report = cautery.update(solver, {0, 0.5e-3F, 0}, 5, 1e-3);
    energy += report.energy;
    order.insert(order.end(), report.edit.links.begin(), report.edit.links.end());
  }

  CHECK(order == std::vector<Index>{0, 1});  // links 2 to 5 are out of reach
  CHECK(energy == Approx(2 * 0.5));
  CHECK(cautery.link_energy_spent() == Approx(energy));
  CHECK_FALSE(solver.is_link_alive(0));
  CHECK(solver.is_link_alive(2));
}

TEST_CASE("cautery: a link takes its share beside tissue", "[unit]") {
  Setup setup;
  const Index corner = 0;  // at the origin; the next vertex is one edge away
  setup.scene.add_particles("end", std::vector<Eigen::Vector3d>{{0, 0, -1e-3}}, 1e-4);
  setup.scene.add_link({corner, setup.mesh.vertex_count(), 1e-3F, {}});
  Solver solver(setup.scene);
  const ThermalBody body{0, &setup.mesh, kFat};
  // the tip at the corner, which the link touches too: distances 0 and 0
  Cautery cautery(solver, std::span(&body, 1), {.contact_radius = 0.5e-3, .link_energy = 1e3});
  cautery.update(solver, solver.positions()[corner], 10, 0.01);

  CHECK(cautery.link_energy_spent() == Approx(0.8 * 0.1));  // four parts of five
  CHECK(cautery.field().ledger().in == Approx(0.2 * 0.1));
}

TEST_CASE("cautery: it follows edits made before and beside it", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, &setup.mesh, kFat};
  TopologyEdit half, rest;
  for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
    (t % 2 == 0 ? half : rest).remove_tets.push_back(t);
  }
  apply_edit(solver, half);
  Cautery cautery(solver, std::span(&body, 1));
  CHECK(cautery.field().ledger().removed == 0);
  EditParticipant* participants[] = {&cautery};
  apply_edit(solver, rest, participants);

  CHECK(cautery.update(solver, {4e-3F, 4e-3F, 4e-3F}, 30, 0.01).energy == 0);
}

// Would catch tables of rest values and doses that grow or stay behind, and fields left out.
TEST_CASE("cautery: it goes back with an undo", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, &setup.mesh, kFat};
  Cautery cautery(solver, std::span(&body, 1));
  EditParticipant* participants[] = {&cautery};
  const Eigen::Vector3f tip(4e-3F, 4e-3F, 4.2e-3F);
  CauteryReport report;
  while (report.edit.tets.empty()) {
    report = cautery.update(solver, tip, 8, 5e-3);
    CHECK(report.request.remove_tets == report.edit.tets);
  }
  TopologyEdit edit;
  for (Index t = 0; t < setup.mesh.tet_count(); t += 3) {
    if (solver.is_tet_alive(t)) {
      edit.remove_tets.push_back(t);
    }
  }
  const Cautery before = cautery;
  const EditResult result = apply_edit(solver, edit, participants);
  CHECK(cautery.field().ledger().removed > before.field().ledger().removed);

  cautery.undo(solver, edit, result);

  CHECK(cautery.field().ledger().removed == before.field().ledger().removed);
  CHECK(cautery.field().ledger().sensible == before.field().ledger().sensible);
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    REQUIRE(cautery.field().capacity(v) == before.field().capacity(v));
  }
}

TEST_CASE("cautery: bad values are refused by name", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const TetMesh other = testing::make_box({1, 1, 1}, kEdge);
  const auto make = [&](Index body, const TetMesh& mesh, CauteryOptions options) {
    const ThermalBody entry{body, &mesh, kFat};
    return Cautery(solver, std::span(&entry, 1), options);
  };
  CHECK_THROWS_WITH(make(1, setup.mesh, {}), ContainsSubstring("no body 1"));
  CHECK_THROWS_WITH(make(0, other, {}), ContainsSubstring("body 'fat'"));
  CHECK_THROWS_WITH(make(0, setup.mesh, {.contact_radius = 0}),
                    ContainsSubstring("contact_radius"));
  CHECK_THROWS_WITH(make(0, setup.mesh, {.dry_water = 2}), ContainsSubstring("dry_water"));
  CHECK_THROWS_WITH(make(0, setup.mesh, {.link_energy = -1}), ContainsSubstring("link_energy"));
  const ThermalBody twice[] = {{0, &setup.mesh, kFat}, {0, &setup.mesh, kFat}};
  CHECK_THROWS_WITH(Cautery(solver, twice), ContainsSubstring("given twice"));
  const ThermalBody none{0, nullptr, kFat};
  CHECK_THROWS_WITH(Cautery(solver, std::span(&none, 1)), ContainsSubstring("no mesh"));
  const ThermalBody dry{0, &setup.mesh, {1000, 3000, 0.5, 0}};
  CHECK_THROWS_WITH(Cautery(solver, std::span(&dry, 1)), ContainsSubstring("no water"));
  CHECK_THROWS_WITH(make(0, setup.mesh, {.link_share = 0}), ContainsSubstring("link_share"));
  Cautery cautery = make(0, setup.mesh, {});
  CHECK_THROWS_AS(cautery.update(solver, {0, 0, 0}, -1, 0.01), InvalidArgument);
  CHECK_THROWS_AS(cautery.update(solver, {0, 0, 0}, 1, 0), InvalidArgument);
}

}  // namespace pbdsurg
