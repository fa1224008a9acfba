// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How tissue looks through a laparoscope: plain data for any renderer.

#include <Eigen/Core>

namespace pbdsurg {

/// Of healthy tissue; burns lie over it (heat/tissue_color.h). Colours are sRGB in [0, 1].
struct TissueLook {
  Eigen::Vector3f color{0.7F, 0.4F, 0.35F};   ///< the colour between mottles
  Eigen::Vector3f mottle{0.6F, 0.3F, 0.28F};  ///< the colour that noise mixes in
  float gloss = 0.7F;                         ///< 0 dull .. 1 a wet mirror film
  float opacity = 1;                          ///< below 1 the surface is blended
  float detail_size = 0.004F;                 ///< m, one feature of the texture, positive
  float relief = 0.3F;                        ///< 0 smooth .. 1 rough
  float lobules = 0;                          ///< 0..1, the rounded cells of fat
  float vessels = 0;                          ///< 0..1, fine red vessels
};

}  // namespace pbdsurg
