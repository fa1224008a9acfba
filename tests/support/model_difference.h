// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What of a solver, and of what follows its edits, is not as it must be: the first of it, in
/// words; empty if all is. All is found afresh from a plain model, in O(n log n) of the scene.

#include <string>

#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/live_model.h"

namespace pbdsurg::testing {

/// Bodies, topology, masses, every constraint with its vertices and parameters, colours and phases,
/// and who owns edges in a joint plan.
[[nodiscard]] std::string difference(const LiveModel& model, const Solver& solver);

/// The surface of a body, and whether find_live_boundary() finds the same.
[[nodiscard]] std::string difference(const LiveModel& model, const LiveSurface& surface,
                                     const Solver& solver, Index body);

[[nodiscard]] std::string difference(const LiveModel& model, const LivePieces& pieces);

/// Whole strands are those that have lost no link, and each event names one that has.
[[nodiscard]] std::string difference(const LiveModel& model, const ConnectiveTissue& tissue,
                                     const Solver& solver);

/// A field that has not been heated: heat must spread as in one that is made of what is left.
[[nodiscard]] std::string difference(const LiveModel& model, const HeatField& field,
                                     const ThermalProperties& tissue);

}  // namespace pbdsurg::testing
