// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How rows of the vertex-block method follow edits on a device.

#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/stages.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/state/changes.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

/// Lists what to write so that the rows of a vertex are those of now, in its own lane: the others
/// of its block and the idle ones stay. Cost: proportional to the rows of its block.
/// @param place  of a vertex; one that no block holds has no rows, and one that is gone nothing
/// @param words  appended to
void follow_vertex(const VertexBlocks& blocks, Index place, std::vector<WordChange>& words);

/// Likewise so that a block is, and that its vertices are known to be there. Its rows stay.
/// @param block  may be gone
void follow_block(const VertexBlocks& blocks, Index block, std::vector<WordChange>& words);

/// Likewise so that all is that changes tell of; rows must not have been laid out anew.
void follow_rows(const SolverData& data, const Changes& changes, std::vector<WordChange>& words);

/// VertexArrays::lane_of_place of a place.
[[nodiscard]] Index lane_of(const VertexBlocks& blocks, Index place) noexcept;

}  // namespace pbdsurg::cuda
