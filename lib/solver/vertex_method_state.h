// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the vertex-block method keeps.

#include <cstddef>
#include <vector>

#include "solver/particle.h"
#include "solver/vertex_blocks.h"

namespace pbdsurg {

/// A tool's contact or grasp at a vertex.
struct VertexHold {
  Index place;  ///< of the vertex, see SolverData
  Index next;   ///< at the same vertex, or kInvalidIndex
  Index tool;
  Index entry;  ///< of its attachments or contacts
  bool is_contact;
};

/// What the method keeps between phases, for the copy at work; empty for other methods.
struct VertexMethod {
  VertexBlocks blocks;
  std::vector<Particle> flights;   ///< [vertex_count] m, where a vertex would be without its rows
  std::vector<Index> first_holds;  ///< [vertex_count] or kInvalidIndex
  std::vector<VertexHold> holds;   ///< of the current substep
  std::vector<LaneBits> held;      ///< [block_count] lanes of vertices with holds

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return blocks.memory_bytes() + flights.capacity() * sizeof(Particle) +
           first_holds.capacity() * sizeof(Index) + holds.capacity() * sizeof(VertexHold) +
           held.capacity() * sizeof(LaneBits);
  }
};

}  // namespace pbdsurg
