// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Thermal properties of tissue near body temperature.
///
/// Densities, heat capacities and conductivities of liver and fat are the averages of the IT'IS
/// database as reprinted by COMSOL's bioheat library; the others and all water contents are common
/// literature values, to be replaced by measured ones where they matter.

namespace pbdsurg {

struct TissueProperties {
  double density;         ///< kg/m^3
  double specific_heat;   ///< J/(kg K)
  double conductivity;    ///< W/(m K)
  double water_fraction;  ///< mass of water per mass of tissue, [0, 1]
};

inline constexpr TissueProperties kLiver{1079, 3540, 0.52, 0.72};
inline constexpr TissueProperties kGallbladderWall{1071, 3716, 0.52, 0.75};
inline constexpr TissueProperties kFat{911, 2348, 0.21, 0.15};
inline constexpr TissueProperties kConnectiveTissue{1027, 2372, 0.39, 0.62};

inline constexpr double kBodyTemperature = 37;         ///< degrees Celsius
inline constexpr double kBoilingTemperature = 100;     ///< degrees Celsius
inline constexpr double kLatentHeatOfWater = 2.257e6;  ///< J/kg, at 100 degrees Celsius

}  // namespace pbdsurg
