// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What heat does to topology and rest shape.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/renumbering.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// State of a live element of a conducting body by algorithm 2 and the rule of the field.
[[nodiscard]] HeatState heat_state(const HeatField& field, Index element);

/// Finds the elements that heat takes away, shrinks or stiffens, among what is heated.
class HeatChanges {
 public:
  HeatChanges(const HeatField& field, const CauteryOptions& options);

  /// Adds to an edit what is due after a time of heating, and what the last edit should have taken
  /// that lives: it was refused or undone.
  /// @param dt      s since the last call
  /// @param energy  J delivered since the start: elements that could not have been boiled dry
  ///                with what earlier ones left of it are deferred
  /// Cost: O(heated part).
  void collect(const Solver& solver, const HeatField& field, double dt, double energy,
               TopologyEdit& edit);

  /// Counts the elements of the last collect() as removed.
  void commit() noexcept { spent_ += due_energy_; }

  /// J that it would have cost to warm and boil dry all elements removed.
  [[nodiscard]] double spent() const noexcept { return spent_; }

  // of the last collect()
  [[nodiscard]] double removed_volume() const noexcept { return due_volume_; }
  [[nodiscard]] Index torn_count() const noexcept { return torn_; }
  [[nodiscard]] Index deferred_count() const noexcept { return deferred_count_; }

  /// Elements that were due.
  [[nodiscard]] std::span<const DueElement> pending() const noexcept { return pending_; }

  /// Goes back to where these were so, after the field has.
  void restore(const HeatField& field, double spent, std::vector<DueElement> pending) noexcept;

  /// Goes along with a compaction, after the field has.
  void renumber(const HeatField& field, const Renumbering& ids);

  void follow(const HeatField& field) noexcept;
  void undo(const HeatField& field) noexcept;

 private:
  // An element that is due.
  struct Due {
    Index element;
    double water;  // share left
    bool is_torn;
  };

  // A rest value, or a stiffness, that is due.
  struct Change {
    Index id;
    float value;
    float behind;  // the smaller, the farther what it is now is from there
  };

  [[nodiscard]] bool is_tearing(const HeatField& field, Index element, double water,
                                double dt) const;
  void find_marked(const HeatField& field);
  void find_due(const HeatField& field, double dt);
  void take_due(const HeatField& field, double energy, TopologyEdit& edit);
  void remember(const HeatField& field, std::size_t taken);
  [[nodiscard]] const DueElement* find_pending(Index element) const;
  void shrink(const Solver& solver, const HeatField& field, TopologyEdit& edit);
  void shrink_triangle(const Solver& solver, const HeatField& field, Index triangle);
  void stiffen(const Solver& solver, const HeatField& field, TopologyEdit& edit);
  void keep_farthest();
  template <class OfTet, class OfTriangle>
  void add_due(std::vector<OfTet>& of_tets, std::vector<OfTriangle>& of_triangles);
  [[nodiscard]] double shrunk(const HeatField& field, Index first, Index second) const;

  [[nodiscard]] bool is_marked(const HeatField& field, Index vertex) const;

  bool stiffens_;  // some tissue does
  double tearing_rate_, tearing_loss_, boiled_shrinkage_;
  std::size_t shrink_limit_;             // 0: none
  double spent_ = 0, spent_before_ = 0;  // J
  double due_energy_ = 0, due_volume_ = 0;
  Index torn_ = 0, deferred_count_ = 0;
  std::vector<DueElement> pending_;  // asked for last, or waiting for energy; ascending
  std::vector<double> seen_water_;   // [vertex_count] at the last call

  // scratch
  std::vector<Index> marked_;          // elements, ascending
  ElementValues<std::uint32_t> seen_;  // round in which it was met
  std::uint32_t round_ = 0;
  std::vector<Due> due_;
  std::vector<Index> edges_;
  std::vector<Change> due_changes_;
};

}  // namespace pbdsurg
