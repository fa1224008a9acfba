// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the last edit did, so that it can be taken back.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/solver/step_plan.h"

#include "solver/particle.h"
#include "solver/tool_state.h"
#include "solver/vertex_method.h"

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

  bool is_open = false;                  ///< the edit was not taken back, and none is under way
  std::uint64_t fingerprint = 0;         ///< of the edit and its result
  std::uint64_t version_before = 0;      ///< of the topology
  std::size_t link_count = 0;            ///< before
  std::vector<PhaseKind> opened_groups;  ///< of constraints, by their kind
  std::vector<Index> tets;               ///< removed
  std::vector<Index> links;              ///< removed
  std::vector<Mass> masses;              ///< before each change
  std::vector<Index> stopped;            ///< places of vertices that lost their last tetrahedron
  std::vector<VertexMotion> motions;     ///< [copy][stopped]
  std::vector<Release> releases;         ///< by tools of vertices without tissue

  /// The vertex-block method's before constraints were added, which lays its rows out anew.
  std::optional<VertexMethod> before_growth;

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return (tets.capacity() + links.capacity()) * sizeof(Index) +
           (before_growth ? before_growth->blocks.memory_bytes() : 0) +
           masses.capacity() * sizeof(Mass) + stopped.capacity() * sizeof(Index) +
           motions.capacity() * sizeof(VertexMotion) + releases.capacity() * sizeof(Release);
  }
};

}  // namespace pbdsurg
