// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/thermal_model.h"

#include <cmath>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"

namespace pbdsurg {

ThermalModel ThermalModel::physical() {
  return {};
}

ThermalModel ThermalModel::paper() {
  ThermalModel model;
  model.has_latent_heat = false;
  model.has_variable_conductivity = false;
  model.removal = RemovalRule::boiled_vertices;
  model.color = ColorRule::temperature;
  model.tissue = ThermalProperties{3000, 300, 0.512, 0, 0.9};
  return model;
}

void check_model(const ThermalModel& model) {
  check_not_negative("surface_transfer", model.surface_transfer);
  check(std::isfinite(model.ambient_temperature), "ambient_temperature", model.ambient_temperature,
        "finite");
  check(model.dry_water > 0 && model.dry_water < 1, "dry_water", model.dry_water, "in (0, 1)");
  check_range("theta", model.theta, 0.5, 1);
  if (model.removal == RemovalRule::water && !model.has_latent_heat) {
    throw InvalidArgument("removal waits for the water to go; it needs has_latent_heat");
  }
  if (model.tissue) {
    check_thermal_properties(*model.tissue);
  }
}

}  // namespace pbdsurg
