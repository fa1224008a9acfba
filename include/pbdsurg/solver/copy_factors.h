// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a copy of a scene is made of, where that is not the scene's material.

namespace pbdsurg {

/// How a copy of a scene differs from it: it moves as the one of a solver of such a scene would.
struct CopyFactors {
  /// Of all that is elastic: moduli and compliances of bodies, fibres, links, hinges, and with them
  /// inner friction; not of grasps. In [kSmallestStiffness, kLargestStiffness].
  float stiffness = 1;
  float density = 1;  ///< of bodies, and of the masses of particles; in the same range
  float gravity = 1;  ///< finite

  /// Whether it is of another material.
  [[nodiscard]] bool change_material() const noexcept { return stiffness != 1 || density != 1; }
  /// Factor by factor.
  friend bool operator==(const CopyFactors&, const CopyFactors&) = default;
};

}  // namespace pbdsurg
