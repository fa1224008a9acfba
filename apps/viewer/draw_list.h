// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is drawn anew for each picture, turned into arrays that OpenGL draws in four calls, one
/// after the other.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "apps/viewer/surface_data.h"

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

struct DrawList {
  std::vector<DrawVertex> vertices;
  std::vector<std::uint32_t> tissue;   ///< [3 * triangle count] opaque
  std::vector<std::uint32_t> tools;    ///< [3 * triangle count] opaque
  std::vector<std::uint32_t> blended;  ///< [3 * triangle count] tissue, farthest first
  std::vector<std::uint32_t> smoke;    ///< [3 * triangle count] farthest first
  std::vector<DrawMaterial> materials;
  float farthest = 0;  ///< distance of the farthest vertex from the eye, m
};

/// Cost: O(n log n) in the triangles.
/// @param surfaces  to be blended with the view's sheets
/// @throws pbdsurg::InvalidArgument  as check(Surface)
[[nodiscard]] DrawList make_draw_list(const SceneView& view,
                                      std::span<const Surface* const> surfaces = {});

}  // namespace cholecystectomy
