// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where two organs that lie close are joined: pairs of surface vertices, and a sheet to draw. Too
/// thin for tetrahedra, the tissue between them is what a surgeon cuts to free the gallbladder from
/// its bed. surgery/connective_tissue.h makes strands of the pairs.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/scene.h"

namespace pbdsurg {

/// What fibres end at: the boundary of a solid, or a sheet, whose two sides are one surface.
struct PBDSURG_API LinkedSurface {
  /// Of a solid. Cost: O(n log n).
  /// @param mesh  must outlive this
  LinkedSurface(const TetMesh& mesh);  // NOLINT(google-explicit-constructor): a mesh is one

  /// Of a body of a scene, likewise; that of a sheet is all of it.
  /// @param scene  must outlive this, and stay as it is
  /// @throws InvalidArgument  naming the body that there is not
  LinkedSurface(const Scene& scene, Index body);

  std::span<const Eigen::Vector3d> positions;  ///< [vertex_count of the body] m
  /// Vertices of the body; of a solid those that see them run counter-clockwise are outside.
  std::vector<Triangle> triangles;
  bool is_two_sided = false;  ///< a sheet
};

/// Where fibres of the membrane run.
struct MembraneLink {
  Index first;         ///< vertex of the first surface
  Index second;        ///< vertex of the second surface
  double rest_length;  ///< m, their distance
  Index fibres = 1;    ///< how many run there
};

/// Links each vertex of the surface `first` to its nearest vertex of the surface `second`, if that
/// is closer than `max_distance`: as dense as the mesh.
///
/// @param max_distance  m, positive and finite; 3.5 mm suits the built-in gallbladder and liver:
///                      the gap is 1 mm, and the inner side of the wall stays out of reach
/// @return  ascending by `first`; of equally near vertices that of the smaller id
/// @throws InvalidArgument  if the distance is out of range, or both are one body
/// @note Cost: O(n log n) while few vertices of `second` lie within max_distance of one point.
[[nodiscard]] PBDSURG_API std::vector<MembraneLink> membrane_links(const LinkedSurface& first,
                                                                   const LinkedSurface& second,
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
/// neither body. A sheet has as many fibres for its area as one side of a solid, each on the side
/// where it finds an end. Fibres with the same ends are one link.
///
/// @return  ascending by `first`, then `second`
/// @throws InvalidArgument  naming the option out of range, or for more than 1e8 fibres, or if both
///                          are one body
/// @note Cost: O(n log n + fibres) while few vertices lie within max_distance of one point and
///       triangles are of similar size.
[[nodiscard]] PBDSURG_API std::vector<MembraneLink> scattered_links(const LinkedSurface& first,
                                                                    const LinkedSurface& second,
                                                                    const ScatterOptions& options);

/// Of solids: scatters fibres over where the first surface faces the second, within 60 degrees,
/// from less than max_distance, or lies within the second body: as many for an area, and in the
/// same places, whatever the meshes are. Each leads from the nearest corner to the vertex of the
/// second body that is nearest to the facing point, so on coarse meshes links may be longer than
/// the gap, and one may stand for many fibres.
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
