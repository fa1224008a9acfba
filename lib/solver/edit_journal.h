// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the last edit did, so that it can be taken back.

#include <cstdint>
#include <vector>

#include "pbdsurg/core/types.h"

#include "solver/particle.h"
#include "solver/tool_state.h"

namespace pbdsurg {

/// All but what constraints, owners of edges and rows of vertices keep in mind themselves.
struct EditJournal {
  struct Mass {
    Index vertex;
    double mass;  ///< kg
    float w;      ///< 1/kg
  };
  struct Release {
    Index copy, tool;
    std::size_t entry;  ///< of the tool's attachments, after those released before it
    Attachment attachment;
  };

  bool is_open = false;               ///< the edit was not taken back, and none is under way
  std::uint64_t fingerprint = 0;      ///< of the edit and its result
  std::uint64_t version_before = 0;   ///< of the topology
  std::vector<Index> tets;            ///< removed
  std::vector<Mass> masses;           ///< before each change
  std::vector<Index> stopped;         ///< places of vertices that lost their last tetrahedron
  std::vector<VertexMotion> motions;  ///< [copy][stopped]
  std::vector<Release> releases;      ///< by tools of vertices without tissue

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return tets.capacity() * sizeof(Index) + masses.capacity() * sizeof(Mass) +
           stopped.capacity() * sizeof(Index) + motions.capacity() * sizeof(VertexMotion) +
           releases.capacity() * sizeof(Release);
  }
};

}  // namespace pbdsurg
