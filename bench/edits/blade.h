// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where a blade goes in which frame.

#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/surgery/cut.h"

namespace pbdsurg::bench {

/// A blade that goes through an organ lengthwise, and again through another of its planes, as fast
/// as it takes to cross some twenty tetrahedra a frame.
class Blade {
 public:
  /// @param positions  [mesh.vertex_count()] m, of the organ
  Blade(const TetMesh& mesh, std::span<const Eigen::Vector3f> positions);

  struct Way {
    CutSurface surface;
    bool begins;  ///< in another plane than before
  };
  [[nodiscard]] Way next();

 private:
  void begin_pass();

  std::vector<std::array<float, 2>> tet_extents_;  // m, across the planes
  Eigen::AlignedBox3f box_;
  int pass_ = 0;
  float height_ = 0;  // m, of the plane
  float front_;       // m, where the blade is
  float speed_ = 0;   // m a frame
};

}  // namespace pbdsurg::bench
