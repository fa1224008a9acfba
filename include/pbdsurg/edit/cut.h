// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Cuts: from where a blade went to the edit that parts the tissue there.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// Where a cut runs: a surface with a rim, or a closed one.
struct CutSurface {
  std::vector<Eigen::Vector3f> points;  ///< m, world
  /// Point ids; neighbours run along their common edge in opposite directions, as in any surface
  /// whose triangles are wound alike.
  std::vector<Triangle> triangles;
};

/// A blade's cutting edge at one instant: a segment.
struct BladeEdge {
  Eigen::Vector3f first;   ///< m, world
  Eigen::Vector3f second;  ///< m, world
};

/// What a blade sweeps: two triangles between each two instants. Left out are those without area,
/// as from a blade that rests or slides along itself, and those that turn back on the way before,
/// as from a trembling hand: by more than 150 degrees.
/// @param instants  [n] in the order of time
/// @throws InvalidArgument  naming the instant that is not finite
[[nodiscard]] CutSurface sweep_blade(std::span<const BladeEdge> instants);

/// Where tissue parts.
enum class CutStyle : std::uint8_t {
  /// Along faces that are there, nearest to the surface: makes no tetrahedron, leaves steps as
  /// large as tetrahedra, and may loosen a single one.
  along_faces,
  /// Along the surface: divides the tetrahedra that it crosses.
  through_tets,
};

struct CutOptions {
  CutStyle style = CutStyle::through_tets;
  /// In [0.01, 0.4]: an edge that is crossed within this share of its length of a vertex parts at
  /// the vertex. Larger makes better tetrahedra and a rougher cut. Each part of a tetrahedron keeps
  /// at least the third power of it of the volume.
  float snap = 0.2F;
};

/// Plans a cut through the tissue as it lies now: all bodies that the surface crosses.
///
/// A tetrahedron is cut whole or not at all: if the middle of the section lies on the surface, even
/// where the surface ends within. Its crossed edges get a vertex each and are bisected one after
/// the other, in the order of their vertices, in all tetrahedra around them:
///
///     d                d                       one of a's three crossed edges and its neighbour c:
///     |\               |\                      bisecting a-d at q, then a-c at p. Both tetrahedra
///     | \      a-d     q.\     a-c             on a face bisect its edges in the same order, so
///     |  \     -->     |.'\    -->             they agree on its triangles, whatever else is done
///     |   \            | '.\                   to either.
///     a----c           a--p-c
///
/// So the mesh stays conforming, children have positive volume and fill their parent, and
/// neighbours that are not cut themselves are divided without being parted. Then faces between one
/// side of the surface and the other part, and a vertex is split where the tetrahedra around it no
/// longer hang together by faces: the part with the smallest tetrahedron keeps it, others get
/// copies. Where the surface ends, vertices stay whole: that is the front of the cut. Faces whose
/// three vertices all lie there stay closed, too, and nothing remembers them: let each sweep reach
/// back over the last edge length of the blade's path. Cutting twice in one place changes nothing
/// more.
///
/// Links are not cut. Those at a vertex that is split go to the copy on that side of the surface
/// on which their middle lies.
///
/// The result is for apply_edit() before anything else happens to the solver; empty if no tissue is
/// crossed. Tetrahedra with a vertex that is not finite are not cut.
///
/// Cost: O(vertices + tets) to find what is near, then vertices near the surface times triangles.
/// @param copy  the one whose positions count
/// @throws InvalidArgument  naming the point that is not finite or does not exist, the triangle
///                          without area, the edge with more than two triangles or where they are
///                          wound differently or folded flat, the option out of range, or if there
///                          is no triangle
[[nodiscard]] TopologyEdit plan_cut(const Solver& solver, const CutSurface& surface,
                                    const CutOptions& options = {}, Index copy = 0);

}  // namespace pbdsurg
