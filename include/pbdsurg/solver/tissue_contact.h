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

/// A vertex of one body on a triangle or a link of another, or of the same; or two edges that
/// cross.
struct BodyContact {
  Index first;   ///< the vertex's body, or the first edge's, of the tissue
  Index second;  ///< the triangle's, the link's or the second edge's, likewise
  /// Scene vertices: the vertex, then the triangle's corners, or the link's ends and kInvalidIndex;
  /// or the ends of both edges.
  std::array<Index, 4> vertices;
  int first_count;               ///< how many of them are the first body's: 1, or 2 of an edge
  std::array<float, 4> weights;  ///< of each at its body's point; a body's add up to one
  Eigen::Vector3f point;         ///< m, in the scene, of the second body
  Eigen::Vector3f normal;        ///< out of the second body, or from its edge to the other
  float distance;                ///< m, along the normal; negative where the bodies overlap
  Eigen::Vector3f force;         ///< N, on the first body, with friction
};

}  // namespace pbdsurg
