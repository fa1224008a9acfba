// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What all ways to draw a surface share: its rules, and its colours as shaders want them.

#include <Eigen/Core>
#include <string>

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// Four texels, or four vectors of a shader. Colours are linear.
struct DrawMaterial {
  Eigen::Vector4f color;    ///< rgb, opacity
  Eigen::Vector4f mottle;   ///< rgb, unused
  Eigen::Vector4f surface;  ///< gloss, detail size (m), relief, 1 for insulation
  Eigen::Vector4f pattern;  ///< lobules, vessels, unused, unused
};

/// Stands for a vertex without a colour of its own.
inline const Eigen::Vector4f kMaterialColor(0, 0, 0, -1);

/// sRGB to linear light, clamped to [0, 1].
[[nodiscard]] Eigen::Vector4f linear_of_srgb(const Eigen::Vector3f& color, float alpha);

[[nodiscard]] DrawMaterial material_of(const pbdsurg::TissueLook& look, bool insulation = false);

/// Absent or not finite is dry.
[[nodiscard]] float wetness_at(const Surface& surface, std::size_t v);
/// Linear, its colour multiplied by its cover. Absent or not finite is unburnt.
[[nodiscard]] Eigen::Vector4f burn_at(const Surface& surface, std::size_t v);
/// Linear. Absent or not finite is kMaterialColor.
[[nodiscard]] Eigen::Vector4f color_at(const Surface& surface, std::size_t v);

/// Whether anything of it has to be blended.
[[nodiscard]] bool is_translucent(const Surface& surface);

/// @throws pbdsurg::InvalidArgument  naming the surface, if an array has the wrong length, a
/// triangle
///         names a vertex that is not there, or a detail size is not positive and finite
void check(const Surface& surface);

/// Whether a change fits a surface as it is.
/// @throws pbdsurg::InvalidArgument  naming the surface and what is wrong
void check(const Surface& surface, const SurfaceChange& change);

/// Makes the change. Given normals are dropped once a triangle or a position changes: they would be
/// of a shape that is gone.
/// @param change  that check() lets pass
void apply(const SurfaceChange& change, Surface& surface);

}  // namespace cholecystectomy
