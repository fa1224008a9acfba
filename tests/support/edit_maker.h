// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random good edits, of everything that an edit can hold.

#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// A cut by a random blade near tissue that is there, or the same blade's further way.
[[nodiscard]] CutPlan make_cut(const Solver& solver, const CutFront& front, Choices& choices);

/// Puts an edit together that its solver accepts: what one part of it takes, no other touches.
class EditMaker {
 public:
  /// @param edit  a good one, to which more is added
  EditMaker(const Solver& solver, Choices& choices, TopologyEdit edit = {});

  /// Adds some change of a random kind, but links.
  void add();

  /// Adds links, to new vertices and bodies, too: last, for what they hold on to must stay.
  void add_links();

  /// Fixes some vertices, unfixes others, changes rest lengths of links, and makes tissue stiffer:
  /// last, likewise.
  void fix_some();

  [[nodiscard]] const TopologyEdit& edit() const { return edit_; }

 private:
  enum class Use : unsigned char { none, moved, gone };

  [[nodiscard]] std::vector<Index> free_tets() const;
  [[nodiscard]] std::vector<Index> tets_at(Index vertex) const;
  [[nodiscard]] std::vector<Index> lasting_vertices() const;
  [[nodiscard]] bool is_link_free(Index link) const;
  Index add_vertex(Index first, Index second, float share);
  void remove_tets();
  void remove_links();
  void change_rest_lengths();
  void change_rest_volumes();
  void change_rest_areas();
  void part_vertex();
  void split_edge();
  [[nodiscard]] std::vector<Index> free_triangles() const;
  bool remove_triangles();
  bool part_sheet();
  void add_bodies();
  void remove_bodies();

  const Solver& solver_;
  Choices& choices_;
  TopologyEdit edit_;
  std::vector<Use> uses_;           // [tet_count]
  std::vector<Use> triangle_uses_;  // [triangle_count]
};

}  // namespace pbdsurg::testing
