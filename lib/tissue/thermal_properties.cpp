// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/thermal_properties.h"

#include <cmath>

#include "pbdsurg/base/error.h"

#include "lib/tissue/usual_ranges.h"

namespace pbdsurg {
namespace {

void require(bool holds, const char* what, double value, const char* rule) {
  if (!holds || !std::isfinite(value)) {
    throw InvalidArgument(tissue_statement(what, value, rule));
  }
}

}  // namespace

void check_thermal_properties(const ThermalProperties& tissue) {
  const auto positive = [](const char* what, double value) {
    require(value > 0, what, value, "it must be positive and finite");
  };
  const auto not_negative = [](const char* what, double value) {
    require(value >= 0, what, value, "it must be finite and not negative");
  };
  positive("density", tissue.density);
  positive("specific heat", tissue.specific_heat);
  positive("conductivity", tissue.conductivity);
  require(tissue.water_fraction >= 0 && tissue.water_fraction <= 1, "water fraction",
          tissue.water_fraction, "it must be in [0, 1]");
  not_negative("electrical conductivity", tissue.electrical_conductivity);
  not_negative("perfusion", tissue.perfusion);
  require(tissue.collagen_contraction >= 0 && tissue.collagen_contraction < 1,
          "collagen contraction", tissue.collagen_contraction, "it must be in [0, 1)");
  require(true, "log_frequency of damage", tissue.damage.log_frequency, "it must be finite");
  positive("activation energy of damage", tissue.damage.activation_energy);
  require(tissue.conductivity_rise > -1 / (kBoilingTemperature - kBodyTemperature) &&
              tissue.conductivity_rise < 1 / kBodyTemperature,
          "conductivity rise", tissue.conductivity_rise, "it must be in (-1/63, 1/37) per K");
  require(tissue.coagulated_stiffness >= 1 && tissue.coagulated_stiffness <= 100,
          "coagulated stiffness", tissue.coagulated_stiffness, "it must be in [1, 100]");
}

std::vector<std::string> find_unphysical(const ThermalProperties& tissue) {
  std::vector<std::string> found;
  expect_usual(found, "density", tissue.density, 200, 3000, "kg/m^3");
  expect_usual(found, "specific heat", tissue.specific_heat, 500, 5000, "J/(kg K)");
  expect_usual(found, "conductivity", tissue.conductivity, 0.05, 2, "W/(m K)");
  expect_usual(found, "diffusivity", tissue.conductivity / (tissue.density * tissue.specific_heat),
               5e-8, 1e-6, "m^2/s");
  expect_usual(found, "electrical conductivity", tissue.electrical_conductivity, 1e-4, 3, "S/m");
  expect_usual(found, "perfusion", tissue.perfusion, 0, 0.2, "1/s");
  return found;
}

}  // namespace pbdsurg
