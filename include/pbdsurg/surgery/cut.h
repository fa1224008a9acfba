// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Cuts: from where a blade went to the edit that parts the tissue there.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

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

/// That edge on its way from one instant to another: two triangles.
struct BladeSweep {
  BladeEdge before;  ///< at the first instant
  BladeEdge now;     ///< at the second
};

/// What a blade sweeps: two triangles between each two instants. Left out are those without area,
/// as from a blade that rests or slides along itself, and those that turn back on the way before,
/// as from a trembling hand: by more than 150 degrees.
/// @param instants  [n] in the order of time
/// @throws InvalidArgument  naming the instant that is not finite
[[nodiscard]] PBDSURG_API CutSurface sweep_blade(std::span<const BladeEdge> instants);

/// Where tissue parts.
enum class CutStyle : std::uint8_t {
  /// Along faces that are there, nearest to the surface: makes no tetrahedron, leaves steps as
  /// large as tetrahedra, and may loosen a single one.
  along_faces,
  /// Along the surface: divides the tetrahedra that it crosses.
  through_tets,
};

/// Where a cut has come to, in scene vertices. What has changed since is forgotten.
struct CutFront {
  /// Around which tissue still hangs together: there the cut goes on, wherever they have moved.
  std::vector<Index> vertices{};
  /// Parted, but of three such vertices: they open as soon as one of these does.
  std::vector<Triangle> closed_faces{};
};

/// How a cut is made.
struct CutOptions {
  CutStyle style = CutStyle::through_tets;  ///< where tissue parts
  /// In [0.01, 0.4]: an edge that is crossed within this share of its length of a vertex parts at
  /// the vertex. Larger makes better tetrahedra and a rougher cut. Each part of a tetrahedron keeps
  /// at least the third power of it of the volume.
  float snap = 0.2F;
  /// Of the plan before, if that was applied and the same blade goes on.
  CutFront front{};
};

/// A cut as an edit, and how to go on.
struct CutPlan {
  TopologyEdit edit;  ///< empty if no tissue parts
  CutFront front;     ///< after that edit
};

/// Plans a cut through the tissue as it lies now: all bodies that the surface crosses.
///
/// A tetrahedron is cut whole or not at all: if the middle of its section lies on the surface, even
/// where the surface ends within. Its crossed edges get a vertex each and are bisected one after
/// the other, in the order of their vertices, in all tetrahedra around them. On a face:
///
///          d                d                d
///         /|               /|               /|
///        / |     a-d      / |     a-c      / |
///       /  |     -->     / .q     -->     / .q
///      /   |            /.' |            /.'/|
///     c----a           c----a           c--p-a
///
/// Both tetrahedra on a face bisect its edges in the same order, so they agree on its triangles,
/// whatever else is done to either: the mesh stays conforming, children have positive volume and
/// fill their parent, and neighbours that are not cut are divided without being parted. Then faces
/// between one side of the surface and the other part, and a vertex is split where the tetrahedra
/// around it no longer hang together by faces: the part with the smallest tetrahedron keeps it,
/// others get copies. Where the surface ends, vertices stay whole. Where a cut goes through,
/// cutting again changes nothing.
///
/// A blade that goes on gives each plan what it swept since the one before, and the front of that,
/// where the cut goes on although tissue has moved. Sweeping again what it swept before would cut
/// anew what has moved across it, and may loosen crumbs. Tissue is taken where it lies: what passes
/// the blade from one plan to the next, faster than that moves, is not cut. Where tissue moves and
/// the blade hardly does, add to the blade's way the tissue's, turned round: sweep from where the
/// blade would have been before, had it moved with the tissue near it, to where it is.
///
/// Links are not cut. Those at a vertex that is split go to the copy on that side of the surface
/// on which their middle lies.
///
/// The edit is for Tissue::apply() before anything else happens to the solver. Tetrahedra with a
/// vertex that is not finite are not cut.
///
/// Cost: some nanoseconds for each vertex and tetrahedron to find what is near, then vertices near
/// the surface times triangles.
/// @param copy  the one whose positions count
/// @return  an empty edit and the front given if there is no triangle: the blade rested
/// @throws InvalidArgument  naming the vertex of the front or the point that is not finite or does
///                          not exist, the triangle without area, the edge with more than two
///                          triangles or where they are wound differently or folded flat, or the
///                          option out of range
[[nodiscard]] PBDSURG_API CutPlan plan_cut(const Solver& solver, const CutSurface& surface,
                                           const CutOptions& options = {}, Index copy = 0);

}  // namespace pbdsurg
