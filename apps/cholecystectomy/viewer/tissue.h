// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How each tissue looks through a laparoscope.

#include <Eigen/Core>

namespace cholecystectomy {

/// What the shader needs to know of one tissue. Colours are sRGB in [0, 1].
struct TissueAppearance {
  Eigen::Vector3f color{0.7f, 0.4f, 0.35f};
  Eigen::Vector3f mottle{0.6f, 0.3f, 0.28f};  ///< the colour that noise mixes in
  float gloss = 0.7f;                         ///< 0 dull .. 1 a wet mirror film
  float opacity = 1;                          ///< below 1 the surface is blended
  float detail_size = 0.004f;                 ///< m, one feature of the texture
  float relief = 0.3f;                        ///< 0 smooth .. 1 rough
  float lobules = 0;                          ///< 0..1, the rounded cells of fat
  float vessels = 0;                          ///< 0..1, fine red vessels
};

enum class Tissue { liver, gallbladder, fat, artery, duct, membrane, abdominal_wall };

[[nodiscard]] TissueAppearance appearance_of(Tissue tissue);

}  // namespace cholecystectomy
