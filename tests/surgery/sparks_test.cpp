// SPDX-License-Identifier: Apache-2.0
// Sparks of the cutting mode, to what is not quite touched and through what is dry.
#include <numbers>
#include <span>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"

namespace pbdsurg {
namespace {

using testing::CauteryBlock;
using testing::point;

constexpr double kReach = 1.26e-3;  // m, of a touch
constexpr double kTop = 4e-3;       // m

struct Held {
  Held() : solver(block.scene, {.damping = 20}), cautery(solver.tissue(), std::span(&body, 1)) {}

  // The tip above the top, by more than it touches from.
  CauteryReport update(double gap, const GeneratorSettings& settings) {
    const auto height = static_cast<float>(kTop + kReach + gap);
    return cautery.update(solver, point({4e-3F, 4e-3F, height}), settings, 1e-3);
  }

  CauteryBlock block;
  Solver solver;
  ThermalBody body{0, tissues::liver().heat};
  Cautery cautery;
};

}  // namespace

// Would catch sparks of a mode that has none, and such as reach farther than they do.
TEST_CASE("sparks: in cutting mode they jump 0.3 mm to wet tissue", "[unit]") {
  const CauteryReport near = Held().update(0.1e-3, cut_settings(40));
  CHECK(near.is_arcing);
  CHECK(near.energy > 0);
  CHECK(near.energy + near.electrode_energy + near.body_energy ==
        testing::Approx(near.generator_energy).epsilon(1e-9));

  const CauteryReport far = Held().update(0.5e-3, cut_settings(40));
  CHECK_FALSE(far.is_arcing);
  CHECK(far.energy == 0);

  const CauteryReport soft = Held().update(0.1e-3, coagulate_settings(40));
  CHECK_FALSE(soft.is_arcing);
  CHECK(soft.energy == 0);
}

// Would catch a spark without the voltage that it takes.
TEST_CASE("sparks: none below the voltage at which they start", "[unit]") {
  GeneratorSettings settings = cut_settings(40);
  settings.voltage_limit = 0.9 * kArcVoltage / std::numbers::sqrt2;
  const CauteryReport report = Held().update(0.1e-3, settings);
  CHECK_FALSE(report.is_arcing);
  CHECK(report.energy == 0);
}

// Would catch a dry layer that ends a cut for good. Steam tears nothing here, so it stays.
TEST_CASE("sparks: they go through dry tissue, where touch alone ends", "[unit]") {
  const auto late_energy = [](const GeneratorSettings& settings) {
    const CauteryBlock block;
    Solver solver(block.scene, {.damping = 20});
    const ThermalBody body{0, tissues::liver().heat};
    CauteryOptions options;
    options.tearing_rate = 1e6;
    options.model.dry_water = 0.02;
    Cautery cautery(solver.tissue(), std::span(&body, 1), options);
    double energy = 0;
    bool has_arced = false;
    for (int i = 0; i < 300; ++i) {
      const CauteryReport report = cautery.update(solver, testing::kOnTop, settings, 5e-3);
      energy += i >= 200 ? report.energy : 0;
      has_arced = has_arced || report.is_arcing;
    }
    CHECK(has_arced == (settings.mode == GeneratorMode::cut));
    return energy;
  };
  CHECK(late_energy(cut_settings(40)) > 2 * late_energy(coagulate_settings(40)));
}

}  // namespace pbdsurg
