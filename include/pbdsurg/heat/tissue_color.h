// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How burnt tissue looks: by its state, which does not go back, or by temperature as in the paper.

#include <cstddef>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/heat/thermal_model.h"
#include "pbdsurg/tissue/thermal_properties.h"

namespace pbdsurg {

/// Channels in [0, 1].
struct Color {
  float red,  ///< red
      green,  ///< green
      blue,   ///< blue
      alpha;  ///< opacity
};

/// (1 - share) from + share to, of each channel.
PBDSURG_HOST_DEVICE constexpr Color mix(const Color& from, const Color& to, float share) {
  const float rest = 1 - share;
  return {rest * from.red + share * to.red, rest * from.green + share * to.green,
          rest * from.blue + share * to.blue, rest * from.alpha + share * to.alpha};
}

/// The paper's equation 7: with k = (T - T_0) / (T_v - T_0), at most 1, the colour is
/// (1 - k) C + k C_i; i is 1 for k <= 0.8, 2 for k <= 0.99, else 3. It jumps there, as printed. Of
/// the current temperature it forgets when tissue cools; of the highest so far it does not. Below
/// body temperature it is the flesh's own.
/// @param temperature  degrees Celsius
PBDSURG_HOST_DEVICE constexpr Color temperature_color(const Color& flesh, double temperature) {
  constexpr Color kStarting{1, 1, 1, 0};
  constexpr Color kBurnt{1, 0.92F, 0.80F, 0.7F};
  constexpr Color kVaporising{1, 0.82F, 0.70F, 0.2F};
  double k = (temperature - kBodyTemperature) / (kBoilingTemperature - kBodyTemperature);
  k = k < 1 ? (k > 0 ? k : 0) : 1;
  return mix(flesh, k <= 0.8 ? kStarting : (k <= 0.99 ? kBurnt : kVaporising),
             static_cast<float>(k));
}

/// Marks of heat, each in [0, 1] and never falling.
struct BurnMarks {
  float white = 0;    ///< coagulated: 1 - survival
  float brown = 0;    ///< dried: 1 - water
  float charred = 0;  ///< carbonised
};

/// @param survival  share not yet damaged @param water  share left @param charred  share that is
PBDSURG_HOST_DEVICE constexpr BurnMarks burn_marks(double survival, double water, double charred) {
  return {static_cast<float>(1 - survival), static_cast<float>(1 - water),
          static_cast<float>(charred)};
}

/// A share in 8 bits, for textures: to the nearest of 255 steps, so that what never falls never
/// falls there either.
PBDSURG_HOST_DEVICE constexpr unsigned char to_byte(float share) {
  return static_cast<unsigned char>((share < 1 ? (share > 0 ? share : 0) : 1) * 255 + 0.5F);
}

/// Flesh that turns white, over that brown, over that black, by its marks. Where all marks are
/// zero, the flesh's own colour; alpha stays. Colours of marks are our choice.
PBDSURG_HOST_DEVICE constexpr Color state_color(const Color& flesh, const BurnMarks& marks) {
  const Color coagulated{0.86F, 0.80F, 0.70F, flesh.alpha};
  const Color dried{0.40F, 0.26F, 0.14F, flesh.alpha};
  const Color carbon{0.03F, 0.025F, 0.02F, flesh.alpha};
  return mix(mix(mix(flesh, coagulated, marks.white), dried, marks.brown), carbon, marks.charred);
}

/// By the rule of a model: state_color() or temperature_color(), whose alpha is left out.
/// @param temperature  degrees Celsius, the highest so far (HeatField::peak_temperatures)
PBDSURG_HOST_DEVICE constexpr Color tissue_color(ColorRule rule, const Color& flesh,
                                                 double temperature, const BurnMarks& marks) {
  if (rule == ColorRule::state) {
    return state_color(flesh, marks);
  }
  const Color color = temperature_color(flesh, temperature);
  return {color.red, color.green, color.blue, flesh.alpha};
}

/// tissue_color() for flesh that is known elsewhere, such as in a shader, whatever its colour:
/// mix() of flesh and this by this alpha has the same red, green and blue.
PBDSURG_HOST_DEVICE constexpr Color burn_layer(ColorRule rule, double temperature,
                                               const BurnMarks& marks) {
  const Color over_black = tissue_color(rule, {0, 0, 0, 1}, temperature, marks);
  const Color over_white = tissue_color(rule, {1, 1, 1, 1}, temperature, marks);
  const float cover = 1 - (over_white.red - over_black.red);
  if (!(cover > 0)) {
    return {0, 0, 0, 0};
  }
  return {over_black.red / cover, over_black.green / cover, over_black.blue / cover, cover};
}

/// Temperature in false colours, from pale over yellow and red to nearly black at boiling and
/// beyond: ever darker, so that it can be read in grey and without telling red from green. Stops
/// at equal steps between body temperature and boiling, after ColorBrewer's YlOrRd.
/// @param temperature  degrees Celsius
PBDSURG_HOST_DEVICE constexpr Color false_color(double temperature) {
  constexpr std::size_t kLast = 6;
  constexpr Color kStops[kLast + 1]{{0.95F, 0.95F, 0.92F, 1}, {1.00F, 0.93F, 0.63F, 1},
                                    {1.00F, 0.78F, 0.36F, 1}, {0.99F, 0.55F, 0.24F, 1},
                                    {0.89F, 0.20F, 0.13F, 1}, {0.62F, 0.02F, 0.15F, 1},
                                    {0.20F, 0.00F, 0.12F, 1}};
  const double share = (temperature - kBodyTemperature) / (kBoilingTemperature - kBodyTemperature);
  const double place = static_cast<double>(kLast) * (share < 1 ? (share > 0 ? share : 0) : 1);
  const auto stop = static_cast<std::size_t>(place);
  return stop == kLast ? kStops[kLast]
                       : mix(kStops[stop], kStops[stop + 1],
                             static_cast<float>(place - static_cast<double>(stop)));
}

}  // namespace pbdsurg
