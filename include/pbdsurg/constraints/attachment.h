// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Holds a vertex at a moving target: a grasped point, a suture, a bone.
///
///     target *~~~~o x      C = x - target   (three constraints at once)   m
///                          gradient  identity                             1
///                          compliance                                     m/N
///                          multiplier  one per axis                       kg m

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Holds a vertex at a target, along three axes at once: constraints/attachment.h has the
/// equations.
struct AttachmentConstraint {
  static constexpr int kVertexCount = 1;  ///< vertices of one constraint

  /// One projection, in place.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param target      m
  /// @param stiffness   see multiplier_change()
  /// @param multiplier  kg m, accumulated; multiplier / dt^2 is the force on the vertex, in N
  template <ProjectionMode kMode, class Scalar>
  PBDSURG_HOST_DEVICE static void project(Vec3<Scalar>& x, Scalar w, const Vec3<Scalar>& target,
                                          Scalar stiffness, Vec3<Scalar>& multiplier) {
    const Vec3<Scalar> c = x - target;
    const Vec3<Scalar> change{multiplier_change<kMode>(c.x, w, stiffness, multiplier.x),
                              multiplier_change<kMode>(c.y, w, stiffness, multiplier.y),
                              multiplier_change<kMode>(c.z, w, stiffness, multiplier.z)};
    multiplier = multiplier + change;
    x = x + w * change;
  }
};

}  // namespace pbdsurg
