// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Changes to living tissue: the only way in which topology changes.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// A new rest length of a live edge of a body of springs. A strain limit follows.
struct RestLengthChange {
  Index edge;
  float rest_length;  ///< m, positive and finite
};

/// A new rest volume of a live tetrahedron of a body with volume constraints or of a Neo-Hookean
/// body, whose rest shape is then scaled evenly.
struct RestVolumeChange {
  Index tet;
  float rest_volume;  ///< m^3, positive and finite
};

/// What to change, all at once. Ids are those of the solver, which never change meaning.
struct TopologyEdit {
  std::vector<Index> remove_tets{};
  std::vector<Index> remove_links{};
  std::vector<RestLengthChange> rest_lengths{};
  std::vector<RestVolumeChange> rest_volumes{};
};

/// What an edit removed, consequences included. Vertices keep their ids for ever.
struct EditResult {
  std::vector<Index> tets;      ///< as asked
  std::vector<Index> edges;     ///< whose last tetrahedron went
  std::vector<Index> links;     ///< as asked, then those to a vertex that lost its last tetrahedron
  std::vector<Index> vertices;  ///< that lost their last tetrahedron: they stop, and tools let go
  std::uint64_t topology_version = 0;
};

/// Whoever holds something that follows topology: a heat field, collision data, render buffers.
class EditParticipant {
 public:
  virtual ~EditParticipant() = default;

  /// Refuses an edit by throwing; must change nothing.
  virtual void validate(const Solver& solver, const TopologyEdit& edit) const = 0;

  /// Follows an edit that all have accepted, after the solver did.
  /// @param result  what went, consequences included
  virtual void apply(const Solver& solver, const TopologyEdit& edit,
                     const EditResult& result) noexcept = 0;
};

/// Changes a solver's topology between two steps: all of it, or nothing.
///
/// A removed tetrahedron takes with it its share of mass, the edges that it was the last to use,
/// and links to a vertex that it was the last to use. Colours stay valid: constraints are only
/// removed; phases without a constraint leave the plan. Cost: proportional to the change, to the
/// number of phases and to what tools hold; participants add theirs.
///
/// @throws InvalidArgument  naming the first id that is out of range, dead or listed twice, or the
///                          value out of range; then nothing has changed
EditResult apply_edit(Solver& solver, const TopologyEdit& edit,
                      std::span<EditParticipant* const> participants = {});

}  // namespace pbdsurg
