// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the last edit did, so that it can be taken back.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/step_plan.h"

#include "solver/particle.h"
#include "solver/room_to_grow.h"
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

  struct Shape {
    Index tet;
    Tet vertices;
    std::array<Index, 6> edges;
  };
  struct Count {
    Index edge, count;
  };
  struct Ends {
    Index id;
    Index first, second;
  };
  /// Of the lists of tetrahedra or links at a vertex.
  struct Entry {
    Index vertex, id;
    bool was_added;
  };

  bool is_open = false;              ///< the edit was not taken back, and none is under way
  bool is_growth = false;            ///< it added constraints, or gave some other vertices
  std::uint64_t fingerprint = 0;     ///< of the edit and its result
  std::uint64_t version_before = 0;  ///< of the topology
  std::size_t body_count = 0, vertex_count = 0, tet_count = 0, edge_count = 0,
              link_count = 0;            ///< before
  std::vector<PhaseKind> opened_groups;  ///< of constraints, by their kind
  std::vector<Index> tets;               ///< removed
  std::vector<Shape> shapes;             ///< before each change
  std::vector<Count> edge_tets;          ///< before each change
  std::vector<Ends> edges, links;        ///< before each change
  std::vector<Entry> tet_entries, link_entries;
  std::vector<Mass> masses;               ///< before each change
  std::vector<Index> stopped;             ///< vertices that lost their last tetrahedron
  std::vector<VertexMotion> motions;      ///< [copy][stopped] as they moved before
  std::vector<bool> is_motion_asked;      ///< [copy] the backend has its part of `motions`,
  std::vector<Index> asked;               ///< for these entries of `stopped`
  std::vector<Release> releases;          ///< by tools of vertices without tissue
  std::vector<const void*> participants;  ///< who followed the edit, in their order

  /// The vertex-block method's before constraints were added, which lays its rows out anew.
  std::optional<VertexMethod> before_growth;

  /// Makes room for an edit that changes so many, or some thousands of them.
  void reserve(std::size_t vertex_room, std::size_t tet_room, std::size_t edge_room,
               std::size_t link_room) {
    const auto make_room = [](std::size_t count, auto&... lists) {
      (lists.reserve(std::min(count, kEntriesOfEdit)), ...);
    };
    make_room(vertex_room, masses, stopped, motions, asked);
    make_room(tet_room, tets, shapes);
    make_room(4 * tet_room, tet_entries);
    make_room(edge_room, edge_tets, edges);
    make_room(2 * link_room, links, link_entries);
  }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    const auto bytes_of = [](const auto&... lists) {
      return (... + (lists.capacity() * sizeof(lists[0])));
    };
    return (before_growth ? before_growth->memory_bytes() : 0) + is_motion_asked.capacity() / 8 +
           bytes_of(opened_groups, tets, shapes, edge_tets, edges, links, tet_entries, link_entries,
                    masses, stopped, motions, asked, releases, participants);
  }
};

}  // namespace pbdsurg
