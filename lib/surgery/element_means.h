// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Means of a heat field over the vertices of an element.

#include "pbdsurg/heat/heat_field.h"

namespace pbdsurg {

/// @param values  [vertex_count]
[[nodiscard]] inline double mean_of(std::span<const double> values, const ThermalMesh& mesh,
                                    Index element) {
  double sum = 0;
  for (const Index v : mesh.corners(element)) {
    sum += values[v] / corner_count(element);
  }
  return sum;
}

/// Share of water left.
[[nodiscard]] inline double mean_water(const HeatField& field, Index element) {
  return mean_of(field.water(), field.mesh(), element);
}

/// Share that lives.
[[nodiscard]] inline double mean_survival(const HeatField& field, Index element) {
  return mean_of(field.survival(), field.mesh(), element);
}

/// Degrees Celsius.
[[nodiscard]] inline double mean_temperature(const HeatField& field, Index element) {
  return mean_of(field.temperatures(), field.mesh(), element);
}

}  // namespace pbdsurg
