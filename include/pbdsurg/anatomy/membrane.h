// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The membrane between two organs that lie close: links between their surfaces, and a sheet to
/// draw. Too thin for tetrahedra, it is what a surgeon cuts to free the gallbladder from its bed.

#include <span>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// A fibre of the membrane.
struct MembraneLink {
  Index first;         ///< boundary vertex of the first mesh
  Index second;        ///< boundary vertex of the second mesh nearest to it
  double rest_length;  ///< m, their distance
};

/// Links each boundary vertex of `first` to its nearest boundary vertex of `second`, if that is
/// closer than `max_distance`.
///
/// @param max_distance  m, positive and finite; 3.5 mm suits the built-in gallbladder and liver:
/// the
///                      gap is 1 mm, and the inner side of the wall stays out of reach
/// @return  ascending by `first`; of equally near vertices that of the smaller id
/// @throws InvalidArgument  if the distance is out of range
/// @note Cost: O(n log n) while few vertices of `second` lie within max_distance of one point.
[[nodiscard]] std::vector<MembraneLink> membrane_links(const TetMesh& first, const TetMesh& second,
                                                       double max_distance);

/// A sheet halfway along the links: the boundary triangles of `first` all of whose corners are
/// linked.
///
/// @return  point i belongs to link i, so that a viewer moves it to the middle of that link; cut
///          links take their triangles away
[[nodiscard]] MeshData membrane_sheet(const TetMesh& first, const TetMesh& second,
                                      std::span<const MembraneLink> links);

}  // namespace pbdsurg
