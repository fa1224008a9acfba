// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What an edit did to living tissue.

#include <array>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

/// A tetrahedron before a change of its corners or edges.
struct ReshapedTet {
  Index tet;                   ///< its id
  Tet vertices;                ///< its corners
  std::array<Index, 6> edges;  ///< in the order of kTetEdges
};

/// An edge that came to be where tissue parted along another.
struct PartedEdge {
  Index edge;    ///< the new one
  Index origin;  ///< the other
};

/// An edit and its consequences. Each list is in the order of events, which were: links removed as
/// asked, new vertices, moves of links, removals of tetrahedra, then triangles, moves of corners of
/// both, new tetrahedra and the removal of their parents, hinges of these and of moved corners,
/// links lost with tissue, new bodies, new links, new hinges. Vertices keep their ids for ever.
struct TissueChange {
  TopologyEdit edit{};  ///< as asked
  /// As asked, then those of removed bodies, then parents of new ones, each once.
  std::vector<Index> removed_tets{};
  Index first_removed_parent = 0;  ///< entries of removed_tets from here on are parents of new ones
  std::vector<Index> removed_edges{};  ///< whose last tetrahedron was removed
  /// [removed_tets] how many of removed_edges had gone when the tetrahedron had.
  std::vector<Index> removed_edge_ends{};
  std::vector<Index> removed_triangles{};  ///< as asked, then those of removed bodies
  std::vector<Index> removed_links{};      ///< as asked, then those to an emptied vertex
  /// Of removed tetrahedra and triangles, then of triangles that no longer share an edge.
  std::vector<Index> removed_hinges{};
  std::vector<Index> moved_hinges{};  ///< whose triangles have copies of vertices now
  /// That lost their last tetrahedron or triangle, or were particles: they stop, and tools let go.
  std::vector<Index> emptied_vertices{};
  std::vector<Index> weighed_vertices{};  ///< whose mass may be another; some more than once
  /// Before each change. Several changes of one tetrahedron have an entry each; the first entries
  /// are of edit.corner_moves, in their order.
  std::vector<ReshapedTet> reshaped_tets{};
  std::vector<Index> corner_edges{};       ///< of tetrahedra at corners that moved, ascending
  std::vector<Index> moved_edges{};        ///< of these, those with other ends
  std::vector<PartedEdge> parted_edges{};  ///< new, from first_new_edge on
  // New ones follow each other, in the order of the edit; new bodies' come last.
  Index first_new_vertex = 0;        ///< vertices from here on are new
  Index first_new_tet = 0;           ///< tetrahedra from here on are new
  Index first_new_triangle = 0;      ///< triangles from here on are new
  Index first_new_link = 0;          ///< links from here on are new
  Index first_new_hinge = 0;         ///< hinges from here on are new
  Index first_new_edge = 0;          ///< edges from here on are new
  Index first_new_body = 0;          ///< of edit.new_bodies.bodies()[0]
  std::uint64_t version_before = 0;  ///< Tissue::version() before the edit
  std::uint64_t version = 0;         ///< and after it

  /// Whether anything came that takes part in constraints.
  [[nodiscard]] bool adds() const noexcept {
    return brings_vertices() || !edit.new_tets.empty() || !edit.new_links.empty() ||
           !edit.unfix_vertices.empty() || !edit.fibres.empty();
  }
  /// Whether any vertex came, by itself or with a body.
  [[nodiscard]] bool brings_vertices() const noexcept {
    return !edit.new_vertices.empty() || !edit.new_bodies.bodies().empty();
  }
  /// The vertex that edit.new_bodies' first vertex has become.
  [[nodiscard]] Index first_vertex_of_bodies() const noexcept {
    return first_new_vertex + static_cast<Index>(edit.new_vertices.size());
  }
};

}  // namespace pbdsurg
