// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The tissue near a cut, numbered by itself.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/surgery/cut.h"

namespace pbdsurg {

/// Tissue as a cut finds it, in the ids of a solver.
struct CutTissue {
  std::span<const Eigen::Vector3f> positions;  ///< [vertex_count] m
  const Tissue& live;
};

/// All that a cut can reach, so that what comes after finding it costs as much as there is near,
/// not as much as there is. Vertices, tetrahedra and links are numbered in the order of their ids,
/// so whatever goes by that order is as it would be with all tissue.
struct CutNeighborhood {
  std::vector<Index> vertex_ids, tet_ids, link_ids;  ///< ascending

  std::vector<Eigen::Vector3f> positions;  ///< [vertices] m
  std::vector<Tet> tets;                   ///< [tets]
  std::vector<Link> links;                 ///< [links] at least one end has a tetrahedron here
  std::vector<bool> is_reached;            ///< [vertices] whether all tetrahedra there are here
  CutFront front;
};

/// All tetrahedra at the vertices of those whose box meets another, and of a front.
/// Cost: a few nanoseconds for each vertex and tetrahedron that there is.
/// @param bounds  m
/// @throws InvalidArgument  naming the vertex of the front that does not exist
[[nodiscard]] CutNeighborhood find_neighborhood(const CutTissue& tissue,
                                                const Eigen::AlignedBox3d& bounds,
                                                const CutFront& front);

/// The same plan in the ids of a solver. @param vertex_count  of that
[[nodiscard]] CutPlan with_solver_ids(CutPlan plan, const CutNeighborhood& near,
                                      Index vertex_count);

}  // namespace pbdsurg
