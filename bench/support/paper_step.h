// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The step that the paper's tables time: 0.2 ms from a stretch of 10 %, since a mesh at rest tests
/// nothing.

#include <vector>

#include "pbdsurg/tissue/scene.h"

namespace pbdsurg::bench {

inline constexpr float kPaperTimeStep = 2e-4F;  // s

/// A gallbladder whose rim is fixed.
inline Scene make_organ_scene(const TetMesh& mesh,
                              const Material& material = {.model = ElasticModel::springs}) {
  constexpr double kRim = 3e-3;  // m
  Scene scene;
  const Index body = scene.add_body("gallbladder", mesh, material);
  const double end = bounding_box(mesh).min().x() + kRim;
  scene.fix_where(body, [&](const Eigen::Vector3d& x) { return x.x() < end; });
  return scene;
}

/// Positions at rest, stretched along x, the organs' long axis.
inline std::vector<Eigen::Vector3f> stretched_positions(const Scene& scene) {
  constexpr float kStretch = 1.1F;
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : scene.positions()) {
    positions.push_back(x.cast<float>());
    positions.back().x() *= kStretch;
  }
  return positions;
}

}  // namespace pbdsurg::bench
