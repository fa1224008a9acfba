// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A slab of soft tissue whose end lies between jaws.

#include <Eigen/Core>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/scene.h"

#include "tests/support/meshes.h"

namespace pbdsurg::testing {

/// 40 x 12 x 12 mm of edges of 4 mm, along x, without gravity.
struct HeldSlab {
  static constexpr double kEdge = 4e-3;
  static constexpr std::array<Index, 3> kCells{10, 3, 3};

  /// @param is_fixed  at its low end
  explicit HeldSlab(bool is_fixed = true,
                    const Material& material = {.model = ElasticModel::neo_hookean,
                                                .youngs_modulus = 20e3F}) {
    scene.set_gravity(Eigen::Vector3f::Zero());
    const BodyId slab = scene.add_body("slab", make_box(kCells, kEdge), material);
    if (is_fixed) {
      scene.fix_where(slab, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
    }
  }

  /// Vertices of both faces that jaws press, on three rows.
  [[nodiscard]] std::vector<Index> held() const {
    std::vector<Index> vertices;
    for (Index v = 0; v < scene.vertex_count(); ++v) {
      const Eigen::Vector3d& x = scene.positions()[v];
      if (x.x() > 31e-3 && (x.z() < 1e-9 || x.z() > 11.9e-3)) {
        vertices.push_back(v);
      }
    }
    return vertices;
  }

  [[nodiscard]] std::vector<TissuePoint> points() const {
    std::vector<TissuePoint> result;
    for (const Index v : held()) {
      result.push_back({{v, kInvalidIndex, kInvalidIndex}, {1, 0, 0}});
    }
    return result;
  }

  /// Of the jaws, whose pad lies in the middle of these.
  [[nodiscard]] static ToolPose pose(const Eigen::Vector3f& moved = {0, 0, 0}) {
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(36e-3F, 6e-3F, 6e-3F) + moved;
    return pose;
  }

  /// N, that it holds along the pad: 2 friction clamp_force.
  [[nodiscard]] static Grip grip(float limit) {
    Grip grip;
    grip.pad.half_length = 12e-3F;
    grip.pad.half_width = 7e-3F;
    grip.friction = 0.5F;
    grip.clamp_force = limit;
    return grip;
  }

  Scene scene;
};

}  // namespace pbdsurg::testing
