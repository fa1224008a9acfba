// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/thermal_properties.h"

#include <cmath>
#include <sstream>

#include "pbdsurg/core/error.h"

namespace pbdsurg {
namespace {

std::string statement(const char* what, double value, const std::string& rule) {
  std::ostringstream text;
  text << "tissue " << what << " is " << value << "; " << rule;
  return text.str();
}

void require(bool holds, const char* what, double value, const char* rule) {
  if (!holds || !std::isfinite(value)) {
    throw InvalidArgument(statement(what, value, rule));
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
}

std::vector<std::string> find_unphysical(const ThermalProperties& tissue) {
  std::vector<std::string> found;
  const auto expect = [&](const char* what, double value, double low, double high,
                          const char* unit) {
    if (!(value >= low && value <= high)) {
      std::ostringstream rule;
      rule << "soft tissue has " << low << " to " << high << " " << unit;
      found.push_back(statement(what, value, rule.str()));
    }
  };
  expect("density", tissue.density, 200, 3000, "kg/m^3");
  expect("specific heat", tissue.specific_heat, 500, 5000, "J/(kg K)");
  expect("conductivity", tissue.conductivity, 0.05, 2, "W/(m K)");
  expect("diffusivity", tissue.conductivity / (tissue.density * tissue.specific_heat), 5e-8, 1e-6,
         "m^2/s");
  expect("electrical conductivity", tissue.electrical_conductivity, 1e-4, 3, "S/m");
  expect("perfusion", tissue.perfusion, 0, 0.2, "1/s");
  return found;
}

}  // namespace pbdsurg
