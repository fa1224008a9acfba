// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where two organs that lie close are joined: pairs of surface vertices, and a sheet to draw. Too
/// thin for tetrahedra, the tissue between them is what a surgeon cuts to free the gallbladder from
/// its bed. surgery/connective_tissue.h makes strands of the pairs.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// Where fibres of the membrane run.
struct MembraneLink {
  Index first;         ///< boundary vertex of the first mesh
  Index second;        ///< boundary vertex of the second mesh
  double rest_length;  ///< m, their distance
  Index fibres = 1;    ///< how many run there
};

/// Links each boundary vertex of `first` to its nearest boundary vertex of `second`, if that is
/// closer than `max_distance`: as dense as the mesh.
///
/// @param max_distance  m, positive and finite; 3.5 mm suits the built-in gallbladder and liver:
///                      the gap is 1 mm, and the inner side of the wall stays out of reach
/// @return  ascending by `first`; of equally near vertices that of the smaller id
/// @throws InvalidArgument  if the distance is out of range, or both are one mesh
/// @note Cost: O(n log n) while few vertices of `second` lie within max_distance of one point.
[[nodiscard]] PBDSURG_API std::vector<MembraneLink> membrane_links(const TetMesh& first,
                                                                   const TetMesh& second,
                                                                   double max_distance);

/// How far fibres reach, and how many there are.
struct ScatterOptions {
  double max_distance = 3.5e-3;  ///< m, of a link, or between surfaces; positive
  double density = 0.5e6;        ///< fibres per m^2 of the first surface, positive
  std::uint64_t seed = 1;        ///< the same seed and meshes give the same links
};

/// Scatters fibres at random over the first surface, as dense as asked whatever the mesh is, and
/// leads each from the nearest corner to the vertex of the second surface that is nearest to it and
/// in sight: the two surfaces must look at each other there, and the way between must pass through
/// neither body. Fibres with the same ends are one link.
///
/// @return  ascending by `first`, then `second`
/// @throws InvalidArgument  naming the option out of range, or for more than 1e8 fibres, or if both
///                          are one mesh
/// @note Cost: O(n log n + fibres) while few vertices lie within max_distance of one point and
///       triangles are of similar size.
[[nodiscard]] PBDSURG_API std::vector<MembraneLink> scattered_links(const TetMesh& first,
                                                                    const TetMesh& second,
                                                                    const ScatterOptions& options);

/// Scatters fibres over where the first surface faces the second, within 60 degrees, from less than
/// max_distance, or lies within the second body: as many for an area, and in the same places,
/// whatever the meshes are. Each leads from the nearest corner to the vertex of the second body
/// that is nearest to the facing point, so on coarse meshes links may be longer than the gap, and
/// one may stand for many fibres.
///
/// @return  ascending by `first`, then `second`; empty if a mesh is
/// @throws InvalidArgument  as scattered_links()
/// @note Cost: O(n log n + fibres log n) for triangles and edges of similar size.
[[nodiscard]] PBDSURG_API std::vector<MembraneLink> links_by_area(const TetMesh& first,
                                                                  const TetMesh& second,
                                                                  const ScatterOptions& options);

/// A sheet halfway along the links: the boundary triangles of `first` all of whose corners are
/// linked.
///
/// @return  point i belongs to link i, so that a viewer moves it to the middle of that link; cut
///          links take their triangles away
/// @throws InvalidArgument  naming the vertex of a link that its mesh lacks
[[nodiscard]] PBDSURG_API MeshData membrane_sheet(const TetMesh& first, const TetMesh& second,
                                                  std::span<const MembraneLink> links);

}  // namespace pbdsurg
