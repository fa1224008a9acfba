// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tetrahedra give way to others that fill them.

#include <Eigen/Core>
#include <array>
#include <optional>

#include "lib/tissue/tissue_data.h"

namespace pbdsurg {

/// Shares of a parent's corners that make up those of a part of it: [corner of the part][of the
/// parent], each summing to one.
using Shares = std::array<std::array<double, 4>, 4>;

/// None where a vertex is no corner of the parent, copy of one, or on an edge of it.
/// @param corners  of the parent
[[nodiscard]] std::optional<Shares> find_shares(const Tet& corners, const TopologyEdit& edit,
                                                const NewTet& tet, Index first_new_vertex);

/// A part's sides from its first corner, in columns, in terms of the parent's.
[[nodiscard]] Eigen::Matrix3d sides_of(const Shares& shares);

/// What part of the parent's volume it has; negative if it is turned inside out.
[[nodiscard]] double volume_share(const Shares& shares);

/// Puts new tetrahedra in the place of their parents. Cost: proportional to the tetrahedra at their
/// vertices.
void replace_parents(TissueData& data, const TopologyEdit& edit);

}  // namespace pbdsurg
