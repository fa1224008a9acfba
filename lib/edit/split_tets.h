// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tetrahedra give way to others that fill them.

#include <array>
#include <optional>

#include "pbdsurg/edit/topology_edit.h"

#include "solver/solver_data.h"

namespace pbdsurg {

/// Shares of a parent's corners that make up those of a part of it: [corner of the part][of the
/// parent], each summing to one.
using Shares = std::array<std::array<double, 4>, 4>;

/// None where a vertex is no corner of the parent, copy of one, or on an edge of it.
[[nodiscard]] std::optional<Shares> find_shares(const SolverData& data, const TopologyEdit& edit,
                                                const NewTet& tet, Index first_new_vertex);

/// What part of the parent's volume it has; negative if it is turned inside out.
[[nodiscard]] double volume_share(const Shares& shares);

/// Puts new tetrahedra in the place of their parents. Rest values are those that the parents have
/// at the moment. Cost: proportional to the tetrahedra at their vertices.
void replace_parents(SolverData& data, const TopologyEdit& edit, EditResult& result);

}  // namespace pbdsurg
