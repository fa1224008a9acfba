// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Rest meshes of tetrahedra with checked invariants.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// An immutable tetrahedral mesh at rest.
///
/// Guaranteed by the constructor and true ever after:
///  - every position is finite;
///  - every id in tets() is in [0, vertex_count());
///  - the four ids of a tetrahedron differ, and its rest volume is positive beyond rounding;
///  - no two tetrahedra have the same four vertices.
///
/// Vertices that no tetrahedron uses are allowed and keep their ids. Rest data are double, so that
/// slivers far from the origin stay positive; the solver's state is float. Any number of threads
/// may read one mesh at once.
class PBDSURG_API TetMesh {
 public:
  /// An empty mesh.
  TetMesh() = default;

  /// Takes over the arrays and checks the guarantees above.
  ///
  /// @param positions  [vertex_count] m
  /// @param tets       [tet_count] vertex ids
  /// @throws InvalidMesh  naming the first offending element, its value and the rule
  /// Inverted tetrahedra are refused, not repaired: see orient_tets(). Cost: O(tet_count) expected.
  TetMesh(std::vector<Eigen::Vector3d> positions, std::vector<Tet> tets);

  /// Vertices, those that no tetrahedron uses included.
  [[nodiscard]] Index vertex_count() const noexcept {
    return static_cast<Index>(positions_.size());
  }
  /// Tetrahedra.
  [[nodiscard]] Index tet_count() const noexcept { return static_cast<Index>(tets_.size()); }

  /// [vertex_count] m. Spans stay valid until the mesh is assigned to, moved from or destroyed.
  [[nodiscard]] std::span<const Eigen::Vector3d> positions() const noexcept { return positions_; }

  /// [tet_count] vertex ids, in the order given to the constructor.
  [[nodiscard]] std::span<const Tet> tets() const noexcept { return tets_; }

 private:
  std::vector<Eigen::Vector3d> positions_;
  std::vector<Tet> tets_;
};

// This and the next serve inner loops: they do not check the tetrahedron's ids.

/// Signed volume of one tetrahedron, m^3.
[[nodiscard]] PBDSURG_API double tet_volume(std::span<const Eigen::Vector3d> positions,
                                            const Tet& tet);

/// Whether the volume of a tetrahedron is zero to rounding, judged against its longest edge: no
/// absolute tolerance, so the answer is the same in metres and in millimetres.
[[nodiscard]] PBDSURG_API bool is_flat(std::span<const Eigen::Vector3d> positions, const Tet& tet);

/// Swaps two ids in each tetrahedron of negative volume, so that all that are not flat become
/// positive.
/// @return  how many tetrahedra were swapped
/// @throws InvalidArgument  naming the vertex that has no position; then nothing has changed
PBDSURG_API Index orient_tets(std::span<const Eigen::Vector3d> positions, std::span<Tet> tets);

/// Sum of the signed volumes, m^3.
[[nodiscard]] PBDSURG_API double total_volume(const TetMesh& mesh);

/// The smallest box around all vertices, m; empty for a mesh without vertices.
[[nodiscard]] PBDSURG_API Eigen::AlignedBox3d bounding_box(const TetMesh& mesh);

/// Vertex masses: a quarter of each tetrahedron's mass to each of its corners.
///
/// @param density  kg/m^3, positive and finite
/// @return         [vertex_count] kg, zero where no tetrahedron touches the vertex
/// @throws InvalidArgument  if the density is not positive and finite
[[nodiscard]] PBDSURG_API std::vector<double> lumped_masses(const TetMesh& mesh, double density);

}  // namespace pbdsurg
