// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The explicit conflict graph, for colouring tools that want one. Nothing here needs it.

#include <iosfwd>
#include <string_view>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {

/// Writes the graph of which constraints share a vertex as a symmetric pattern matrix in Matrix
/// Market's coordinate format (Boisvert, Pozo, Remington 1996, "The Matrix Market exchange
/// formats", NISTIR 5935). Constraint c is row and column c + 1. Only the lower triangle is
/// written, row by row, each conflict once; the diagonal is empty.
///
/// Cost: O(sum of squared constraints at a vertex), twice, as the number of conflicts comes first;
/// 13 bytes in the file for each, 0.5 GB for a million tetrahedra. Memory: 4 bytes for each
/// vertex and for each that a constraint names.
/// @param comment  lines that say what the constraints are
/// @throws InvalidArgument  as check_constraints(), with nothing written. What the stream could not
///                          take, its state says
PBDSURG_API void write_conflict_graph(std::ostream& out, const ConstraintVertices& constraints,
                                      std::string_view comment);

}  // namespace pbdsurg
