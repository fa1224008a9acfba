// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A colouring that lives on while constraints come and go.

#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg {

/// Changes to a set of constraints, made together: first what is removed, then merged, then
/// inserted. A view: owns nothing, and must not point into the colouring that it is applied to.
struct ConstraintEdit {
  std::span<const Index> removed;  ///< ids
  /// Pairs of ids: the first takes over the vertices of the second, which is then gone, and lists
  /// them in ascending order. The first may be named again to take over more. Of fixed arity, both
  /// must have the same vertices, and the first is left as it is.
  std::span<const std::pair<Index, Index>> merged;
  ConstraintVertices inserted;  ///< of the arity of the set; its vertex_count is not read
};

/// What an edit did to the colouring.
struct ColoringUpdate {
  std::vector<Index> inserted;   ///< [inserted constraints] their ids
  std::vector<Index> recolored;  ///< ids, ascending, that were there before and changed colour
};

/// The constraints that are there and their colouring, as the functions of this module take them.
struct PBDSURG_API ColoringExtract {
  std::vector<Index> ids;       ///< [constraint_count] ascending; id of each constraint
  std::vector<Index> vertices;  ///< constraint by constraint
  std::vector<Index> offsets;   ///< [constraint_count + 1], empty for fixed arity
  int arity = 1;                ///< 0 where `offsets` says
  Index vertex_count = 0;       ///< of the set: DynamicColoring::vertex_count()
  Coloring coloring;            ///< of these constraints: color_of[i] is that of ids[i]

  [[nodiscard]] ConstraintVertices constraints() const;  ///< a view of this
};

/// Constraints, their colours, and all that is needed to change both in time proportional to the
/// change. Ids and colours of constraints that an edit does not name stay what they are, but for
/// the few in ColoringUpdate::recolored.
///
/// The constraints of an edit are coloured in the order of falling valence. Each takes the emptiest
/// colour that is free for it, and the lowest of those. Where none is free, one or two others that
/// hold a colour around it move to colours that are free for them (one-step ejection). Where they
/// cannot, it takes the colour of one of them, which then is in its place, and so on for up to 64
/// steps. Where that fails, too, there is a new colour. As many colours as the clique bound are
/// there from the outset, so inserting all constraints of a mesh into an empty set colours it
/// evenly; that counts as a full colouring.
///
/// What an edit leaves out of bounds it then mends, as far as moves of up to eight constraints for
/// each that it names do:
/// - There should be at most one colour more than the clique bound, now or at the last full
///   colouring if that was larger; where that needed more than one more, as many more. Of further
///   colours the last is emptied into the others, and nothing new goes there. One that cannot be
///   emptied stays until the clique bound falls.
/// - The sizes of the colours should deviate by at most 0.04, or by one constraint. If they deviate
///   by more than the most even ones would, members of the largest colour go to the smallest that
///   is free for them. So a new colour is filled at once.
/// Within these bounds nothing moves. A colour opened or closed takes constraint_count() /
/// color_count() moves or a little more, so after edits of a hundredth of the constraints the
/// bounds hold, unless one edit changes the clique bound by more than about a twentieth. After
/// smaller edits they may be exceeded until there have been enough: one constraint that opens the
/// 60th colour leaves a deviation of 0.13, which the next edits reduce.
///
/// Colours keep their numbers. One that has lost all its constraints stays, and is the first to be
/// filled; but after an edit the last colour is never empty.
///
/// The result depends on the calls and their order alone. Memory: colours / 8 bytes a vertex, and
/// about 10 bytes for each vertex that a constraint names, and 8 for each constraint.
class PBDSURG_API DynamicColoring {
 public:
  /// Takes a colouring over; ids are those of the constraints. Cost: O(vertices named + vertices *
  /// colours / 64).
  /// @throws InvalidArgument  as find_conflict(), or if there is a conflict or overflow
  DynamicColoring(const ConstraintVertices& constraints, const Coloring& coloring);
  ~DynamicColoring();
  /// Takes over. The other can then only be destroyed or assigned to.
  DynamicColoring(DynamicColoring&&) noexcept;
  DynamicColoring& operator=(DynamicColoring&&) noexcept;  ///< likewise

  /// Makes room for vertices with ids from vertex_count() on. Cost: O(count), amortised.
  /// @throws InvalidArgument  if count is negative or there would be more than 2^31 - 1
  void add_vertices(Index count);

  /// Applies an edit, all of it or nothing (but for want of memory). Ids that it frees are the
  /// first to be given to what it inserts.
  ///
  /// Cost a constraint, placed or moved: O(arity * colours / 64 + colours + constraints at its
  /// vertices), 0.2 to 0.5 us for tetrahedra, 1.5 us at a million; and up to O(arity *
  /// colours^2 / 64) for each step of one that finds no colour free. Only when the colours outgrow
  /// the masks, which then grow by half, are those of all vertices touched. Nothing but the result
  /// is allocated once the largest size has been reached.
  /// @throws InvalidArgument  naming the id that is not there, or that goes and is named again; a
  ///                          merge that does not fit the arity; the inserted constraint whose
  ///                          vertex is out of range or occurs twice; inserted arrays that do not
  ///                          fit the arity, or more than 2^31 - 1 vertices named in all
  ColoringUpdate apply(const ConstraintEdit& edit);

  [[nodiscard]] int arity() const;               ///< vertices a constraint, 0 where it varies
  [[nodiscard]] Index vertex_count() const;      ///< vertex ids are in [0, vertex_count)
  [[nodiscard]] Index constraint_count() const;  ///< those that are there
  [[nodiscard]] Index id_count() const;          ///< ids are in [0, id_count)
  [[nodiscard]] bool contains(Index id) const;   ///< whether it is there; any id may be asked
  /// The vertices of a constraint, as given, or ascending after a merge.
  /// Until the next edit.
  /// @throws InvalidArgument  if there is no such constraint
  [[nodiscard]] std::span<const Index> vertices(Index id) const;
  /// The colour of a constraint, in [0, color_count()).
  /// @throws InvalidArgument  if there is no such constraint
  [[nodiscard]] Index color(Index id) const;

  [[nodiscard]] Index color_count() const;                   ///< empty ones included
  [[nodiscard]] std::span<const Index> color_sizes() const;  ///< [color_count]
  /// Most constraints at one vertex now. Cost: O(1).
  [[nodiscard]] Index clique_bound() const;
  /// Standard deviation of the colours' sizes / their mean. Cost: O(1).
  [[nodiscard]] double relative_deviation() const;

  /// Whether colouring all anew would pay: compared with the last full colouring, more than two
  /// further colours above the clique bound, or a deviation larger by more than 0.1 and by more
  /// than one constraint. Never true straight after adopt(), so it cannot ask again and again for
  /// what the mesh does not allow.
  [[nodiscard]] bool recoloring_pays() const;

  /// A copy of what there is, to be coloured anew elsewhere.
  /// Cost: O(vertices named).
  [[nodiscard]] ColoringExtract extract() const;

  /// Takes over a full recolouring: extract.coloring, as made elsewhere. Cost: as the constructor.
  /// @throws InvalidArgument  as the constructor, or if the extract's constraints are not those
  ///                          that are there; then nothing has changed
  void adopt(const ColoringExtract& extract);

 private:
  struct Data;
  Owned<Data> data_;
};

}  // namespace pbdsurg
