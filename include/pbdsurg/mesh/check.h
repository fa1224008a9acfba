// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The mesh doctor: everything that is wrong or remarkable about a mesh, in one report.

#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// How bad a finding is.
enum class Severity : std::uint8_t {
  note,     ///< worth knowing
  warning,  ///< can be simulated or filled, but is seldom meant
  error     ///< cannot be simulated, or fills space twice
};

/// "note", "warning" or "error".
[[nodiscard]] PBDSURG_API const char* name_of(Severity severity);

/// One thing found, as a sentence that names the first few elements.
struct Finding {
  Severity severity;  ///< how bad it is
  std::string text;   ///< the sentence
};

/// Counts and measures of a mesh. Vertices are the points that some tetrahedron uses, or some
/// triangle if the mesh is a surface (has no tetrahedra). Lengths are in metres if the points are.
struct PBDSURG_API MeshReport {
  /// @name Counts
  /// @{
  Index vertices = 0;            ///< points in use
  Index unreferenced = 0;        ///< points not in use
  Index edges = 0;               ///< of tetrahedra, or of triangles for a surface
  Index faces = 0;               ///< triangles of tetrahedra, shared ones once
  Index tets = 0;                ///< tetrahedra
  Index triangles = 0;           ///< as stored beside the tetrahedra
  Index boundary_triangles = 0;  ///< triangles of one tetrahedron, or all triangles of a surface
  Index boundary_vertices = 0;   ///< corners of boundary triangles
  Index components = 0;          ///< parts joined through shared vertices
  Index shells = 0;              ///< closed pieces of boundary, joined through shared edges
  Index euler = 0;               ///< vertices - edges + faces - tets

  /// @}
  /// @name Measures
  /// Zero where there is nothing to measure.
  /// @{
  double volume = 0;            ///< m^3: of the tetrahedra once all are oriented alike, or enclosed
                                ///< by a closed surface
  double area = 0;              ///< m^2, of the boundary
  double shortest_edge = 0;     ///< m
  double longest_edge = 0;      ///< m
  double min_dihedral = 0;      ///< rad
  double max_dihedral = 0;      ///< rad
  double min_radius_ratio = 0;  ///< of the worst tetrahedron: radius_ratio()
  double mean_radius_ratio = 0;  ///< over all tetrahedra
  Index max_vertex_tets = 0;     ///< most tetrahedra at one vertex

  /// @}
  /// @name Defects
  /// @{
  bool turned = false;            ///< most tetrahedra have negative volume: all are judged turned
  Index inverted = 0;             ///< of negative volume after that
  Index flat = 0;                 ///< of zero volume, see is_flat(); also a vertex used twice
  Index duplicate_points = 0;     ///< in use, at exactly the place of an earlier one
  Index near_points = 0;          ///< in use, close to an earlier one: kNearPoints box diagonals
  Index duplicate_tets = 0;       ///< with the vertices of an earlier one
  Index duplicate_triangles = 0;  ///< same, for the triangles as stored
  Index flat_triangles = 0;       ///< of a surface: without area
  Index overfull_faces = 0;       ///< triangles of three or more tetrahedra
  Index open_edges = 0;           ///< boundary edges of one triangle
  Index overshared_edges = 0;     ///< boundary edges of three or more triangles
  Index pinched_vertices = 0;     ///< vertices where the boundary touches itself
  Index badly_wound_edges = 0;    ///< of a surface: edges that both triangles run in one direction
  Index self_crossings = 0;       ///< pairs of boundary triangles that meet where they should not
  Index welded_open_edges = 0;    ///< open_edges if duplicate and near points were welded
  Index welded_components = 0;    ///< components if they were
  bool closed = false;            ///< no boundary edge is open or over-shared
  bool inside_out = false;        ///< a closed, consistently wound surface with normals inwards
  /// @}

  std::vector<Finding> findings;         ///< errors first, then warnings, then notes
  std::vector<std::string> checked;      ///< what was looked at, in words
  std::vector<std::string> not_checked;  ///< what was not

  /// Whether any finding is an error.
  [[nodiscard]] bool has_errors() const;
};

/// Points nearer than this part of the diagonal of their bounding box count as near_points.
inline constexpr double kNearPoints = 1e-6;

/// Examines a mesh. Content never makes it throw: ids out of range and coordinates that are not
/// finite are findings, too, and end the examination there.
///
/// Self-crossings are pairs of boundary triangles with a point in common beyond their common
/// corners and edge: they cross, fold onto each other, overlap in one plane or touch. Points at one
/// place count as one corner. Touching is decided with a bound on the rounding of coordinates, so
/// that no crossing is missed and the count is the same in every unit.
/// Cost: O((V + T) log(V + T)). The search for self-crossings takes one to three times as long as
/// all else (0.2 s for a sphere of 82 000 triangles). It ends early, and not_checked says so, after
/// a million of them, and where hundreds of triangles overlap the bounding box of each.
[[nodiscard]] PBDSURG_API MeshReport check_mesh(const MeshData& mesh);

}  // namespace pbdsurg
