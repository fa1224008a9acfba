// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Energies of vertices that registers have summed up, for those that single vertices take over.
/// Shared with kernels that are compiled for several instruction sets.

#include "lib/solver/sets/constraint_block.h"

namespace pbdsurg {

/// VertexEnergy of the lanes of a block, with all rows.
struct alignas(64) EnergyBlock {
  float force[3][kBlockLanes];    ///< N
  float isotropic[kBlockLanes];   ///< N/m
  float squares[6][kBlockLanes];  ///< N/m: xx, yy, zz, xy, xz, yz
};

}  // namespace pbdsurg
