// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/tissue_state.h"

#include <cmath>
#include <limits>
#include <utility>

#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/heat_tissues.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kLiver;

const ThermalProperties& kMembrane = tissues::membrane().heat;

constexpr DamageKinetics kSets[] = {kLiverCoagulation, kFatDamage, kCollagenDenaturation,
                                    kSkinBurn};

// Temperature at which Omega is one after a time: E / (R ln(A t)), degrees Celsius.
double temperature_of_damage(const DamageKinetics& kinetics, double time) {
  return kinetics.activation_energy / (8.314462618 * (kinetics.log_frequency + std::log(time))) -
         273.15;
}

}  // namespace

// Omega(t) = A t exp(-E / (R T)) at a constant temperature (Henriques 1947). Would catch a slip of
// Kelvin and Celsius, of the gas constant, and a survival that depends on the step.
TEST_CASE("tissue state: damage at constant temperature follows its closed form", "[validation]") {
  CHECK(damage_rate(kLiverCoagulation, 60.0) * 3.43 == Approx(1).epsilon(2e-3));
  const std::pair<DamageKinetics, double> in_one_second[] = {{kLiverCoagulation, 64.5},
                                                             {kFatDamage, 135},
                                                             {kCollagenDenaturation, 80.4},
                                                             {kSkinBurn, 59.9}};
  for (const auto& [kinetics, expected] : in_one_second) {
    const double temperature = temperature_of_damage(kinetics, 1);
    CHECK(temperature == Approx(expected).epsilon(2e-3));
    double survival = 1;
    for (int i = 0; i < 40; ++i) {
      survival = surviving(kinetics, survival, temperature, 1.0 / 40);
    }
    CHECK(survival == Approx(std::exp(-1)).epsilon(1e-9));
  }
}

// A of liver does not fit a float, and one step at 1000 degrees is far beyond exp's range.
TEST_CASE("tissue state: damage is finite, monotone and the same in float and double",
          "[property]") {
  for (const DamageKinetics& kinetics : kSets) {
    double last = 0;
    for (double temperature = -273; temperature < 3000; temperature += 0.7) {
      const double rate = damage_rate(kinetics, temperature);
      CHECK((rate >= last && rate <= kMostDamageRate));
      last = rate;
      const float single = damage_rate(kinetics, static_cast<float>(temperature));
      CHECK(single == Approx(rate).epsilon(1e-3));
      const float survival = surviving(kinetics, 0.5F, static_cast<float>(temperature), 0.1F);
      CHECK((survival >= 0 && survival <= 0.5F));
    }
    CHECK(last == kMostDamageRate);
    CHECK(damage_rate(kinetics, std::numeric_limits<double>::infinity()) == kMostDamageRate);
    CHECK(damage_rate(kinetics, std::numeric_limits<double>::quiet_NaN()) == 0);
  }
}

// By its numbers alone, liver reaches Omega = 1 after 57 minutes in a healthy body.
TEST_CASE("tissue state: body temperature damages nothing, however long", "[unit]") {
  const double ungated = std::exp(kLiverCoagulation.log_frequency -
                                  kLiverCoagulation.activation_energy / (8.314462618 * 310.15));
  CHECK(1 / ungated / 60 == Approx(57).epsilon(0.01));
  CHECK(surviving(kLiverCoagulation, 1.0, kBodyTemperature, 1e9) == 1);
  CHECK(surviving(kLiverCoagulation, 1.0, kDamageTemperature, 1e9) == 1);
  CHECK(surviving(kLiverCoagulation, 1.0, kDamageTemperature + 0.01, 60.0) < 1);
}

// Would catch heat made or lost as water goes, water below zero, and a plateau that leaks.
TEST_CASE("tissue state: boiling keeps energy, and the plateau while water is left", "[property]") {
  for (const TissueRecord& record : tissues::all()) {
    const ThermalProperties& tissue = record.heat;
    for (std::uint64_t i = 0; i < 400; ++i) {
      const double water = i % 7 == 0 ? 1e-12 : random_unit(i, 0);
      // up to well beyond what boils everything away
      const double temperature = 60 + 2000 * std::pow(random_unit(i, 1), 3);
      const auto sensible = [&](double t, double w) {
        return specific_heat(tissue, w) * (t - kBodyTemperature);
      };
      const auto [after, left, steam] = boil(tissue, temperature, water);
      CHECK(sensible(after, left) + steam ==
            Approx(sensible(temperature, water)).epsilon(1e-13).margin(1e-9));
      CHECK((left >= 0 && left <= water));
      CHECK(steam >= 0);
      if (temperature <= kBoilingTemperature) {
        CHECK((after == temperature && left == water && steam == 0));
      } else {
        CHECK(after >= kBoilingTemperature);
        CHECK((left == 0 || after == kBoilingTemperature));
      }
      const auto single = boil(tissue, static_cast<float>(temperature), static_cast<float>(water));
      CHECK(single.water >= 0);
      CHECK((single.water == 0 || single.temperature <= 100));
    }
  }
}

// Uniform heating in an insulated box: boiling begins at rho c 63 K / q, all is dry after that plus
// rho w0 L / q, and the steam takes its own warmth along.
TEST_CASE("tissue state: the time to boil dry is that of its latent heat", "[validation]") {
  const double power = 1e9 / kLiver.density;  // W/kg
  const double dt = 1e-4;
  double temperature = kBodyTemperature, water = 1, boiling_at = 0, dry_at = 0;
  for (int i = 1; dry_at == 0; ++i) {
    temperature += power * dt / specific_heat(kLiver, water);
    const auto boiled = boil(kLiver, temperature, water);
    if (boiled.water < 1 && boiling_at == 0) {
      boiling_at = i * dt;
    }
    temperature = boiled.temperature;
    water = boiled.water;
    dry_at = water == 0 ? i * dt : 0;
  }
  CHECK(boiling_at == Approx(0.2406).margin(2 * dt));
  CHECK(dry_at - boiling_at ==
        Approx(kLiver.water_fraction * kLatentHeatOfWater / power).margin(2 * dt));
}

TEST_CASE("tissue state: tissue without water does not boil", "[unit]") {
  const ThermalProperties bone{1900, 1300, 0.3, 0};
  const auto [temperature, water, steam] = boil(bone, 150.0, 1.0);
  CHECK((temperature == 150 && water == 1 && steam == 0));
}

TEST_CASE("tissue state: specific heat goes from moist tissue to its solids", "[unit]") {
  for (const TissueRecord& record : tissues::all()) {
    const ThermalProperties& tissue = record.heat;
    CHECK(specific_heat(tissue, 1.0) == Approx(tissue.specific_heat).epsilon(1e-15));
    CHECK(specific_heat(tissue, 0.0) ==
          Approx(kSpecificHeatOfSolids * (1 - tissue.water_fraction)).epsilon(1e-12));
  }
  // what is given less than solids have keeps what it is given
  CHECK(specific_heat(ThermalProperties{3000, 300, 0.5, 0}, 0.0) == 300);
}

TEST_CASE("tissue state: char comes above 200 degrees, in time, and stays", "[unit]") {
  CHECK(charring(0.0, kCharringTemperature, 1e6) == 0);
  CHECK(charring(0.25, 20.0, 1e6) == 0.25);
  CHECK(charring(0.0, 1e9, 0.1) == Approx(1 - std::exp(-0.1 * kMostCharringRate)));
  CHECK(charring(0.0, 250.0, 0.1) == Approx(1 - std::exp(-0.05 * kMostCharringRate)));
  CHECK(charring(charring(0.1, 260.0, 0.02), 260.0, 0.03) == Approx(charring(0.1, 260.0, 0.05)));
  CHECK(charring(1.0, 500.0, 1.0) == 1);
}

// Would catch a jump, which would make a potential flicker, and a fall by the wrong decades.
TEST_CASE("tissue state: conductivity is smooth, rises with heat and falls with drying",
          "[property]") {
  const auto sigma = [](double t, double w) { return electrical_conductivity(kLiver, t, w); };
  CHECK(sigma(37, 1) == Approx(kLiver.electrical_conductivity));
  CHECK(sigma(47, 1) == Approx(1.15 * kLiver.electrical_conductivity));
  CHECK(sigma(500, 0.3) == sigma(100, 0.3));
  CHECK(sigma(100, 0) == Approx(0.01 * sigma(100, 1)));
  for (double t = -400; t < 400; t += 7) {
    double slope = 0;
    for (double w = 0; w < 0.999; w += 0.001) {
      const double rise = (sigma(t, w + 0.001) - sigma(t, w)) / 0.001;
      CHECK(rise > 0);
      if (w > 0) {
        CHECK((rise > slope && rise < 1.25 * slope));  // no kink
      }
      slope = rise;
    }
    CHECK(sigma(t, 0.5) > 0);
    CHECK(sigma(t + 1, 0.5) >= sigma(t, 0.5));
  }
}

// A layer that dries from the electrode on is two layers in series. Would catch a conductivity of
// the mean water, which lets current through a dry layer as long as what is behind it is wet.
TEST_CASE("tissue state: a cell that dries by a front has the resistance of its two layers",
          "[validation]") {
  constexpr double kThickness = 1e-3, kArea = 1e-6;  // m, m^2
  const double moist = electrical_conductivity(kLiver, 100.0, 1.0);
  for (double front = 0; front <= kThickness; front += kThickness / 16) {
    const double two_layers =
        front / (kDryConductivity * moist * kArea) + (kThickness - front) / (moist * kArea);
    const double water = 1 - front / kThickness;
    CHECK(kThickness / (electrical_conductivity(kLiver, 100.0, water) * kArea) ==
          Approx(two_layers).epsilon(1e-12));
  }
}

// Would catch dry tissue that gets as hot as a star, and heat that is lost where it does not.
TEST_CASE("tissue state: ablation bounds the temperature and keeps the energy", "[property]") {
  for (const double water : {0.0, 0.5, 1.0}) {
    for (const double before : {20.0, 499.0, 500.0, 501.0, 3083.0, 1e6}) {
      const auto [after, smoke] = ablate(kLiver, before, water);
      CHECK(after == std::min(before, kAblationTemperature));
      CHECK(smoke >= 0);
      CHECK(specific_heat(kLiver, water) * (before - after) == Approx(smoke).epsilon(1e-12));
    }
  }
}

// Pennes' term has had its sign wrong in print: blood cools what is hot.
TEST_CASE("tissue state: blood cools with the constant of Pennes until vessels are coagulated",
          "[unit]") {
  CHECK(perfusion_cooling(kLiver, 1.0) == Approx(5.9e4).epsilon(0.01));
  CHECK(perfusion_cooling(kLiver, 0.0) == 0);
}

TEST_CASE("tissue state: shrinkage is monotone, positive and within what was measured",
          "[property]") {
  for (const TissueRecord& record : tissues::all()) {
    const ThermalProperties& tissue = record.heat;
    CHECK(shrunk_length(tissue, 1.0, 1.0) == 1);
    for (double water = 0; water <= 1; water += 0.05) {
      for (double collagen = 0; collagen <= 1; collagen += 0.05) {
        const double length = shrunk_length(tissue, water, collagen);
        CHECK((length > 0.4 && length <= 1));
        CHECK(shrunk_length(tissue, 0.9 * water, collagen) <= length);
        CHECK(shrunk_length(tissue, water, 0.9 * collagen) <= length);
      }
    }
  }
  // Farina et al. 2014: liver lost 52 to 74 % of its volume in a microwave field, not all dry
  CHECK(std::pow(shrunk_length(kLiver, 0.0, 1.0), 3) == Approx(1 - 0.72 * 1.079));
  CHECK(shrunk_length(kMembrane, 1.0, 0.0) == Approx(0.7));
  CHECK(shrunk_length(ThermalProperties{3000, 3000, 1, 1}, 0.0, 1.0) > 0);
}

// Algorithm 2 of Pan et al. 2020, and what water adds to it.
TEST_CASE("tissue state: a tetrahedron's state follows how many vertices boiled", "[unit]") {
  for (const RemovalRule rule : {RemovalRule::water, RemovalRule::boiled_vertices}) {
    CHECK(heat_state(rule, 0, 0, 0.05) == HeatState::normal);
    CHECK(heat_state(rule, 1, 0, 0.05) == HeatState::heated);
    CHECK(heat_state(rule, 2, 0, 0.05) == HeatState::burning);
    CHECK(heat_state(rule, 3, 0, 0.05) == HeatState::burning);
    CHECK(heat_state(rule, 4, 0.05, 0.05) == HeatState::vaporised);
  }
  CHECK(heat_state(RemovalRule::boiled_vertices, 4, 1, 0.05) == HeatState::vaporised);
  CHECK(heat_state(RemovalRule::water, 4, 0.06, 0.05) == HeatState::burning);
}

}  // namespace pbdsurg
