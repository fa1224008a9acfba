// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contact of bodies with each other, and of a body with itself.

#include <Eigen/Core>
#include <array>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// How two bodies, or two parts of one, meet each other.
struct TissueContact {
  /// m, positive: surfaces keep this distance. It is also what contact looks ahead by, so it should
  /// be some tenth of an edge or more.
  float thickness = 0;
  float friction = 0;  ///< Coulomb's coefficient, >= 0, at rest and sliding
};

/// A vertex of one body on a triangle of another, or of the same.
struct BodyContact {
  Index first;                    ///< the vertex's body, of the tissue
  Index second;                   ///< the triangle's, likewise
  std::array<Index, 4> vertices;  ///< scene vertices: the vertex, then the triangle's corners
  std::array<float, 3> weights;   ///< of these corners at the point below; their sum is one
  Eigen::Vector3f point;          ///< m, in the scene, of the triangle
  Eigen::Vector3f normal;         ///< out of the second body
  float distance;                 ///< m, along the normal; negative where the bodies overlap
  Eigen::Vector3f force;          ///< N, on the first body, with friction
};

}  // namespace pbdsurg
