// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A snapshot turned into arrays that OpenGL draws in four calls, one after the other.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

/// One vertex as the shaders read it. Colours are linear.
struct DrawVertex {
  Eigen::Vector3f position;  ///< m
  Eigen::Vector3f normal;
  Eigen::Vector3f rest;   ///< m; for smoke, place in the puff (-1..1) and a seed
  Eigen::Vector4f color;  ///< replaces the material's where alpha >= 0
  Eigen::Vector4f burn;   ///< the layer, its colour multiplied by its cover
  float wetness;          ///< for smoke, its radius in m
  std::int32_t material;
};

/// Four texels of the material table. Colours are linear.
struct DrawMaterial {
  Eigen::Vector4f color;    ///< rgb, opacity
  Eigen::Vector4f mottle;   ///< rgb, unused
  Eigen::Vector4f surface;  ///< gloss, detail size (m), relief, 1 for insulation
  Eigen::Vector4f pattern;  ///< lobules, vessels, unused, unused
};

struct DrawList {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> tissue;   ///< [3 * triangle count] opaque, nearest first
  std::vector<std::uint32_t> tools;    ///< [3 * triangle count] opaque
  std::vector<std::uint32_t> blended;  ///< [3 * triangle count] tissue, farthest first
  std::vector<std::uint32_t> smoke;    ///< [3 * triangle count] farthest first
  std::vector<DrawMaterial> materials;
  float farthest = 0;  ///< distance of the farthest vertex from the eye, m
};

/// Cost: O(n log n) in the triangles.
/// @throws pbdsurg::InvalidArgument  if an array of a surface has the wrong length or a triangle
///         names a vertex that is not there
[[nodiscard]] DrawList make_draw_list(const RenderSnapshot& snapshot);

}  // namespace cholecystectomy
