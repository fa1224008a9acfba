// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/thermal_properties.h"

#include <cmath>
#include <limits>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

const ThermalProperties& kLiver = tissues::liver().heat;
const ThermalProperties& kGallbladderWall = tissues::gallbladder_wall().heat;
const ThermalProperties& kFat = tissues::fat().heat;
const ThermalProperties& kMembrane = tissues::membrane().heat;
const ThermalProperties& kBlood = tissues::blood().heat;

}  // namespace

// Would catch a number in the wrong unit or column.
TEST_CASE("tissue: the table is valid, physical, and gives the scales of the literature",
          "[unit]") {
  for (const TissueRecord& record : tissues::all()) {
    const ThermalProperties& tissue = record.heat;
    CHECK_NOTHROW(check_thermal_properties(tissue));
    CHECK(find_unphysical(tissue).empty());
    // what is not water weighs something, and has a specific heat below that of water
    CHECK(kSpecificHeatOfSolids * (1 - tissue.water_fraction) < tissue.specific_heat);
    CHECK(tissue.specific_heat < kSpecificHeatOfWater);
  }
  // heating to 100 degrees and boiling dry, J/mm^3, and how much more that is than heating alone
  const auto to_boil = [](const ThermalProperties& t) {
    return t.density * t.specific_heat * (kBoilingTemperature - kBodyTemperature) * 1e-9;
  };
  const auto to_dry = [&](const ThermalProperties& t) {
    return to_boil(t) + t.density * t.water_fraction * kLatentHeatOfWater * 1e-9;
  };
  CHECK(to_boil(kLiver) == Approx(0.24).epsilon(0.02));
  CHECK(to_dry(kLiver) / to_boil(kLiver) == Approx(8.3).epsilon(0.01));
  CHECK(to_dry(kGallbladderWall) / to_boil(kGallbladderWall) == Approx(8.2).epsilon(0.01));
  CHECK(to_dry(kFat) / to_boil(kFat) == Approx(3.3).epsilon(0.01));
  CHECK(to_dry(kMembrane) / to_boil(kMembrane) == Approx(10.4).epsilon(0.01));
  // how fast blood cools liver (Pennes): rho c / (w rho_b c_b)
  CHECK(kLiver.density * kLiver.specific_heat /
            (kLiver.perfusion * kBlood.density * kBlood.specific_heat) ==
        Approx(65).epsilon(0.01));
  // A of the damage kinetics, as printed
  CHECK(kLiverCoagulation.log_frequency ==
        Approx(std::log(7.39) + 39 * std::log(10.0)).epsilon(1e-8));
  CHECK(kFatDamage.log_frequency == Approx(std::log(4.43e16)).epsilon(1e-8));
  CHECK(kCollagenDenaturation.log_frequency == Approx(std::log(1.606e45)).epsilon(1e-8));
  CHECK(kSkinBurn.log_frequency == Approx(std::log(3.1e98)).epsilon(1e-8));
}

TEST_CASE("tissue: bad properties are refused by name and value", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  const auto with = [](double ThermalProperties::*property, double value) {
    ThermalProperties tissue = kLiver;
    tissue.*property = value;
    return tissue;
  };
  using T = ThermalProperties;
  for (const double bad : {0.0, -1.0, nan, infinite}) {
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::density, bad)),
                      ContainsSubstring("density"));
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::specific_heat, bad)),
                      ContainsSubstring("specific heat"));
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::conductivity, bad)),
                      ContainsSubstring("conductivity"));
  }
  for (const double bad : {-0.1, nan, infinite}) {
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::water_fraction, bad)),
                      ContainsSubstring("water"));
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::electrical_conductivity, bad)),
                      ContainsSubstring("electrical"));
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::perfusion, bad)),
                      ContainsSubstring("perfusion"));
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::collagen_contraction, bad)),
                      ContainsSubstring("contraction"));
  }
  CHECK_THROWS_WITH(check_thermal_properties(with(&T::water_fraction, 1.5)),
                    ContainsSubstring("water fraction is 1.5"));
  CHECK_THROWS_AS(check_thermal_properties(with(&T::collagen_contraction, 1)), InvalidArgument);
  for (const double bad : {-1.0 / 63, 1.0 / 37, nan}) {  // no conductivity is left at 100, or at 0
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::conductivity_rise, bad)),
                      ContainsSubstring("conductivity rise"));
  }
  CHECK_NOTHROW(check_thermal_properties(with(&T::conductivity_rise, -0.015)));
  for (const double bad : {0.99, 101.0, nan}) {
    CHECK_THROWS_WITH(check_thermal_properties(with(&T::coagulated_stiffness, bad)),
                      ContainsSubstring("coagulated stiffness"));
  }
  ThermalProperties tissue = kLiver;
  tissue.damage.log_frequency = infinite;  // what A = exp(700) in a float would give
  CHECK_THROWS_WITH(check_thermal_properties(tissue), ContainsSubstring("damage"));
  tissue.damage = {90, 0};
  CHECK_THROWS_WITH(check_thermal_properties(tissue), ContainsSubstring("activation energy"));
}

// Units mistaken: g/cm^3, kcal, mS/cm and the like must not go unnoticed.
TEST_CASE("tissue: a mistaken unit is told", "[unit]") {
  ThermalProperties tissue = kLiver;
  tissue.density = 1.079;
  const auto found = find_unphysical(tissue);
  REQUIRE(found.size() == 2);
  CHECK(found[0] == "tissue density is 1.079; soft tissue has 200 to 3000 kg/m^3");
  CHECK_THAT(found[1], ContainsSubstring("diffusivity"));
  tissue = kLiver;
  tissue.electrical_conductivity = 300;
  CHECK(find_unphysical(tissue).size() == 1);
  tissue = kLiver;
  tissue.perfusion = 860;
  CHECK(find_unphysical(tissue).size() == 1);
}

}  // namespace pbdsurg
