// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Means of a heat field over the vertices of a tetrahedron.

#include "pbdsurg/heat/heat_field.h"

namespace pbdsurg {

/// Share of water left.
[[nodiscard]] inline double mean_water(const HeatField& field, Index tet) {
  double water = 0;
  for (const Index v : field.mesh().tets()[tet]) {
    water += field.water()[v] / 4;
  }
  return water;
}

/// Share that lives.
[[nodiscard]] inline double mean_survival(const HeatField& field, Index tet) {
  double survival = 0;
  for (const Index v : field.mesh().tets()[tet]) {
    survival += field.survival()[v] / 4;
  }
  return survival;
}

/// Degrees Celsius.
[[nodiscard]] inline double mean_temperature(const HeatField& field, Index tet) {
  double temperature = 0;
  for (const Index v : field.mesh().tets()[tet]) {
    temperature += field.temperatures()[v] / 4;
  }
  return temperature;
}

}  // namespace pbdsurg
