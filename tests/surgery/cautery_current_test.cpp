// SPDX-License-Identifier: Apache-2.0
// What a cautery's electrode touches, the current that flows, and where its energy goes.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "pbdsurg/heat/tissue_state.h"
#include "pbdsurg/surgery/cautery.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/heat_tissues.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::CauteryBlock;
using testing::check_ledger;
using testing::kFat;
using testing::kLiver;
using testing::kOnTop;
using testing::point;

}  // namespace

TEST_CASE("cautery: a tip that touches nothing delivers nothing", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));

  const CauteryReport report = cautery.update(solver, point({1, 1, 1}), cut_settings(30), 0.01);

  CHECK(report.contact_vertices == 0);
  CHECK(report.regime == GeneratorRegime::open_circuit);
  CHECK(std::isinf(report.resistance));
  CHECK(report.energy == 0);
  CHECK(cautery.field().ledger().in == 0);
}

// Would catch conductivities that are not followed while the generator is off: tissue that was hot
// and has cooled would still let more current through.
TEST_CASE("cautery: tissue that has cooled conducts as before", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
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

// Would catch a contact of vertices alone: the tip is in the middle of a cell of the surface, whose
// corners are all farther from it than the contact radius.
TEST_CASE("cautery: a tip between vertices touches", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
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

// Would catch a contact that is lost where a tool that meets vertices alone has passed through a
// face.
TEST_CASE("cautery: a tip within the tissue touches, one as far outside does not", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
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
  const double edge = is_disk ? 4e-3 : CauteryBlock::kEdge;
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
  Cautery cautery(solver.tissue(), std::span(&body, 1), {.link_energy = 0.03});
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

// Would catch a generator that heats what has no way back: a piece cut off all around.
TEST_CASE("cautery: an island takes no power", "[unit]") {
  const CauteryBlock block;
  Solver solver(block.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1));
  TopologyEdit edit;
  for (Index t = 0; t < block.mesh.tet_count(); ++t) {
    Eigen::Vector3d centre = Eigen::Vector3d::Zero();
    for (const Index v : block.mesh.tets()[t]) {
      centre += block.mesh.positions()[v] / 4;
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

}  // namespace pbdsurg
