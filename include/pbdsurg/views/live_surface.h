// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The surface of living tissue, kept up to date through edits, for renderers and contact.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/change_log.h"

namespace pbdsurg {

/// One of the four triangles of a tetrahedron, or one of the two sides of a sheet's triangle.
struct TetFace {
  Index tet = kInvalidIndex;  ///< scene tetrahedron; of a sheet, its triangle
  /// In kTetTriangles: it lies opposite to this corner. Of a sheet 0 for the side that sees the
  /// triangle's corners run counter-clockwise, and 1 for the other.
  Index face = 0;
};

/// Boundary triangles of a body's live tetrahedra, or both sides of a sheet's live triangles, in
/// slots that make an index buffer: a triangle keeps its slot for as long as it exists, and a slot
/// without one holds a triangle without area, so that all slots can be drawn as they are. A slot
/// that came free last is taken first.
///
/// Follows edits of its body. Cost of an edit and of its
/// undo: O(changed), and O(k log k) of k tetrahedra that move or come to be; memory that was needed
/// once is kept. Construction: O(T log T) in the body's tetrahedra.
class PBDSURG_API LiveSurface final : public Follower,
                                      public std::enable_shared_from_this<LiveSurface> {
 public:
  /// What a slot without a triangle holds.
  static constexpr Triangle kEmptyTriangle{0, 0, 0};

  /// @throws InvalidArgument  if there is no such body
  LiveSurface(const Tissue& tissue, Index body);

  /// Slots, those without a triangle included.
  [[nodiscard]] Index slot_count() const noexcept { return triangles_.size(); }
  /// Slots with a triangle.
  [[nodiscard]] Index triangle_count() const noexcept { return slot_count() - free_slots_.size(); }

  /// [slot_count] scene vertices, wound so that normals point out of the tissue.
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept { return triangles_.values(); }

  /// [slot_count] where each triangle comes from; the tetrahedron is kInvalidIndex in empty slots.
  [[nodiscard]] std::span<const TetFace> origins() const noexcept { return origins_.values(); }

  /// Whether it is of a sheet: each triangle is there twice, once a side.
  [[nodiscard]] bool is_two_sided() const noexcept { return face_count_ == 2; }

  /// Whether any triangle is at a scene vertex: none is at those of other bodies.
  /// @throws InvalidArgument  naming the vertex that is not of the scene
  [[nodiscard]] bool is_on_surface(Index vertex) const;

  /// Grows with every slot that changes, back as well as forth. Above zero.
  [[nodiscard]] std::uint64_t version() const noexcept { return changes_.version(); }

  /// Which slots a reader has to copy that has seen a version: any number of readers, each with its
  /// own. Ranges are ascending; those less than kJoinedGap apart are one, because a call costs a
  /// renderer more than the bytes. A reader far behind gets all slots.
  /// Cost: O(k log k) in the k changes since.
  /// @param since   a version() read before; zero for a reader that has seen none
  /// @param ranges  replaced
  void collect_changes(std::uint64_t since, std::vector<SlotRange>& ranges) const {
    changes_.collect(since, slot_count(), ranges);
  }
  static constexpr Index kJoinedGap = ChangeLog::kJoinedGap;  ///< slots; of collect_changes()

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

  /// How many compactions it has gone along with: who keeps ids of it sees that they are old.
  [[nodiscard]] int renumberings() const noexcept { return renumberings_; }

  /// kInvalidIndex once a compaction has left it out
  [[nodiscard]] Index body() const noexcept { return body_; }

 private:
  // Elements are tetrahedra, or triangles of a sheet.
  // What the body came with follows each other; from `later` on come those that edits brought, of
  // all bodies.
  struct Numbering {
    Index first, count, later;
    [[nodiscard]] Index local(Index id) const noexcept {
      return id < later ? id - first : count + id - later;
    }
    [[nodiscard]] Index scene(Index local) const noexcept {
      return local < count ? first + local : later + local - count;
    }
    [[nodiscard]] bool has(Index id) const noexcept {
      return (id >= first && id < first + count) || id >= later;
    }
  };
  struct OpenFace {
    Triangle key;  // ascending
    Index face;
  };

  void number(const Tissue& tissue);
  [[nodiscard]] bool is_own(Index element) const noexcept;
  void follow_tets(const Tissue& tissue, const TissueChange& change);
  void follow_triangles(const TissueChange& change);
  [[nodiscard]] Triangle vertices_of(const Tissue& tissue, Index face) const noexcept;
  void detach(Index face);
  void open(Index face);
  void remove(Index element);
  void join_open_faces(const Tissue& tissue);
  void show_open_faces(const Tissue& tissue);
  void hide(Index slot);

  Index body_;            // kInvalidIndex once a compaction has left it out
  Index face_count_ = 4;  // of an element: of a sheet, 2
  Numbering elements_, vertices_;
  // [face_count_ * own elements] for face face_count_ * local element + place: the face it shares,
  // or a state below zero
  UndoArray<Index> faces_;
  UndoArray<Triangle> triangles_;      // [slot_count]
  UndoArray<TetFace> origins_;         // [slot_count]
  UndoArray<Index> free_slots_;        // the last is taken first
  UndoArray<Index> vertex_triangles_;  // [own vertices] how many triangles are at each
  // scratch: faces that an edit left without a partner, as they came and by their vertices
  std::vector<Index> open_;
  std::vector<OpenFace> sorted_open_;

  ChangeLog changes_;
  int renumberings_ = 0;
  std::uint64_t version_before_ = 1;  // the last edit
};

/// The surface of a body that all who ask for it share, made by the first.
/// @throws InvalidArgument  if there is no such body
[[nodiscard]] PBDSURG_API std::shared_ptr<const LiveSurface> shared_surface(const Tissue& tissue,
                                                                            Index body);

}  // namespace pbdsurg
