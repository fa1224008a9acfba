// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/thermal/thermal_model.h"

#include <cmath>
#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {
namespace {

ThermalModel paper_model(double density, double specific_heat) {
  ThermalModel model;
  model.has_latent_heat = false;
  model.has_variable_conductivity = false;
  model.removal = RemovalRule::boiled_vertices;
  model.color = ColorRule::temperature;
  model.tissue = TissueProperties{density, specific_heat, 0.512, 0, 0.9};
  return model;
}

[[noreturn]] void refuse(const char* what, double value, const char* rule) {
  throw InvalidArgument(std::string(what) + " is " + std::to_string(value) + "; it must be " +
                        rule);
}

}  // namespace

ThermalModel ThermalModel::physical() {
  return {};
}

ThermalModel ThermalModel::paper() {
  return paper_model(3000, 300);
}

ThermalModel ThermalModel::paper_literal() {
  return paper_model(3, 0.3);
}

void check_model(const ThermalModel& model) {
  if (!(model.surface_transfer >= 0) || !std::isfinite(model.surface_transfer)) {
    refuse("surface_transfer", model.surface_transfer, "finite and not negative");
  }
  if (!std::isfinite(model.ambient_temperature)) {
    refuse("ambient_temperature", model.ambient_temperature, "finite");
  }
  if (!(model.dry_water > 0 && model.dry_water < 1)) {
    refuse("dry_water", model.dry_water, "in (0, 1)");
  }
  if (!(model.theta >= 0.5 && model.theta <= 1)) {
    refuse("theta", model.theta, "in [0.5, 1]");
  }
  if (model.removal == RemovalRule::water && !model.has_latent_heat) {
    throw InvalidArgument("removal waits for the water to go; it needs has_latent_heat");
  }
  if (model.tissue) {
    check_tissue(*model.tissue);
  }
}

}  // namespace pbdsurg
