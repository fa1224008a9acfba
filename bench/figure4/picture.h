// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The gallbladder under the hook, in one colour rule or another.

#include <functional>
#include <span>

#include "apps/viewer/render_snapshot.h"
#include "bench/figure4/burn.h"

namespace pbdsurg::bench {

/// Colour of one texel of the surface.
using TexelColor = std::function<Color(double temperature, const BurnMarks& marks)>;

/// Where the hook stands, and who looks at it.
struct Viewpoint {
  Eigen::Vector3f tip;     ///< m
  Eigen::Vector3f normal;  ///< of the surface there, outwards
};

/// On the side of the organ that faces the laparoscope, at its widest.
Viewpoint choose_viewpoint(const TetMesh& gallbladder);

/// Warm triangles are drawn texel by texel, so that the colours of a rule that jumps do so in
/// place.
/// @param is_close  the surroundings of the hook, 24 x 18 mm; else the whole organ
cholecystectomy::RenderSnapshot draw_burn(const TetMesh& gallbladder, const Burn& burn,
                                          const Viewpoint& view, bool is_close,
                                          const TexelColor& color_of);

/// Surface at or above a temperature, m^2.
/// @param temperature  degrees Celsius
double surface_above(const TetMesh& gallbladder, const Burn& burn, double temperature);

}  // namespace pbdsurg::bench
