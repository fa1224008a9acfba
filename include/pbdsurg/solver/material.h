// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a body resists deformation.

namespace pbdsurg {

/// One type of constraint's resistance, in both projection modes; the solver's mode picks one.
struct Stiffness {
  float fraction = 1;    ///< fraction mode: share of the violation removed per projection, (0, 1]
  float compliance = 0;  ///< compliance mode: >= 0; distance m/N, volume m^5/N; 0 is rigid
};

/// Material of one body. The defaults are the paper's (stretch stiffness 0.4, see the digest of its
/// appendix in the README), with compliances of a soft organ at millimetre edges.
struct Material {
  float density = 1000;                ///< kg/m^3, positive
  Stiffness stretch{0.4F, 0.0F};       ///< along edges
  Stiffness volume{1.0F, 0.0F};        ///< of tetrahedra
  bool has_volume_constraints = true;  ///< false for tubes, which the paper gives edges only
};

}  // namespace pbdsurg
