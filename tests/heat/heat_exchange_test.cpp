// SPDX-License-Identifier: Apache-2.0
// Heat that the surface and blood exchange with what is around, against closed forms. Where a
// tolerance is not of rounding, it is the error measured with another program of the same method,
// with some room.
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/conduction_problems.h"
#include "tests/support/heat_meshes.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using testing::all_of;
using testing::Approx;
using testing::dry_model;
using testing::is_face;
using testing::kExact;
using testing::kLiver;
using testing::largest_error;
using testing::make_box;
using testing::make_jittered_box;
using testing::set_profile;
using testing::settle;
using testing::vertices_where;

const ThermalProperties& kBlood = tissues::blood().heat;

}  // namespace

// A slab between T1 and an ambient: q = (T1 - Ta) / (L/k + 1/h), T linear (Incropera, Fundamentals
// of Heat Transfer, 3.1). The sides are held at that, since all of the surface loses heat.
TEST_CASE("heat conduction: a slab that loses heat at its face is exact", "[validation]") {
  constexpr double kLength = 6e-3, kTransfer = 200;
  const TetMesh mesh = make_jittered_box({6, 6, 6}, 1e-3, 0.25);
  ThermalModel model = dry_model();
  model.surface_transfer = kTransfer;
  model.ambient_temperature = 20;
  const double flux = (90 - 20.0) / (kLength / kLiver.conductivity + 1 / kTransfer);
  const auto linear = [&](const Eigen::Vector3d& x) {
    return 90 - flux / kLiver.conductivity * x.x();
  };
  HeatField field(mesh, kLiver, model, kExact);
  const auto is_side = [&](const Eigen::Vector3d& x) {
    return x.x() == 0 || x.y() == 0 || x.z() == 0 || x.y() > 0.9999 * kLength ||
           x.z() > 0.9999 * kLength;
  };
  const std::vector<Index> sides = vertices_where(mesh, is_side);
  set_profile(field, sides, linear);
  field.hold(sides);
  CHECK(settle(field));
  CHECK(largest_error(field, linear) < 1e-7);
  // held vertices do not lose by themselves: of 6 x 6 cells, the 5 x 5 inner vertices do
  const double before = field.ledger().surface;
  field.step(1, {});
  CHECK(field.ledger().surface - before == Approx(25e-6 * flux).epsilon(1e-8));
}

// Pennes 1948: rho c dT/dt = -G (T - T_body); with the sign wrong, tissue would run away. A body at
// one temperature is an ordinary equation: T_body + (T0 - T_body) exp(-G t / (rho c)).
TEST_CASE("heat conduction: blood brings warm and cold tissue to its own temperature",
          "[validation]") {
  const double start = GENERATE(42.0, 30.0);
  const TetMesh mesh = make_jittered_box({3, 3, 3}, 1e-3, 0.2);
  ThermalModel model = dry_model(0.5);
  model.has_perfusion = true;
  HeatField field(mesh, kLiver, model, kExact);
  set_profile(field, all_of(mesh), [&](const Eigen::Vector3d&) { return start; });
  for (int i = 0; i < 60; ++i) {
    field.step(1, {});
  }
  const double rate = kLiver.perfusion * kBlood.density * kBlood.specific_heat /
                      (kLiver.density * kLiver.specific_heat);
  CHECK(1 / rate == Approx(65).epsilon(0.02));  // s
  const double expected = 37 + (start - 37) * std::exp(-60 * rate);
  CHECK(largest_error(field, [&](const Eigen::Vector3d&) { return expected; }) < 1e-4);
  CHECK(field.ledger().perfusion ==
        Approx(field.ledger().in - field.ledger().sensible).epsilon(1e-12));
}

// Perfused fin: (T - T_body) / (Ts - T_body) = cosh((L - x)/d) / cosh(L/d), d = sqrt(k/G).
TEST_CASE("heat conduction: perfusion limits how far heat reaches", "[validation]") {
  constexpr double kLength = 15e-3;
  ThermalModel model = dry_model();
  model.has_perfusion = true;
  const double depth =
      std::sqrt(kLiver.conductivity / (kLiver.perfusion * kBlood.density * kBlood.specific_heat));
  // 5 K, where tissue is not yet damaged; tolerances are those for 63 K, scaled
  const auto [edge, tolerance] =
      GENERATE(table<double, double>({{1e-3, 0.15}, {0.5e-3, 0.04}, {0.25e-3, 0.01}}));
  const TetMesh bar = make_box({static_cast<Index>(std::lround(kLength / edge)), 1, 1}, edge);
  HeatField field(bar, kLiver, model, kExact);
  const std::vector<Index> face = vertices_where(bar, is_face);
  set_profile(field, face, [](const Eigen::Vector3d&) { return 42; });
  field.hold(face);
  CHECK(settle(field));
  CHECK(largest_error(field, [&](const Eigen::Vector3d& x) {
          return 37 + 5 * std::cosh((kLength - x.x()) / depth) / std::cosh(kLength / depth);
        }) < tolerance * 5 / 63);
}

// Would catch perfusion that goes on in coagulated tissue.
TEST_CASE("heat conduction: coagulated tissue does not bleed", "[unit]") {
  const TetMesh mesh = make_box({2, 2, 2}, 1e-3);
  ThermalModel model = dry_model();
  model.has_perfusion = true;
  HeatField field(mesh, kLiver, model, kExact);
  set_profile(field, all_of(mesh), [](const Eigen::Vector3d&) { return 95; });
  field.step(0.1, {});
  REQUIRE(field.survival()[0] < 1e-6);
  const double before = field.ledger().perfusion;
  field.step(1, {});
  CHECK(field.ledger().perfusion - before < 1e-5 * field.ledger().sensible);
}

// A body so small that its inside is at one temperature (Biot number 0.003) cools as
// Ta + (T0 - Ta) exp(-h A t / (rho c V)) (Incropera, 5.1).
TEST_CASE("heat conduction: a small body cools through its surface", "[validation]") {
  const TetMesh mesh = make_jittered_box({4, 4, 4}, 0.25e-3, 0.2);
  ThermalModel model = dry_model();
  model.surface_transfer = 10;
  model.ambient_temperature = 20;
  HeatField field(mesh, kLiver, model, kExact);
  set_profile(field, all_of(mesh), [](const Eigen::Vector3d&) { return 40; });
  const double rate = 10 * 6e-6 / (kLiver.density * kLiver.specific_heat * 1e-9);
  for (int i = 0; i < 400; ++i) {
    field.step(1 / (400 * rate), {});
  }
  CHECK(field.temperatures()[0] - 20 == Approx(20 * std::exp(-1)).epsilon(0.01));
  const HeatLedger& ledger = field.ledger();
  CHECK(ledger.surface == Approx(ledger.in - ledger.sensible).epsilon(1e-12));
}

// The product of three slabs' series (Incropera, 5.5), from body temperature. Would catch a surface
// that rests since its tissue is as warm as blood, whatever the air is.
TEST_CASE("heat exchange: an ambient cools tissue at body temperature", "[validation]") {
  constexpr double kHalf = 5e-3, kTransfer = 200, kTime = 60;
  constexpr Index kCells = 8;
  const double biot = kTransfer * kHalf / kLiver.conductivity;
  const double fourier =
      kLiver.conductivity / (kLiver.density * kLiver.specific_heat) * kTime / (kHalf * kHalf);
  const auto slab = [&](double x) {  // x from the middle, of the half width
    double sum = 0;
    for (int n = 0; n < 20; ++n) {
      double low = n * std::numbers::pi, high = low + std::numbers::pi / 2;
      for (int i = 0; i < 60; ++i) {
        const double zeta = (low + high) / 2;
        (zeta * std::tan(zeta) < biot ? low : high) = zeta;
      }
      const double factor = 4 * std::sin(low) / (2 * low + std::sin(2 * low));
      sum += factor * std::exp(-low * low * fourier) * std::cos(low * x);
    }
    return sum;
  };
  ThermalModel model;
  model.surface_transfer = kTransfer;
  model.ambient_temperature = 20;
  HeatField field(make_box({kCells, kCells, kCells}, 2 * kHalf / kCells), kLiver, model);
  for (int i = 0; i < 240; ++i) {
    CHECK(field.step(kTime / 240, {}).active_vertices > 0);
  }
  const Index middle = (kCells / 2) * (1 + (kCells + 1) * (1 + (kCells + 1)));
  CHECK(field.temperatures()[middle] == Approx(20 + 17 * std::pow(slab(0), 3)).margin(0.15));
  CHECK(field.temperatures()[0] == Approx(20 + 17 * std::pow(slab(1), 3)).margin(0.15));
  CHECK(field.ledger().surface > 0);
  CHECK(field.ledger().sensible == Approx(-field.ledger().surface).epsilon(1e-9));

  // as near as active_rise is too near to count, and costs nothing
  model.ambient_temperature = kBodyTemperature + 0.05;
  HeatField resting(make_box({2, 2, 2}, 1e-3), kLiver, model);
  CHECK(resting.step(1, {}).active_vertices == 0);
}

// Would catch a surface that a cut opened and that stays warm.
TEST_CASE("heat exchange: an ambient cools what an edit lays open", "[unit]") {
  Scene scene;
  const TetMesh mesh = make_box({6, 6, 6}, 5e-3);
  scene.add_body("block", mesh);
  Tissue tissue(scene);
  const ThermalBody body{0, kLiver};
  ThermalModel model;
  model.surface_transfer = 200;
  model.ambient_temperature = 20;
  HeatField field(tissue, std::span(&body, 1), model);
  TopologyEdit edit;
  const Eigen::Vector3d inside(15e-3, 15e-3, 15e-3);
  Index laid_open = kInvalidIndex;
  for (Index t = 0; t < mesh.tet_count(); ++t) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Index v : mesh.tets()[t]) {
      middle += mesh.positions()[v] / 4;
    }
    if ((middle - inside).head<2>().cwiseAbs().maxCoeff() < 5e-3) {  // a shaft right through
      edit.remove_tets.push_back(t);
    }
  }
  for (Index v = 0; v < static_cast<Index>(mesh.positions().size()); ++v) {
    if ((mesh.positions()[v] - (inside + Eigen::Vector3d(5e-3, 0, 0))).norm() < 1e-6) {
      laid_open = v;
    }
  }
  field.step(1, {});
  CHECK(field.temperatures()[laid_open] == Approx(kBodyTemperature).margin(1e-3));
  tissue.apply(edit);
  for (int i = 0; i < 10; ++i) {
    field.step(1, {});
  }
  CHECK(field.temperatures()[laid_open] < kBodyTemperature - 1);
}

}  // namespace pbdsurg
