// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random small bodies that come into a scene while it is edited.

#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/scene.h"

#include "tests/support/choices.h"

namespace pbdsurg::testing {

/// One or two bodies that the solver accepts, named as none of its own, of all materials that its
/// mode allows: blocks, a tetrahedron with a vertex that it does not use, or a thread of particles;
/// with fixed vertices and links between them.
[[nodiscard]] Scene make_bodies(const Solver& solver, Choices& choices);

/// Whether any tetrahedron has fibres; random edits bring some only then.
[[nodiscard]] bool has_fibres(const Tissue& tissue);

/// Along one of some directions; a third of them are none.
[[nodiscard]] Fibre make_fibre(Choices& choices);

/// Vertices of a scene that have mass.
[[nodiscard]] std::vector<Index> vertices_with_tissue(const Scene& scene);

}  // namespace pbdsurg::testing
