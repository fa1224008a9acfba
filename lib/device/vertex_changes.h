// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How rows of the vertex-block method follow edits on a device.

#include <vector>

#include "pbdsurg/base/types.h"

#include "lib/device/stages.h"
#include "lib/solver/methods/vertex_blocks.h"

namespace pbdsurg::cuda {

/// Lists what to write so that the rows of a vertex are those of now, in its own lane: the others
/// of its block and the idle ones stay. Cost: proportional to the rows of its block.
/// @param place  of a vertex; one that no block holds has no rows
/// @param words  appended to
void follow_vertex(const VertexBlocks& blocks, Index place, std::vector<WordChange>& words);

}  // namespace pbdsurg::cuda
