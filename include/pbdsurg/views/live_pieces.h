// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The connected pieces of living tissue, kept up to date through edits.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// Small parts that an edit drops along.
struct Crumbs {
  Index parts = 0;  ///< how many
  Index tets = 0;   ///< of all parts
};

/// Which live tetrahedra hang together, through shared vertices; links do not join.
///
/// When an edit takes a piece apart, the part with most tetrahedra (of equal ones, that with the
/// smallest tetrahedron id) keeps its id; the others get the ids that follow, in the order of their
/// smallest tetrahedra. Ids are never used again; a piece that is all gone has no tetrahedra.
/// Bodies that come in are pieces of their own.
///
/// Searches start from all vertices of
/// what changed, advance in turns, and merge where they meet, until of those around each change one
/// is left. So an edit costs O(smaller parts) where it frees any, and else what it takes the
/// searches to meet: their neighbourhood where tissue is solid, up to the whole piece where the
/// edit opens a ring. Undo costs as much as the edit wrote: O(changed + smaller parts).
class PBDSURG_API LivePieces final : public Follower {
 public:
  /// All pieces there are, in the order of their smallest vertices. Cost: O(V + T).
  explicit LivePieces(const Tissue& tissue);

  /// How many pieces there ever were; ids are below.
  [[nodiscard]] Index count() const noexcept { return pieces_.size(); }

  /// Pieces from here on are those that the last edit freed, then those of bodies it brought.
  [[nodiscard]] Index first_freed() const noexcept { return first_freed_; }

  /// The piece of a live tetrahedron, kInvalidIndex of one that is gone.
  /// @throws InvalidArgument  naming the tetrahedron that is not of the scene
  [[nodiscard]] Index piece_of(Index tet) const;

  /// @name One piece
  /// These functions throw InvalidArgument, naming the piece out of [0, count()).
  /// @{

  /// The body that its tissue is from; kInvalidIndex once a compaction has left that out.
  [[nodiscard]] Index body(Index piece) const { return checked(piece).body; }

  /// Its live tetrahedra; 0 once it is all gone.
  [[nodiscard]] Index tet_count(Index piece) const { return checked(piece).tet_count; }

  /// Its tetrahedra, ascending. Cost: O(n log n) in these.
  [[nodiscard]] std::vector<Index> tets(Index piece) const;

  /// Whether it has a vertex that cannot move.
  [[nodiscard]] bool is_anchored(Index piece) const { return checked(piece).anchor_count > 0; }

  /// @}

  /// Adds to an edit, before it is applied, the removal of parts that its removals would free and
  /// that have fewer than `smallest` tetrahedra, so that crumbs go in the same transaction. A part
  /// with tissue that the edit moves, splits, links, fixes or unfixes stays, and so does the
  /// largest of each piece, however small. Ids that Tissue::apply() refuses are passed over. Cost:
  /// as of the edit.
  /// @throws InvalidArgument  if the pieces do not follow the tissue
  Crumbs add_crumbs(const Tissue& tissue, TopologyEdit& edit, Index smallest);

  /// Vertices that the searches of the last edit, or for its crumbs, have visited.
  [[nodiscard]] Index visited() const noexcept { return visited_count_; }

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  struct Piece {
    Index body;
    Index tet_count;
    Index anchor_count;  // vertices that cannot move
    Index first_tet;     // of its list, kInvalidIndex if it is empty
  };
  struct PieceTet {
    Index piece, next, previous;  // in the list of the piece
  };
  struct VertexList {  // through next_
    Index first = kInvalidIndex;
    Index last = kInvalidIndex;
  };
  struct Part {
    Index parent;  // the part that it merged into, or itself
    Index piece;   // that it is a part of
    Index group;
    VertexList done{}, waiting{};
    Index tet_count = 0;  // this and the next once nothing waits
    Index smallest_tet = kInvalidIndex;
  };
  // Parts around one change; groups merge with their parts. What was one piece hung together
  // through the changes and their parts, so a group has done when no more than one part goes on.
  struct Group {
    Index parent;  // as of parts
    Index active = 0;
  };
  struct Rest {                  // of a piece that an edit changes
    Index part = kInvalidIndex;  // one that did not need to be searched through
    Index leaving = 0;           // tetrahedra
  };

  [[nodiscard]] const Piece& checked(Index piece) const;
  template <class Visit>
  void for_each_tet_at(const Tissue& tissue, Index vertex, Visit visit) const;
  void add_pieces(const Tissue& tissue, const Components& components, Index first_vertex);
  void add_bodies(const Tissue& tissue, const Scene& bodies);
  void add_tet(Index piece, Index tet);
  void remove_tet(Index tet);
  void free_part(const Tissue& tissue, const Part& part);

  void append(VertexList& list, Index vertex);
  void join(VertexList& list, const VertexList& other);
  [[nodiscard]] Index add_group();
  void start_search(Index vertex, Index piece, Index group);
  void start_searches(const Tet& vertices, Index piece, Index group);
  void merge_groups(Index a, Index b);
  void merge(Index into, Index part);
  void advance(const Tissue& tissue, Index part);
  void count_tets(const Tissue& tissue, Part& part) const;
  void find_freed_parts(const Tissue& tissue);
  void clear_searches();

  UndoArray<Piece> pieces_;
  UndoArray<PieceTet> tets_;  // [tet_count]
  Index first_freed_, first_freed_before_;

  // scratch of searches
  std::vector<Part> parts_;
  std::vector<Index> part_of_;  // [vertex_count] kInvalidIndex where no search has been
  std::vector<Index> next_;     // [vertex_count] in the lists of a part
  std::vector<Index> seen_;     // vertices in parts
  std::vector<Index> active_;   // parts that go on
  std::vector<Group> groups_;
  std::vector<Rest> rests_;    // [piece]
  std::vector<Index> freed_;   // parts that do not keep the id of their piece
  std::vector<bool> leaving_;  // [tet_count] as good as removed
  Index visited_count_ = 0;
};

}  // namespace pbdsurg
