// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a cut divides the tetrahedra near it.

#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/topology_edit.h"

#include "lib/surgery/cut_neighborhood.h"
#include "lib/surgery/cut_surface.h"

namespace pbdsurg {

/// A tetrahedron near the cut, or a child of one.
struct CutPiece {
  Tet corners;
  Index tet;  ///< its own id, or its parent's
  bool is_child;
  int side;  ///< of the surface: 1 above, -1 below, 0 if both or unknown
};

struct CutPieces {
  std::vector<Edge> split_edges;  ///< sorted; edge i has vertex vertex_count + i
  std::vector<NewVertex> splits;  ///< [split_edges]
  std::vector<CutPiece> pieces;   ///< by tetrahedron
};

/// Tetrahedra as the style of the cut has them: divided by the surface, or whole.
[[nodiscard]] CutPieces make_cut_pieces(const CutNeighborhood& near, const CutSides& sides,
                                        const CutOptions& options);

}  // namespace pbdsurg
