// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What happened to a solver's data between two steps.

#include <algorithm>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_plan.h"

namespace pbdsurg {

/// What a backend that keeps the state elsewhere takes over before its next step. Entries of lists
/// may repeat: each says where to look, and the data there is that after all changes. Lists are
/// only kept for such backends; their length is proportional to what edits changed.
struct Changes {
  struct Constraint {
    /// distance (edges, then links), volume, neo_hookean, strain_limit, bending; or vertex
    PhaseKind kind;
    /// Of the constraint, stable; or the place of a vertex whose rows or whose lane changed, or
    /// that no block has any more: not among the present ones if it is gone for good.
    Index id;
  };

  /// [copy] whether positions, velocities and carries were rewritten as a whole.
  std::vector<bool> state{true};
  /// Vertices that are new, or move as before an edit that was taken back: in all copies, position,
  /// velocity and carry are those of the host, even while the others there are out of date.
  /// Ascending, without repetition.
  std::vector<Index> moved;
  /// Tools were added, or what they hold changed; poses and targets change without this.
  bool tools = true;
  bool watched = true;  ///< the list of watched places is another
  struct Force {
    Index copy, place;
  };
  /// Where forces are others, of vertices that are not new. A vertex that moved brings its own.
  std::vector<Force> forces;
  bool gravities = true;  ///< SolverState::gravities are others
  /// Constraints were added, or such are gone again. They are in the lists below like any others;
  /// ids there that are not among the present ones are gone for good.
  bool grown = false;
  /// Rows of the vertex-block method were laid out anew. The two lists below say nothing of them.
  bool rows_anew = false;
  /// See VertexBlocks::changed_blocks().
  std::vector<Index> blocks;
  /// Of explicit steps: places whose share in StableSubstep is another.
  std::vector<Index> shares;
  /// Places whose inverse mass is another; where it is zero now, the velocity is, too.
  std::vector<Index> vertices;
  /// Constraints added, removed or back, gone, moved to another group, or with other vertices or
  /// parameters; vertices with other rows. Where a serial group lost or got one, the order of its
  /// others may have changed, too.
  std::vector<Constraint> constraints;
  /// Added, removed or back, gone, or with other vertices, whether they have constraints or not.
  std::vector<Index> tets;

  [[nodiscard]] bool any() const noexcept {
    return tools || watched || !forces.empty() || gravities || grown || rows_anew ||
           !blocks.empty() || !shares.empty() || !moved.empty() || !vertices.empty() ||
           !constraints.empty() || !tets.empty() ||
           std::find(state.begin(), state.end(), true) != state.end();
  }

  [[nodiscard]] bool has_moved(Index vertex) const {
    return std::ranges::binary_search(moved, vertex);
  }
  /// Cost: constant for new vertices, which come last.
  void add_moved(Index vertex) {
    const auto place = std::ranges::lower_bound(moved, vertex);
    if (place == moved.end() || *place != vertex) {
      moved.insert(place, vertex);
    }
  }

  void clear() noexcept {
    std::fill(state.begin(), state.end(), false);
    tools = watched = gravities = grown = rows_anew = false;
    forces.clear();
    blocks.clear();
    shares.clear();
    moved.clear();
    vertices.clear();
    constraints.clear();
    tets.clear();
  }
};

}  // namespace pbdsurg
