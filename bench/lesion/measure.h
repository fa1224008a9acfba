// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A burn of a block of liver, and what it leaves.

#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg::bench {

/// What a burn leaves.
struct Lesion {
  double depth = 0;    ///< m below the surface, of what is coagulated
  double width = 0;    ///< m, likewise, mean of two directions
  double removed = 0;  ///< m^3
  double hottest = 0;  ///< degrees Celsius, at any time
  double ledger = 0;   ///< J that the ledger lacks, relative to what came in
};

inline constexpr int kPlaces = 8;

/// Burns at one of kPlaces places that are spread over a cell of the middle of a block's top: 1 s
/// on 5 mm^2. Serial; the mesh stays in its shape.
/// @param mesh   of make_liver()
/// @param edge   m, of its cells
/// @param power  W
/// @param place  in [0, kPlaces)
[[nodiscard]] Lesion burn(const TetMesh& mesh, double edge, double power, int place);

/// A block of 14 x 14 x 6 mm.
/// @param edge  m, of the cells of the lattice
[[nodiscard]] TetMesh make_liver(double edge);

}  // namespace pbdsurg::bench
