// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Tetrahedral meshes from implicit shapes and from triangle surfaces.
///
/// Isosurface stuffing on a body-centred cubic lattice (Labelle and Shewchuk 2007, "Isosurface
/// stuffing: fast tetrahedral meshes with good dihedral angles") followed by guarded smoothing. Of
/// resolved shapes no tetrahedron is inverted, the boundary is a closed manifold, and dihedral
/// angles lie between about 22 and 145 degrees (16 and 160 in thin tubes).

#include <cstdint>
#include <functional>
#include <optional>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// Which connected pieces of a mesh to keep.
enum class Pieces { largest, all };

/// What mesh is wanted. Either `spacing` or `vertex_count` must be given.
struct TetrahedralizeOptions {
  /// m, lattice cell; edges come out 0.3 to 1.6 times as long. A wall needs cells of at most 0.89
  /// of its thickness, a tube of at most 0.7 of its diameter (better 0.45): thinner parts get
  /// holes or vanish, and gaps narrower than about half a cell may close. With `vertex_count`,
  /// where to begin the search.
  double spacing = 0;

  /// Wanted number of vertices; the spacing is then searched for until it is met within 0.5 %, or
  /// as nearly as the shape allows. Zero: the spacing decides.
  Index vertex_count = 0;

  Pieces pieces = Pieces::largest;  ///< which to keep

  /// Smoothing sweeps; none leaves dihedral angles of 10 degrees in place.
  int smoothing_sweeps = 5;

  /// V - E + F - T that the mesh must have: 1 for a ball, 2 for a hollow ball. Give it where it is
  /// known: a hole in a thin wall shows in no other way.
  std::optional<int> euler;

  /// Most lattice cells in and near the shape; bounds time (about 2 us a cell) and memory (about
  /// 100 bytes a cell).
  std::int64_t max_cells = 10'000'000;
};

/// How a mesh came about.
struct TetrahedralizeReport {
  double spacing = 0;       ///< m, lattice cell in the end
  int meshes_made = 0;      ///< attempts, the last one included
  int unsound_meshes = 0;   ///< attempts thrown away for a pinched boundary or a wrong `euler`
  int bridges = 0;          ///< balls of 0.7 spacings that thicken the shape where it was pinched
  int pieces = 0;           ///< connected pieces found
  Index dropped_tets = 0;   ///< tetrahedra of the pieces that were not kept
  int euler = 0;            ///< V - E + F - T of the mesh
  int boundary_shells = 0;  ///< connected pieces of the boundary
  double min_dihedral = 0;  ///< rad
  double max_dihedral = 0;  ///< rad
  /// Share of the boundary vertices under which the body is thinner than the spacing can resolve
  /// (spacing / 0.89). Feathered edges give a few hundredths; more means lost or torn parts.
  double thin_share = 0;
};

/// A mesh, and how it came about.
struct Tetrahedralization {
  TetMesh mesh;                 ///< in m
  TetrahedralizeReport report;  ///< how it came about
};

/// A shape that depends on the lattice, such as a wall of just resolvable thickness.
using ShapeAtSpacing = std::function<ImplicitShape(double spacing)>;

/// Fills a shape with tetrahedra.
///
/// Deterministic: equal arguments give equal bytes. An attempt whose boundary is pinched is
/// repeated with another lattice position, then with a 3 % smaller spacing.
/// @throws InvalidArgument  if options are out of range, the shape is unbounded, not finite or far
///                          from distance-like, or more than max_cells are needed
/// @throws InvalidMesh      if nothing is inside at this spacing, if no attempt is sound, or if the
///                          wanted number of vertices cannot be met within 10 %; of a shape that is
///                          too thin, it says how thick it is, the spacing and number of vertices
///                          that would do (within a fifth for a sheet), and how thick it must be
///                          for what was asked; a search without a sound mesh so far ends where
///                          twice the wanted vertices would not do
/// @note Cost: about 0.1 s per 1000 boundary vertices of a simple shape, on one thread.
[[nodiscard]] PBDSURG_API Tetrahedralization tetrahedralize(const ImplicitShape& shape,
                                                            const TetrahedralizeOptions& options);

/// Same for a shape that follows the spacing.
[[nodiscard]] PBDSURG_API Tetrahedralization tetrahedralize(const ShapeAtSpacing& shape_at_spacing,
                                                            const TetrahedralizeOptions& options);

/// Fills a triangle surface with tetrahedra: open, crossing and badly wound ones too, see
/// SurfaceDistance. The surface is followed within the spacing, not vertex by vertex.
///
/// @param surface  points in m; its triangles, or the boundary of its tetrahedra if it has none
/// @throws InvalidMesh  also if the surface encloses nothing
[[nodiscard]] PBDSURG_API Tetrahedralization tetrahedralize(const MeshData& surface,
                                                            const TetrahedralizeOptions& options);

}  // namespace pbdsurg
