// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What heat does to tissue, at one point: laws of state as plain functions, for host and device.
///
/// `Real` is float or double. Shares run from 1 (as in life) to 0 (nothing left); water, survival
/// and collagen never rise, char never falls. Temperatures are in degrees Celsius. Cost of each:
/// one exponential at most.

#include <cmath>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/heat/thermal_model.h"
#include "pbdsurg/tissue/thermal_properties.h"

namespace pbdsurg {

/// Mass-specific heat of tissue that has lost part of its water, J/(kg K) per kg of moist tissue:
/// from that of moist tissue down to that of its solids.
/// @param water  share left
template <class Real>
PBDSURG_HOST_DEVICE Real specific_heat(const ThermalProperties& tissue, Real water) {
  const auto moist = static_cast<Real>(tissue.specific_heat);
  const auto solids = static_cast<Real>((1 - tissue.water_fraction) * kSpecificHeatOfSolids);
  const Real dry = solids < moist ? solids : moist;
  return dry + (moist - dry) * water;
}

/// Tissue after boiling; all per kg of moist tissue.
template <class Real>
struct Boiled {
  Real temperature;  ///< degrees Celsius
  Real water;        ///< share left
  Real steam_heat;   ///< J/kg that the steam took along: latent heat, and what warmed that water
};

/// Boils what heat above the boiling temperature can: the excess-heat correction, for after a step
/// of conduction. While water is left, the temperature is 100 degrees afterwards. Conserves energy:
/// specific_heat() * (T - kBodyTemperature) before equals that after plus `steam_heat`.
template <class Real>
PBDSURG_HOST_DEVICE Boiled<Real> boil(const ThermalProperties& tissue, Real temperature,
                                      Real water) {
  const auto boiling = static_cast<Real>(kBoilingTemperature);
  const auto latent = static_cast<Real>(tissue.water_fraction * kLatentHeatOfWater);
  if (!(temperature > boiling && water > 0 && latent > 0)) {
    return {temperature, water, 0};
  }
  const Real before = specific_heat(tissue, water);
  const Real excess = before * (temperature - boiling);
  if (excess < latent * water) {
    const Real left = water - excess / latent;
    const Real gone = before - specific_heat(tissue, left);
    return {boiling, left, excess + gone * (boiling - static_cast<Real>(kBodyTemperature))};
  }
  const Real dry = specific_heat(tissue, Real{0});
  return {boiling + (excess - latent * water) / dry, 0,
          latent * water + (before - dry) * (boiling - static_cast<Real>(kBodyTemperature))};
}

/// Degrees Celsius at which what is left of dry tissue has gone as gas and smoke: thermogravimetry
/// of cartilage has its solids decompose up to 300 and degrade up to 500 degrees (Aparicio Rojas et
/// al. 2023, Heliyon 9:e14853), collagen fibres from 250 on.
inline constexpr double kAblationTemperature = 500;

/// Dry tissue after ablation; all per kg of moist tissue.
template <class Real>
struct Ablated {
  Real temperature;  ///< degrees Celsius, kAblationTemperature at most
  Real smoke_heat;   ///< J/kg that gas and smoke took along
};

/// Bounds how hot dry tissue becomes: heat beyond kAblationTemperature goes with its smoke. For
/// after boil(). Conserves energy as that does.
/// @param water  share left; while there is any, tissue is no hotter than boiling water
template <class Real>
PBDSURG_HOST_DEVICE Ablated<Real> ablate(const ThermalProperties& tissue, Real temperature,
                                         Real water) {
  const auto hottest = static_cast<Real>(kAblationTemperature);
  if (!(temperature > hottest)) {
    return {temperature, 0};
  }
  return {hottest, specific_heat(tissue, water) * (temperature - hottest)};
}

/// Below this temperature no damage is counted: by the numbers alone, liver would be gone after an
/// hour at body temperature.
inline constexpr double kDamageTemperature = 43;
inline constexpr double kMostDamageRate = 1e3;  ///< 1/s: what is faster is over at once anyway

/// Rate of damage, 1/s (Henriques 1947): zero up to kDamageTemperature, kMostDamageRate at most.
template <class Real>
PBDSURG_HOST_DEVICE Real damage_rate(const DamageKinetics& kinetics, Real temperature) {
  using std::exp;
  constexpr double kGasConstant = 8.314462618;  // J/(mol K)
  constexpr double kLogMostRate = 6.907755278982137;
  static_assert(kMostDamageRate == 1e3);
  if (!(temperature > static_cast<Real>(kDamageTemperature))) {
    return 0;
  }
  const Real exponent = static_cast<Real>(kinetics.log_frequency) -
                        static_cast<Real>(kinetics.activation_energy / kGasConstant) /
                            (temperature + static_cast<Real>(273.15));
  return exponent < static_cast<Real>(kLogMostRate) ? exp(exponent)
                                                    : static_cast<Real>(kMostDamageRate);
}

/// Share that survives a time at a temperature: exp(-Omega) of the damage integral Omega. Exact for
/// a constant temperature, whatever the step.
/// @param survival  share before
/// @param dt        s
template <class Real>
PBDSURG_HOST_DEVICE Real surviving(const DamageKinetics& kinetics, Real survival, Real temperature,
                                   Real dt) {
  using std::exp;
  return survival * exp(-damage_rate(kinetics, temperature) * dt);
}

/// Degrees Celsius above which tissue chars. That is common teaching; the rate is our choice, after
/// how long it takes to see.
inline constexpr double kCharringTemperature = 200;
/// Degrees Celsius from which on it chars as fast as it can.
inline constexpr double kFullCharringTemperature = 300;
inline constexpr double kMostCharringRate = 10;  ///< 1/s

/// Share that is char after a time at a temperature.
/// @param charred  share before
/// @param dt       s
template <class Real>
PBDSURG_HOST_DEVICE Real charring(Real charred, Real temperature, Real dt) {
  using std::exp;
  const Real heat = (temperature - static_cast<Real>(kCharringTemperature)) /
                    static_cast<Real>(kFullCharringTemperature - kCharringTemperature);
  if (!(heat > 0)) {
    return charred;
  }
  const Real rate = static_cast<Real>(kMostCharringRate) * (heat < 1 ? heat : Real{1});
  return 1 - (1 - charred) * exp(-rate * dt);
}

/// Conductivity of heat, W/(m K), by ThermalProperties::conductivity_rise between 0 and 100
/// degrees, constant beyond.
template <class Real>
PBDSURG_HOST_DEVICE Real heat_conductivity(const ThermalProperties& tissue, Real temperature) {
  const auto hottest = static_cast<Real>(kBoilingTemperature);
  const Real warm = temperature < hottest ? (temperature > 0 ? temperature : Real{0}) : hottest;
  return static_cast<Real>(tissue.conductivity) *
         (1 + static_cast<Real>(tissue.conductivity_rise) *
                  (warm - static_cast<Real>(kBodyTemperature)));
}

inline constexpr double kConductivityRise =
    0.015;                                        ///< 1/K, of ionic conduction; literature 1.5-2 %
inline constexpr double kDryConductivity = 0.01;  ///< share of moist: two decades, as in ablation

/// Electrical conductivity, S/m: rises with temperature up to boiling. What has lost its water is
/// in series with what has not: current dries the layer first that resists it most, however thin,
/// so a cell with a share of dry tissue is one with a dry layer across the current. Its resistance
/// is the sum of both, d (share / dry + (1 - share) / moist), whether a mesh resolves the layer or
/// not. Never zero, so that a dry shell blocks the current without a jump.
template <class Real>
PBDSURG_HOST_DEVICE Real electrical_conductivity(const ThermalProperties& tissue, Real temperature,
                                                 Real water) {
  const auto hottest = static_cast<Real>(kBoilingTemperature);
  const Real warm = temperature < hottest ? (temperature > 0 ? temperature : Real{0}) : hottest;
  const Real rise =
      1 + static_cast<Real>(kConductivityRise) * (warm - static_cast<Real>(kBodyTemperature));
  const auto dry = static_cast<Real>(kDryConductivity);
  return static_cast<Real>(tissue.electrical_conductivity) * rise * dry /
         (dry * water + (1 - water));
}

/// Heat that blood carries off, W/(m^3 K) (Pennes 1948): G in rho c dT/dt = ... - G (T - T_body).
/// What is coagulated no longer bleeds.
template <class Real>
PBDSURG_HOST_DEVICE Real perfusion_cooling(const ThermalProperties& tissue, Real survival) {
  return static_cast<Real>(tissue.perfusion * kDensityOfBlood * kSpecificHeatOfBlood) * survival;
}

/// How long what was 1 m is now. Steam and water leave the volume they took, evenly in all
/// directions (liver dried altogether keeps 22 % of its volume; Farina et al. 2014 measured 26 to
/// 48 % after microwaves); collagen contracts by up to ThermalProperties::collagen_contraction and
/// presses out water that would boil away later, so the stronger of the two counts. Volumes go with
/// the cube. Positive, at most 1.
/// @param water     share left
/// @param collagen  share of collagen that survives, with kCollagenDenaturation
template <class Real>
PBDSURG_HOST_DEVICE Real shrunk_length(const ThermalProperties& tissue, Real water, Real collagen) {
  using std::cbrt;
  constexpr double kLargestLoss = 0.9;  // of volume, for whatever density a user gives
  const double water_volume = tissue.water_fraction * tissue.density / kDensityOfWater;
  const auto loss = static_cast<Real>(water_volume < kLargestLoss ? water_volume : kLargestLoss);
  const Real dried = cbrt(1 - loss * (1 - water));
  const Real contracted = 1 - static_cast<Real>(tissue.collagen_contraction) * (1 - collagen);
  return dried < contracted ? dried : contracted;
}

/// How many times as stiff tissue is as in life: in proportion to what of it has coagulated. Beyond
/// boiling, where its structure breaks, stiffness falls again (Shahmirzadi et al. 2014, canine
/// liver); that is left out, as such tissue soon goes.
/// @param survival  share that lives
template <class Real>
PBDSURG_HOST_DEVICE Real stiffened(const ThermalProperties& tissue, Real survival) {
  return 1 + (static_cast<Real>(tissue.coagulated_stiffness) - 1) * (1 - survival);
}

/// State of an element under heat, by how many of its vertices have boiled: the paper's algorithm 2
/// of tetrahedra, and the same of triangles of sheets.
enum class HeatState : std::uint8_t {
  normal,     ///< none
  heated,     ///< one: no change of volume
  burning,    ///< two or more: volume and the edges between boiled vertices shrink
  vaporised,  ///< all, and, by RemovalRule::water, its water is gone: removed
};

/// @param boiled_vertices  how many of its vertices have ever boiled, 0 to all
/// @param water            mean share of water left at its vertices
/// @param dry_water        share at which tissue counts as dry
/// @param vertices         how many it has: 4 of a tetrahedron, 3 of a triangle
PBDSURG_HOST_DEVICE constexpr HeatState heat_state(RemovalRule rule, int boiled_vertices,
                                                   double water, double dry_water,
                                                   int vertices = 4) {
  if (boiled_vertices < 2) {
    return boiled_vertices == 1 ? HeatState::heated : HeatState::normal;
  }
  const bool is_gone =
      boiled_vertices == vertices && (rule == RemovalRule::boiled_vertices || water <= dry_water);
  return is_gone ? HeatState::vaporised : HeatState::burning;
}

}  // namespace pbdsurg
