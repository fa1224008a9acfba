// SPDX-License-Identifier: Apache-2.0
// Links that a cautery burns through.
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/heat_tissues.h"
#include "tests/support/meshes.h"
#include "tests/support/refusing_follower.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::CauteryBlock;
using testing::kFat;
using testing::point;
using testing::RefusingFollower;

// Links the middle of the top to a particle above it.
// @return  that vertex of the block
Index link_top(CauteryBlock& block) {
  const Index corner = 4 * 81 + 4 * 9 + 4;
  block.scene.add_particles("end", std::vector<Eigen::Vector3d>{{4e-3, 4e-3, 5e-3}}, 1e-4);
  block.scene.add_link({corner, block.mesh.vertex_count(), 1e-3F, {}});
  return corner;
}

}  // namespace

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
  CauteryBlock block;
  const Index corner = link_top(block);
  Solver solver(block.scene);
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
  CauteryBlock block;
  const Index corner = link_top(block);
  Solver solver(block.scene);
  const ThermalBody body{0, kFat};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.link_energy = 1e-6, .link_conductance = 2e-3});
  const Electrode electrode = point(solver.positions()[corner]);
  const GeneratorSettings settings = known_current_settings(0.01);
  RefusingFollower refusing;
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

// A strand and tissue under the electrode are of about the same stuff. Would catch links that take
// most of the energy, which a wire between two organs once gave them: 55 % for some mm^3.
TEST_CASE("cautery: a link takes as much heat a volume as tissue near the contact",
          "[validation]") {
  const double length = GENERATE(0.0, 4e-3);  // m, of the electrode
  constexpr double kRadius = 1.26e-3, kLinkVolume = 0.5e-9;
  const TetMesh mesh = testing::make_box({24, 24, 10}, 0.5e-3, 0.05);
  Scene scene;
  scene.add_body("liver", mesh);
  const Eigen::Vector3d top(6e-3, 6e-3, 5e-3);
  scene.add_particles("end", std::vector<Eigen::Vector3d>{top}, 1e-4);
  scene.add_link({12 + 25 * (12 + 25 * 10), mesh.vertex_count(), 0, {}});
  Solver solver(scene);
  const ThermalBody body{0, tissues::liver().heat};
  Cautery cautery(solver.tissue(), std::span(&body, 1),
                  {.contact_radius = kRadius, .electrode_cooling = 0, .link_energy = 1e3});
  const Eigen::Vector3d half(length / 2, 0, 0);
  const CauteryReport report =
      cautery.update(solver, {(top - half).cast<float>(), (top + half).cast<float>()},
                     known_current_settings(0.05), 1e-4);
  REQUIRE(report.contact_links == 1);
  const double whole = 1 / (report.resistance - CauteryOptions{}.body_resistance);  // S
  const double voltage = 0.05 / whole;
  // of tissue within one radius of the electrode's surface of contact
  double power = 0, volume = 0;
  for (std::size_t i = 0; i < cautery.potential().vertices().size(); ++i) {
    const Eigen::Vector3d x = mesh.positions()[cautery.potential().vertices()[i]] - top;
    const double along = std::max(0.0, std::abs(x.x()) - length / 2);
    if (Eigen::Vector3d(along, x.y(), x.z()).norm() < 1.5 * kRadius) {
      power += voltage * voltage * cautery.potential().vertex_heat()[i];
      volume += cautery.field().mesh().volume_share(cautery.potential().vertices()[i]);
    }
  }
  const double of_link = cautery.link_energy_spent() / 1e-4 / kLinkVolume;
  CHECK(of_link > 0.4 * power / volume);
  CHECK(of_link < 2.5 * power / volume);
}

}  // namespace pbdsurg
