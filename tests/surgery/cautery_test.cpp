// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/cautery.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

const ThermalProperties& kLiver = tissues::liver().heat;
const ThermalProperties& kFat = tissues::fat().heat;

constexpr double kEdge = 1e-3;
constexpr double kNoLimit = std::numeric_limits<double>::infinity();

struct Setup {
  TetMesh mesh = testing::make_box({8, 8, 4}, kEdge, 0.05);
  Scene scene;

  Setup() {
    scene.add_body("fat", mesh);
    scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.1 * kEdge; });
  }
};

Electrode point(const Eigen::Vector3f& tip) {
  return {tip, tip};
}

const Electrode kOnTop = point({4e-3F, 4e-3F, 4.2e-3F});

// What came in equals what is there, what went, and what tissue lost.
void check_ledger(const Cautery& cautery) {
  const HeatLedger& ledger = cautery.field().ledger();
  CHECK(ledger.sensible + ledger.latent + ledger.removed + ledger.surface + ledger.perfusion ==
        Approx(ledger.in).epsilon(1e-9).margin(1e-12));
  CHECK(cautery.removal_energy() <= ledger.in);
}

// Refuses every edit for as long as it is told to.
struct Refusing final : Follower {
  void validate(const Tissue&, const TopologyEdit& edit) const override {
    if (refuses) {
      refused = edit;
      throw InvalidArgument("refused");
    }
  }
  void follow(const Tissue&, const TissueChange&) noexcept override {}
  void undo(const Tissue&, const TissueChange&) noexcept override {}
  void renumber(const Tissue&, const Renumbering&) noexcept override {}

  bool refuses = true;
  mutable TopologyEdit refused{};
};

}  // namespace

// The whole chain: a tetrahedron goes through the states in order, shrinks while it burns, and
// goes; every joule is accounted for at every update, and what went was paid for.
TEST_CASE("cautery: tissue passes through heated and burning before it vaporises", "[validation]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.tearing_rate = 1e3});  // nothing tears

  std::vector<HeatState> before(setup.mesh.tet_count(), HeatState::normal);
  std::map<std::pair<HeatState, HeatState>, int> passages;
  Index removed = 0;
  double volume = 0, delivered = 0;
  bool shrank = false, shortened = false;
  for (int i = 0; i < 300; ++i) {
    const CauteryReport report = cautery.update(solver, kOnTop, cut_settings(40), 5e-3);
    removed += static_cast<Index>(report.edit.removed_tets.size());
    volume += report.removed_volume;
    delivered += report.energy;
    CHECK(report.torn == 0);
    CHECK(report.converged);
    solver.step(5e-3F);
    for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
      const HeatState now = cautery.state(t);
      if (now != before[t]) {
        ++passages[{before[t], now}];
      }
      before[t] = now;
      if (now == HeatState::burning) {
        shrank = shrank || solver.rest_volume(t) <
                               0.97 * tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
        for (const Index e : solver.tissue().tet_edges(t)) {
          const auto [a, b] = solver.tissue().edges()[e];
          const double before_burning =
              (setup.mesh.positions()[a] - setup.mesh.positions()[b]).norm();
          shortened = shortened || solver.rest_length(e) < 0.97 * before_burning;
        }
      }
    }
    check_ledger(cautery);
  }

  CHECK(delivered == Approx(cautery.field().ledger().in));
  CHECK(removed > 10);
  CHECK(shrank);
  CHECK(shortened);
  CHECK(passages[{HeatState::normal, HeatState::heated}] > 10);
  CHECK(passages[{HeatState::heated, HeatState::burning}] > 10);
  CHECK(passages[{HeatState::burning, HeatState::vaporised}] > 10);
  CHECK(passages[{HeatState::normal, HeatState::vaporised}] == 0);
  CHECK(passages[{HeatState::heated, HeatState::vaporised}] == 0);

  double gone = 0;
  for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
    if (!solver.tissue().is_tet_alive(t)) {
      gone += tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
    }
  }
  CHECK(volume == Approx(gone));
}

// Would catch removal that outruns energy: steam could tear tissue at once that would have taken
// many times as long to boil dry; and what steam will tear later counted as waiting.
TEST_CASE("cautery: removal never costs more than what was delivered", "[property]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.tearing_rate = 1e-3, .tearing_loss = 1e-6});  // whatever boils is torn
  const double per_volume =
      kLiver.density * (63 * kLiver.specific_heat + kLiver.water_fraction * kLatentHeatOfWater);
  double volume = 0, delivered = 0;
  Index torn = 0;
  for (int i = 0; i < 200; ++i) {
    const CauteryReport report = cautery.update(solver, kOnTop, cut_settings(40), 5e-3);
    volume += report.removed_volume;
    delivered += report.energy;
    torn += report.torn;
    CHECK(report.deferred == 0);
    REQUIRE(volume * per_volume <= delivered * (1 + 1e-12));
    CHECK(cautery.removal_energy() == Approx(volume * per_volume));
    check_ledger(cautery);
  }
  CHECK(torn > 10);
}

TEST_CASE("cautery: neo-hookean tissue shrinks by its volumes and vaporises", "[validation]") {
  const Setup setup;
  Scene scene;
  scene.add_body("fat", setup.mesh, {.model = ElasticModel::neo_hookean});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.1 * kEdge; });
  Solver solver(scene, {.damping = 20});
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  Index removed = 0;
  bool shrank = false;
  for (int i = 0; i < 300; ++i) {
    const CauteryReport report = cautery.update(solver, kOnTop, cut_settings(40), 5e-3);
    removed += static_cast<Index>(report.edit.removed_tets.size());
    CHECK(solver.step(5e-3F).non_finite_vertices == 0);
    for (Index t = 0; t < setup.mesh.tet_count() && !shrank; ++t) {
      shrank =
          solver.tissue().is_tet_alive(t) &&
          solver.rest_volume(t) < 0.97 * tet_volume(setup.mesh.positions(), setup.mesh.tets()[t]);
    }
  }
  CHECK(removed > 10);
  CHECK(shrank);
}

TEST_CASE("cautery: a tip that touches nothing delivers nothing", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));

  const CauteryReport report = cautery.update(solver, point({1, 1, 1}), cut_settings(30), 0.01);

  CHECK(report.contact_vertices == 0);
  CHECK(report.regime == GeneratorRegime::open_circuit);
  CHECK(report.resistance == kNoLimit);
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
  Cautery cautery(solver.tissue(), {}, {.contact_radius = 1.4e-3, .link_energy = 0.5});

  std::vector<Index> order;
  double energy = 0;
  for (int i = 0; i < 400; ++i) {
    const CauteryReport report =
        cautery.update(solver, point({0, 0.5e-3F, 0}), cut_settings(5), 1e-3);
    energy += report.energy;
    order.insert(order.end(), report.edit.removed_links.begin(), report.edit.removed_links.end());
  }

  CHECK(order == std::vector<Index>{0, 1});  // links 2 to 5 are out of reach
  CHECK(energy == Approx(2 * 0.5));
  CHECK(cautery.link_energy_spent() == Approx(energy));
  CHECK_FALSE(solver.tissue().is_link_alive(0));
  CHECK(solver.tissue().is_link_alive(2));
}

// Would catch current that does not divide by conductance.
TEST_CASE("cautery: a link takes its share beside tissue", "[unit]") {
  Setup setup;
  const Index corner = 4 * 81 + 4 * 9 + 4;  // in the middle of the top
  setup.scene.add_particles("end", std::vector<Eigen::Vector3d>{{4e-3, 4e-3, 5e-3}}, 1e-4);
  setup.scene.add_link({corner, setup.mesh.vertex_count(), 1e-3F, {}});
  Solver solver(setup.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.electrode_cooling = 0, .link_energy = 1e3, .link_conductance = 2e-3});
  const CauteryReport report =
      cautery.update(solver, point(solver.positions()[corner]), known_current_settings(0.01), 1e-4);

  CHECK(report.contact_links == 1);
  const double whole = 1 / (report.resistance - CauteryOptions{}.body_resistance);  // S
  CHECK(cautery.link_energy_spent() == Approx(1e-4 * std::pow(0.01 / whole, 2) * 2e-3));
  CHECK(cautery.field().ledger().in == Approx(1e-4 * std::pow(0.01 / whole, 2) * (whole - 2e-3)));
}

// Would catch current that still flows, for nothing, through a link that has taken its energy and
// lives because a follower refused the edit; and a link that an undo brings back for good.
TEST_CASE("cautery: a full link takes no current, and parts when it may", "[unit]") {
  Setup setup;
  const Index corner = 4 * 81 + 4 * 9 + 4;  // in the middle of the top
  setup.scene.add_particles("end", std::vector<Eigen::Vector3d>{{4e-3, 4e-3, 5e-3}}, 1e-4);
  setup.scene.add_link({corner, setup.mesh.vertex_count(), 1e-3F, {}});
  Solver solver(setup.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.link_energy = 1e-6, .link_conductance = 2e-3});
  const Electrode electrode = point(solver.positions()[corner]);
  const GeneratorSettings settings = known_current_settings(0.01);
  Refusing refusing;
  solver.tissue().add_follower(refusing);
  CHECK_THROWS_AS(cautery.update(solver, electrode, settings, 1e-4), InvalidArgument);
  CHECK(cautery.link_energy_spent() == Approx(1e-6));
  CHECK(solver.tissue().is_link_alive(0));
  CHECK_THROWS_AS(cautery.update(solver, electrode, settings, 1e-4), InvalidArgument);
  CHECK(cautery.link_energy_spent() == Approx(1e-6));

  refusing.refuses = false;
  const double in = cautery.field().ledger().in + cautery.electrode_energy();
  CauteryReport report = cautery.update(solver, electrode, settings, 1e-4);
  CHECK(report.edit.removed_links == std::vector<Index>{0});
  // all of the current through tissue
  CHECK(cautery.field().ledger().in + cautery.electrode_energy() - in ==
        Approx(1e-4 * 0.01 * 0.01 * (report.resistance - CauteryOptions{}.body_resistance)));

  cautery.update(solver, electrode, std::nullopt, 1e-4);
  solver.tissue().undo();
  report = cautery.update(solver, electrode, std::nullopt, 1e-4);
  CHECK(report.edit.removed_links == std::vector<Index>{0});
}

// Would catch tissue that steam tore and that is forgotten, as it no longer boils so fast, where
// the edit was refused or undone.
TEST_CASE("cautery: torn tissue goes once it may, after a refusal and after an undo", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.tearing_rate = 0.1, .tearing_loss = 0.01});
  Refusing refusing;
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

// Would catch conductivities that are not followed while the generator is off: tissue that was hot
// and has cooled would still let more current through.
TEST_CASE("cautery: tissue that has cooled conducts as before", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.electrode_cooling = 0});
  const auto resistance = [&] {
    return cautery.update(solver, kOnTop, known_current_settings(0.02), 1e-6).resistance;
  };
  const double cold = resistance();
  for (int i = 0; i < 5; ++i) {
    cautery.update(solver, kOnTop, known_current_settings(0.2), 5e-3);
  }
  REQUIRE(*std::ranges::min_element(cautery.field().water()) == 1);
  CHECK(resistance() < 0.97 * cold);
  for (int i = 0; i < 400; ++i) {
    cautery.update(solver, kOnTop, std::nullopt, 1);
  }
  const double evened_out = *std::ranges::max_element(cautery.field().temperatures());
  const double gain = electrical_conductivity(kLiver, evened_out, 1.0) /
                      electrical_conductivity(kLiver, kBodyTemperature, 1.0);
  REQUIRE(gain < 1.01);
  CHECK(resistance() - 150 == Approx((cold - 150) / gain).epsilon(2e-3));
}

TEST_CASE("cautery: it follows edits made before and beside it", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kFat};
  TopologyEdit half, rest;
  for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
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
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
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
  for (Index t = 0; t < setup.mesh.tet_count(); t += 3) {
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

// Would catch a contact of vertices alone: the tip is in the middle of a cell of the surface, whose
// corners are all farther from it than the contact radius.
TEST_CASE("cautery: a tip between vertices touches", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.contact_radius = 0.6e-3});
  const CauteryReport report =
      cautery.update(solver, point({4.5e-3F, 4.5e-3F, 4e-3F}), cut_settings(10), 1e-3);
  CHECK_FALSE(report.is_disk);
  CHECK(report.contact_vertices >= 3);
  CHECK(report.contact_area == Approx(3.14159 * 0.6e-3 * 0.6e-3).epsilon(1e-4));
  // (1 / (4 sigma a) within the staircase of a contact of one triangle)
  const double disk = 1 / (4 * kLiver.electrical_conductivity * 0.6e-3);
  CHECK(report.resistance - 150 > 0.6 * disk);
  CHECK(report.resistance - 150 < 1.4 * disk);
}

// Would catch a contact that is lost because tools push vertices alone and pass through faces.
TEST_CASE("cautery: a tip within the tissue touches, one as far outside does not", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.contact_radius = 0.7e-3});
  const auto power_at = [&](float z) {
    return cautery.update(solver, point({4e-3F, 4e-3F, z}), cut_settings(10), 1e-3).power;
  };
  CHECK(power_at(4e-3F + 1.2e-3F) == 0);
  CHECK(power_at(4e-3F - 1.2e-3F) > 5);
  CHECK(power_at(4e-3F) > 5);
}

// Would catch a coarse mesh that heats with another power than a fine one, or not at all.
TEST_CASE("cautery: a mesh coarser than the contact takes the disk, with equal power", "[unit]") {
  const TetMesh mesh = testing::make_box({5, 5, 5}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("liver", mesh);
  Solver solver(scene);
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  const CauteryReport report =
      cautery.update(solver, point({9e-3F, 11e-3F, 20e-3F}), cut_settings(20), 1e-3);

  CHECK(report.is_disk);
  const double disk = 1 / (4 * kLiver.electrical_conductivity * 1.26e-3);
  CHECK(report.resistance == Approx(disk + 150).epsilon(0.01));
  CHECK(report.power == Approx(20 * disk / (disk + 150)).epsilon(0.01));
}

// Would catch metal that is warm, or cools nothing, where the disk stands for the potential: a mesh
// coarser than the contact would boil sooner than a fine one for no reason in physics.
TEST_CASE("cautery: the electrode cools tissue under the disk, too", "[unit]") {
  const TetMesh mesh = testing::make_box({5, 5, 5}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("liver", mesh);
  const ThermalBody body{0, kLiver};
  double hottest[2], into_metal[2];
  for (const int i : {0, 1}) {
    Solver solver(scene);
    Cautery cautery(solver.tissue(), std::span(&body, 1), {.electrode_cooling = i * 2e4});
    double delivered = 0;
    for (int k = 0; k < 50; ++k) {
      const CauteryReport report =
          cautery.update(solver, point({9e-3F, 11e-3F, 20e-3F}), cut_settings(20), 20e-3);
      REQUIRE(report.is_disk);
      delivered += report.energy;
      hottest[i] = report.hottest;
    }
    check_ledger(cautery);
    into_metal[i] = cautery.electrode_energy() / (delivered + cautery.electrode_energy());
  }
  CHECK(into_metal[0] == 0);
  CHECK(into_metal[1] > 0.01);
  CHECK(into_metal[1] < 0.3);
  CHECK(hottest[1] < hottest[0]);
}

// Would catch a part that the report leaves out, or counts twice: tissue, metal, links, some of
// which part, and the way through the body.
TEST_CASE("cautery: what the generator delivered is the sum of its parts", "[validation]") {
  const bool is_disk = GENERATE(false, true);
  const double edge = is_disk ? 4e-3 : kEdge;
  const TetMesh mesh = testing::make_box({8, 8, 4}, edge, 0.05);
  Scene scene;
  scene.add_body("liver", mesh);
  const Index corner = 4 * 81 + 4 * 9 + 4;  // in the middle of the top
  const Eigen::Vector3d top = mesh.positions()[corner];
  scene.add_particles("end", std::vector<Eigen::Vector3d>{top, top}, 1e-4);
  scene.add_link({corner, mesh.vertex_count(), 1e-3F, {}});
  scene.add_link({corner, mesh.vertex_count() + 1, 1e-3F, {}});
  Solver solver(scene);
  const ThermalBody body{0, kLiver};
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.link_energy = 0.3});
  const GeneratorSettings settings = GENERATE(cut_settings(30), coagulate_settings(30));

  CauteryReport sum;
  for (int i = 0; i < 60; ++i) {
    const CauteryReport report = cautery.update(solver, point(top.cast<float>()), settings, 5e-3);
    REQUIRE(report.is_disk == is_disk);
    CHECK(report.energy + report.electrode_energy + report.body_energy + report.surplus_energy ==
          Approx(report.generator_energy).epsilon(1e-9));
    CHECK(report.generator_energy <= 30 * 5e-3 * (1 + 1e-9));
    sum.energy += report.energy;
    sum.link_energy += report.link_energy;
    sum.electrode_energy += report.electrode_energy;
    sum.body_energy += report.body_energy;
    sum.surplus_energy += report.surplus_energy;
    sum.generator_energy += report.generator_energy;
  }
  CHECK(sum.generator_energy > 0.1 * 30 * 60 * 5e-3);
  CHECK(sum.electrode_energy == Approx(cautery.electrode_energy()));
  CHECK(sum.link_energy == Approx(cautery.link_energy_spent()));
  CHECK(sum.energy - sum.link_energy == Approx(cautery.field().ledger().in));
  for (const double part :
       {sum.link_energy, sum.electrode_energy, sum.body_energy, sum.surplus_energy}) {
    CHECK(part > 0);
  }
  CHECK(cautery.update(solver, point({1, 1, 1}), settings, 5e-3).generator_energy == 0);
}

// Would catch dry tissue that goes unpaid, is not said to wait, or is forgotten: where tissue
// counts as dry with nine tenths of its water left, more of it is dry than the energy could have
// dried.
TEST_CASE("cautery: dry tissue waits for the energy that would have dried it", "[property]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, kLiver};
  CauteryOptions options{.tearing_rate = 1e3};  // nothing tears
  options.model.dry_water = 0.9;
  Cautery cautery(solver.tissue(), std::span(&body, 1), options);
  int waited = 0, went = 0;
  for (int i = 0; i < 150; ++i) {
    const CauteryReport report = cautery.update(solver, kOnTop, cut_settings(40), 10e-3);
    Index due = 0;
    for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
      due += solver.tissue().is_tet_alive(t) && cautery.state(t) == HeatState::vaporised ? 1 : 0;
    }
    CHECK(report.deferred == due);
    waited += report.deferred > 0 ? 1 : 0;
    went += waited > 0 ? static_cast<int>(report.edit.removed_tets.size()) : 0;
    check_ledger(cautery);
  }
  CHECK(waited > 10);
  CHECK(went > 10);
  // without the generator nothing more is paid for, and nothing goes but what was
  const CauteryReport last = cautery.update(solver, kOnTop, std::nullopt, 10e-3);
  CHECK(last.deferred > 0);
  CHECK(last.edit.removed_tets.empty());
}

// Karaki et al. 2020, CMBBE 23:1317: a moving blade in porcine liver does nothing visible at 10 W,
// coagulates at 25 W, cuts at 50 W. Speed and contact area as there; the shape of the contact, the
// cooling of the electrode and what tears are calibrated (CauteryOptions).
TEST_CASE("cautery: a blade leaves no mark, whitens or cuts with 10, 25 or 50 W", "[validation]") {
  // cells of 0.5 mm around the track, growing outwards
  constexpr Index kFine[] = {16, 18, 5}, kGrown = 4;
  const auto stretched = [](double cell, Index fine, Index low) {
    const auto beyond = [](double cells) { return cells > 0 ? 2 * (std::pow(1.7, cells) - 1) : 0; };
    const double x = cell - low;
    return 0.5e-3 * (std::clamp(x, 0.0, static_cast<double>(fine)) - beyond(-x) + beyond(x - fine));
  };
  const TetMesh box =
      testing::make_box({kFine[0] + 2 * kGrown, kFine[1] + 2 * kGrown, kFine[2] + kGrown}, 1, 0.1);
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : box.positions()) {
    points.push_back({stretched(p.x(), kFine[0], kGrown), stretched(p.y(), kFine[1], kGrown),
                      -stretched(kFine[2] + kGrown - p.z(), kFine[2], 0)});
  }
  const TetMesh mesh(points, {box.tets().begin(), box.tets().end()});
  Scene scene;
  scene.add_body("liver", mesh);
  const ThermalBody body{0, kLiver};
  constexpr double kLength = 5e-3;  // m, across; pi r^2 + 2 r length = 10 mm^2
  constexpr double kRadius = 0.8e-3;

  struct Mark {
    double survival = 1, water = 1, removed = 0;
  };
  const auto cut = [&](double power) {
    Solver solver(scene, {.executor = executor::serial()});
    Cautery cautery(solver.tissue(), std::span(&body, 1), {.contact_radius = kRadius});
    Mark mark;
    for (int i = 0; i < 90; ++i) {
      const Eigen::Vector3f middle(2e-3F + 10e-3F * 5e-3F * static_cast<float>(i), 4.5e-3F, 0);
      const Eigen::Vector3f half(0, kLength / 2, 0);
      const CauteryReport report =
          cautery.update(solver, {middle - half, middle + half}, cut_settings(power), 5e-3);
      CHECK(report.contact_area == Approx(10e-6).epsilon(0.01));
      mark.removed += report.removed_volume;
      check_ledger(cautery);
    }
    for (int i = 0; i < 20; ++i) {
      cautery.update(solver, point({0, 0, 1}), std::nullopt, 50e-3);
    }
    mark.survival = *std::ranges::min_element(cautery.field().survival());
    mark.water = *std::ranges::min_element(cautery.field().water());
    return mark;
  };

  const Mark faint = cut(10), white = cut(25), deep = cut(50);
  CHECK(faint.survival > 0.9);
  CHECK(faint.removed == 0);
  CHECK(white.survival < 0.1);
  CHECK(white.removed == 0);
  CHECK(deep.survival < 0.1);
  CHECK(deep.removed > 0.5e-9);  // m^3
}

// Would catch the paper's mode if it were another code, or needed water: a known current, vertices
// that boil at once, tetrahedra that go when all four have, and still no removal without energy.
TEST_CASE("cautery: the paper's preset burns with a known current", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene, {.damping = 20});
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.electrode_cooling = 0, .model = ThermalModel::paper()});
  Index removed = 0;
  bool shrank = false;
  for (int i = 0; i < 100; ++i) {
    const CauteryReport report = cautery.update(solver, kOnTop, known_current_settings(0.2), 5e-3);
    removed += static_cast<Index>(report.edit.removed_tets.size());
    shrank = shrank || !report.edit.edit.rest_lengths.empty();
    CHECK((report.current == Approx(0.2) || report.resistance == kNoLimit));
    check_ledger(cautery);
  }
  CHECK(removed > 10);
  CHECK(shrank);
  CHECK(cautery.field().ledger().latent == 0);
}

// Would catch a generator that heats what has no way back: a piece cut off all around.
TEST_CASE("cautery: an island takes no power", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  TopologyEdit edit;
  for (Index t = 0; t < setup.mesh.tet_count(); ++t) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Index v : setup.mesh.tets()[t]) {
      centre += setup.mesh.positions()[v] / 4;
    }
    if ((centre - Eigen::Vector3d(4e-3, 4e-3, 4e-3)).cwiseAbs().maxCoeff() > 1e-3) {
      edit.remove_tets.push_back(t);
    }
  }
  solver.tissue().apply(edit);
  const CauteryReport report = cautery.update(solver, kOnTop, cut_settings(30), 5e-3);
  CHECK(report.contact_vertices > 0);
  CHECK(report.regime == GeneratorRegime::open_circuit);
  CHECK(report.energy == 0);
}

TEST_CASE("cautery: bad values are refused by name", "[unit]") {
  const Setup setup;
  Solver solver(setup.scene);
  const auto make = [&](Index body, CauteryOptions options) {
    const ThermalBody entry{body, kFat};
    return Cautery(solver.tissue(), std::span(&entry, 1), options);
  };
  CHECK_THROWS_WITH(make(1, {}), ContainsSubstring("no body 1"));
  CHECK_THROWS_WITH(make(0, {.contact_radius = 0}), ContainsSubstring("contact_radius"));
  CHECK_THROWS_WITH(make(0, {.body_resistance = -1}), ContainsSubstring("body_resistance"));
  CHECK_THROWS_WITH(make(0, {.electrode_cooling = -1}), ContainsSubstring("electrode_cooling"));
  CHECK_THROWS_WITH(make(0, {.tearing_rate = 0}), ContainsSubstring("tearing_rate"));
  CHECK_THROWS_WITH(make(0, {.tearing_loss = 2}), ContainsSubstring("tearing_loss"));
  CHECK_THROWS_WITH(make(0, {.boiled_shrinkage = 0.2}),
                    ContainsSubstring("boiled_shrinkage is 0.2, which nothing would read"));
  CHECK_THROWS_WITH(make(0, {.link_energy = -1}), ContainsSubstring("link_energy"));
  const ThermalBody twice[] = {{0, kFat}, {0, kFat}};
  CHECK_THROWS_WITH(Cautery(solver.tissue(), twice), ContainsSubstring("given twice"));
  const ThermalBody dry{0, {1000, 3000, 0.5, 0}};
  CHECK_THROWS_WITH(Cautery(solver.tissue(), std::span(&dry, 1)), ContainsSubstring("no water"));
  CHECK_THROWS_WITH(make(0, {.link_conductance = 0}), ContainsSubstring("link_conductance"));
  Cautery cautery = make(0, {});
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto update = [&](const Electrode& electrode, double power, double dt) {
    cautery.update(solver, electrode, cut_settings(power), dt);
  };
  CHECK_THROWS_WITH(update(kOnTop, -1, 0.01), ContainsSubstring("power is -1"));
  CHECK_THROWS_WITH(update(kOnTop, nan, 0.01), ContainsSubstring("power is"));
  CHECK_THROWS_WITH(update(kOnTop, 1, 0), ContainsSubstring("dt is 0"));
  CHECK_THROWS_WITH(update(point({0, nan, 0}), 1, 0.01), ContainsSubstring("electrode"));
  CHECK(cautery.field().ledger().in == 0);
}

}  // namespace pbdsurg
