// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Thermal and electrical properties of tissue near body temperature, and how fast heat damages it.
///
/// Sources of the kinetics, by the marks used below:
/// [C] COMSOL's bioheat library, damage of liver and of fat;
/// [P] Pearce 2010, Crit. Rev. Biomed. Eng. 38:1, collagen, as commonly quoted.
/// The tissues themselves are in tissue/library.h.

#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

inline constexpr double kBodyTemperature = 37;         ///< degrees Celsius
inline constexpr double kBoilingTemperature = 100;     ///< degrees Celsius
inline constexpr double kLatentHeatOfWater = 2.257e6;  ///< J/kg, at 100 degrees Celsius
inline constexpr double kDensityOfWater = 1000;        ///< kg/m^3
inline constexpr double kSpecificHeatOfWater = 4186;   ///< J/(kg K)
inline constexpr double kDensityOfBlood = 1050;        ///< kg/m^3 [i] of tissue/library.h
inline constexpr double kSpecificHeatOfBlood = 3617;   ///< J/(kg K), of the same source
/// J/(kg K), of protein and fat alike (Choi and Okos 1986).
inline constexpr double kSpecificHeatOfSolids = 2000;

/// A first-order process of rate A exp(-E / (R T)). A itself does not fit a float; its logarithm
/// does.
struct DamageKinetics {
  double log_frequency;      ///< natural logarithm of A in 1/s
  double activation_energy;  ///< E, J/mol
};

/// Liver, A = 7.39e39 [C].
inline constexpr DamageKinetics kLiverCoagulation{91.800946, 2.577e5};
/// Fat, A = 4.43e16 [C].
inline constexpr DamageKinetics kFatDamage{38.329761, 1.30e5};
/// Collagen, A = 1.606e45 [P].
inline constexpr DamageKinetics kCollagenDenaturation{104.090076, 3.06e5};
/// Epidermis, A = 3.1e98 (Henriques 1947, as commonly quoted).
inline constexpr DamageKinetics kSkinBurn{226.784741, 6.28e5};

/// How a tissue conducts heat and current, boils and is damaged.
struct ThermalProperties {
  double density;                     ///< kg/m^3
  double specific_heat;               ///< J/(kg K), of moist tissue
  double conductivity;                ///< W/(m K), of heat
  double water_fraction;              ///< mass of water per mass of tissue, [0, 1]
  double electrical_conductivity{0};  ///< S/m, at 500 kHz and 37 degrees Celsius
  double perfusion{0};                ///< 1/s, volume of blood per volume of tissue and second
  /// Largest share by which lengths contract as collagen denatures, [0, 1): tissue without much of
  /// it has zero. About 0.3 along fibres (literature).
  double collagen_contraction{0};
  DamageKinetics damage{kLiverCoagulation};  ///< how it coagulates
  /// 1/K, b of the conductivity of heat k (1 + b (T - 37)), constant from 100 degrees on; positive
  /// there and at 0: (-1/63, 1/37). Ablation models take some 0.002, as commonly quoted; results
  /// hardly depend on it (Dodde et al. 2008). 0 costs nothing.
  double conductivity_rise{0};
  /// How many times as stiff it is once it has coagulated, in [1, 100].
  double coagulated_stiffness{1};
};

/// 1/s from the usual unit of perfusion, ml of blood per minute and kg of tissue.
constexpr double perfusion_per_second(double ml_per_minute_and_kg, double density) {
  return ml_per_minute_and_kg * 1e-6 / 60 * density;
}

/// @throws InvalidArgument  naming the property that is out of range: density, specific heat and
///                          conductivity are positive, water fraction in [0, 1], electrical
///                          conductivity and perfusion not negative, contraction in [0, 1), damage
///                          kinetics finite with a positive energy, coagulated stiffness in
///                          [1, 100]; all finite
PBDSURG_API void check_thermal_properties(const ThermalProperties& tissue);

/// What no soft tissue has, each as a sentence with property, value and usual range: mostly a unit
/// mistaken. A tissue may be valid and unphysical, as those of the
/// paper's presets are.
PBDSURG_API std::vector<std::string> find_unphysical(const ThermalProperties& tissue);

}  // namespace pbdsurg
