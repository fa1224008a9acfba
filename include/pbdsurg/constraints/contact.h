// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps a vertex on the outer side of a plane that stands for a tool's surface nearby.
///
///        o x        C = normal . x - offset >= 0    m
///     ---^------    gradient  normal                1
///        | normal   multiplier >= 0                 kg m

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Keeps a vertex on the outer side of a plane: constraints/contact.h has the equations.
struct ContactConstraint {
  static constexpr int kVertexCount = 1;  ///< vertices of one constraint

  /// One rigid projection, in place. The multiplier never becomes negative, so a contact pushes and
  /// never pulls, and lets go of what it pushed too far.
  ///
  /// @param x           m
  /// @param w           1/kg, zero for a fixed vertex
  /// @param normal      unit, out of the tool
  /// @param offset      m
  /// @param multiplier  kg m, accumulated; normal * multiplier / dt^2 is the force on the vertex,
  /// in N
  template <class Scalar>
  PBDSURG_HOST_DEVICE static void project(Vec3<Scalar>& x, Scalar w, const Vec3<Scalar>& normal,
                                          Scalar offset, Scalar& multiplier) {
    const Scalar change = multiplier_change<ProjectionMode::compliance>(dot(normal, x) - offset, w,
                                                                        Scalar(0), multiplier);
    const Scalar next = select(multiplier + change > Scalar(0), multiplier + change, Scalar(0));
    x = x + (w * (next - multiplier)) * normal;
    multiplier = next;
  }
};

}  // namespace pbdsurg
