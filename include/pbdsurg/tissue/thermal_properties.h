// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Thermal and electrical properties of tissue near body temperature, and how fast heat damages it.
///
/// Sources, by the marks used below:
/// [I] averages of the IT'IS database, as reprinted by COMSOL's bioheat library; [i] the same
///     database as commonly quoted, not looked up;
/// [G] Gabriel, Lau and Gabriel 1996, Phys. Med. Biol. 41:2271, their four-term Cole-Cole model
///     evaluated at 500 kHz;
/// [C] COMSOL's bioheat library, damage of liver and of fat;
/// [P] Pearce 2010, Crit. Rev. Biomed. Eng. 38:1, collagen, as commonly quoted.
/// Water contents are common literature values. What is called a proxy is borrowed from another
/// tissue. Replace by measured values where results depend on them; most of all the electrical
/// conductivity of liver, where sources give 0.15 to 0.40 S/m.

#include <string>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/export.h"

namespace pbdsurg {

inline constexpr double kBodyTemperature = 37;         ///< degrees Celsius
inline constexpr double kBoilingTemperature = 100;     ///< degrees Celsius
inline constexpr double kLatentHeatOfWater = 2.257e6;  ///< J/kg, at 100 degrees Celsius
inline constexpr double kDensityOfWater = 1000;        ///< kg/m^3
inline constexpr double kSpecificHeatOfWater = 4186;   ///< J/(kg K)
/// J/(kg K), of protein and fat alike (Choi and Okos 1986).
inline constexpr double kSpecificHeatOfSolids = 2000;

/// A first-order process of rate A exp(-E / (R T)). A itself does not fit a float; its logarithm
/// does.
struct DamageKinetics {
  double log_frequency;      ///< natural logarithm of A in 1/s
  double activation_energy;  ///< E, J/mol
};

inline constexpr DamageKinetics kLiverCoagulation{91.800946, 2.577e5};      // A = 7.39e39 [C]
inline constexpr DamageKinetics kFatDamage{38.329761, 1.30e5};              // A = 4.43e16 [C]
inline constexpr DamageKinetics kCollagenDenaturation{104.090076, 3.06e5};  // A = 1.606e45 [P]
/// Epidermis, A = 3.1e98 (Henriques 1947, as commonly quoted).
inline constexpr DamageKinetics kSkinBurn{226.784741, 6.28e5};

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
  DamageKinetics damage{kLiverCoagulation};
  /// 1/K, b of the conductivity of heat k (1 + b (T - 37)), constant from 100 degrees on; positive
  /// there and at 0: (-1/63, 1/37). Ablation models take some 0.002, as commonly quoted; results
  /// hardly depend on it (Dodde et al. 2008). 0 costs nothing.
  double conductivity_rise{0};
};

/// 1/s from the usual unit of perfusion, ml of blood per minute and kg of tissue.
constexpr double perfusion_per_second(double ml_per_minute_and_kg, double density) {
  return ml_per_minute_and_kg * 1e-6 / 60 * density;
}

/// [I]; perfusion [i]; of the electrical conductivities between Gabriel's 0.148 and the 0.33 that
/// is usual for ablation, near that of fresh pig liver (0.22, Wang et al. 2014).
inline constexpr ThermalProperties kLiver{
    1079, 3540, 0.52, 0.72, 0.30, perfusion_per_second(860, 1079), 0, kLiverCoagulation};

/// [i], [G]; damage of liver as a proxy.
inline constexpr ThermalProperties kGallbladderWall{
    1071, 3716, 0.52, 0.75, 0.90, perfusion_per_second(30, 1071), 0.3, kLiverCoagulation};

/// [I], [G] average infiltrated fat; perfusion [i].
inline constexpr ThermalProperties kFat{
    911, 2348, 0.21, 0.15, 0.044, perfusion_per_second(33, 911), 0, kFatDamage};

/// Connective tissue [i]; electrically between aorta (0.324), tendon (0.391) and dura (0.503) of
/// [G], as a proxy.
inline constexpr ThermalProperties kMembrane{
    1027, 2372, 0.39, 0.62, 0.35, perfusion_per_second(37, 1027), 0.3, kCollagenDenaturation};

/// Gallbladder wall as a proxy: the ducts continue its layers.
inline constexpr ThermalProperties kDuct = kGallbladderWall;

/// Vessel wall [i], aorta of [G]; damage of collagen as a proxy.
inline constexpr ThermalProperties kArtery{
    1102, 3306, 0.46, 0.67, 0.324, perfusion_per_second(150, 1102), 0.3, kCollagenDenaturation};

/// [i], [G]; damage of liver as a proxy.
inline constexpr ThermalProperties kBlood{1050, 3617, 0.52, 0.79, 0.748, 0, 0, kLiverCoagulation};

/// @throws InvalidArgument  naming the property that is out of range: density, specific heat and
///                          conductivity are positive, water fraction in [0, 1], electrical
///                          conductivity and perfusion not negative, contraction in [0, 1), damage
///                          kinetics finite with a positive energy; all finite
PBDSURG_API void check_thermal_properties(const ThermalProperties& tissue);

/// What no soft tissue has, each as a sentence with property, value and usual range: mostly a unit
/// mistaken. Empty for all tissues above. A tissue may be valid and unphysical, as those of the
/// paper's presets are.
PBDSURG_API std::vector<std::string> find_unphysical(const ThermalProperties& tissue);

}  // namespace pbdsurg
