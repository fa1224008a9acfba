// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which vertices and edges meet which bodies in a substep, and where.

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

/// Whether there are bodies that are to meet each other.
[[nodiscard]] bool has_touches(const StepContext& step) noexcept;

/// Finds the contacts of a substep where it starts: each vertex of a body's surface with the
/// nearest point of another's, if that is within 1.5 thicknesses and the ways that both would go by
/// themselves. So two surfaces that touch have one contact a vertex, in the order of vertices, and
/// where two vertices face each other, that of the first body. Then come edges that cross, see
/// edge_touches.h: without room for all contacts they are the first that are dropped.
///
/// Outside is where the nearest triangle of a body faces. The vertex of a sheet's other side stays
/// there for as long as it is near. Bodies that are nearer than their thickness, or overlap by less
/// than three thicknesses, part at kRecovery at most; what is deeper is left alone.
///
/// Cost: O(n) of the vertices of these surfaces; O(n log n) of near ones, and of edges, when
/// anything has moved by a thickness or two since that was done last.
/// @param lengths  of the substep
void find_touches(const StepContext& step, const Substep<float>& lengths, StepReport& report);

/// Keeps what the next substep has to know.
void remember_touches(const StepContext& step, const Substep<float>& lengths);

}  // namespace pbdsurg
