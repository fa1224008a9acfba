// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which physics of heat is switched on, with presets for a comparison with the paper.

#include <cstdint>
#include <optional>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/tissue/thermal_properties.h"

namespace pbdsurg {

/// When heat takes a tetrahedron away.
enum class RemovalRule : std::uint8_t {
  /// when its water has boiled away. It depends on the mesh: 30 W for 1 s remove 5.8 to 7.3 mm^3 of
  /// liver on edges of 0.4 to 1.0 mm, 50 W 7.7 to 10.9 (scripts/tables --only lesion)
  water,
  boiled_vertices,  ///< once all four vertices have boiled (algorithm 2 of Pan et al. 2020)
};

/// What colours follow.
enum class ColorRule : std::uint8_t {
  state,        ///< damage, water and char, which do not go back
  temperature,  ///< the highest temperature so far (equation 7 of Pan et al. 2020)
};

/// Presets only fill this in: each setting stands for itself.
struct PBDSURG_API ThermalModel {
  bool has_latent_heat = true;            ///< boiling takes energy and water
  bool has_variable_conductivity = true;  ///< electrical, with temperature and water
  bool has_perfusion = false;   ///< blood cools; seconds of burning hardly notice (liver: 65 s)
  double surface_transfer = 0;  ///< W/(m^2 K) to the ambient; free convection has 5 to 25
  /// degrees Celsius; where surface_transfer > 0, one farther from 37 than HeatOptions::active_rise
  /// has all surfaces take part
  double ambient_temperature{37};
  RemovalRule removal = RemovalRule::water;  ///< when tetrahedra go
  double dry_water = 0.05;             ///< share of its water at which tissue counts as dry, (0, 1)
  ColorRule color = ColorRule::state;  ///< what colours follow
  /// Of the theta method, [1/2, 1]: 1 never overshoots, 1/2 is of second order. It is the gamma of
  /// Newmark's scheme, whose beta weighs a second derivative that heat does not have.
  double theta = 1;
  std::optional<ThermalProperties> tissue;  ///< what all bodies are made of, instead of their own

  /// Physics as it is known: all defaults.
  static ThermalModel physical();

  /// The paper's model and its numbers, density and specific heat read as 3 g/cm^3 and 0.3 J/(g K):
  /// 3000 kg/m^3, 300 J/(kg K); as printed, 3 and 0.3, heat would cross 20 cm in a frame. Neither
  /// latent heat nor variable conductivity nor perfusion.
  static ThermalModel paper();
};

/// @throws InvalidArgument  naming the setting out of range, a removal rule that would never
///                          remove, or a property of the tissue
PBDSURG_API void check_model(const ThermalModel& model);

}  // namespace pbdsurg
