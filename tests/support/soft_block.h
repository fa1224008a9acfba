// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A soft block on a table, for tests of what tools do to it.

#include <Eigen/Geometry>
#include <array>

#include "pbdsurg/solver/tool.h"
#include "pbdsurg/tissue/scene.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

inline ToolPose at(const Eigen::Vector3f& place) {
  return ToolPose(Eigen::Translation3f(place));
}

/// Fixed below, without gravity; of 10 kPa by default.
inline Scene make_soft_block(std::array<Index, 3> cells, double edge,
                             const Material& material = {.model = ElasticModel::neo_hookean,
                                                         .youngs_modulus = 10e3F}) {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  const BodyId block = scene.add_body("block", make_box(cells, edge), material);
  scene.fix_where(block, [](const Eigen::Vector3d& x) { return x.z() < 1e-9; });
  return scene;
}

}  // namespace pbdsurg::testing
