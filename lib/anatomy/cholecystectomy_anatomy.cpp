// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"

#include <cmath>
#include <utility>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "anatomy/outer_surface.h"
#include "mesh/describe.h"

namespace pbdsurg {
namespace {

// Lattice cells, m. They resolve each organ's thinnest part, and give liver and gallbladder the
// sizes of the largest meshes of the paper.
constexpr double kWallCellsPerThickness = 0.88;
constexpr double kLiverSpacing = 6.8e-3;
constexpr double kDuctSpacing = 1.05e-3;
constexpr double kArterySpacing = 0.9e-3;
constexpr double kBileDuctSpacing = 1.8e-3;
constexpr double kFatSpacing = 1.9e-3;

constexpr int kBall = 1;  // Euler number of a solid organ
constexpr int kHollowBall = 2;

TetMesh fill(const ImplicitShape& shape, double spacing, int euler) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  options.euler = euler;
  return tetrahedralize(shape, options).mesh;
}

// A user's shape may have any topology.
TetMesh fill(const ImplicitShape& shape, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  return tetrahedralize(shape, options).mesh;
}

template <class BuiltIn>
TetMesh make_organ(const OrganSource& source, double spacing, BuiltIn built_in) {
  if (const auto* mesh = std::get_if<TetMesh>(&source)) {
    return *mesh;
  }
  if (const auto* shape = std::get_if<ImplicitShape>(&source)) {
    return fill(*shape, spacing);
  }
  return fill(built_in(), spacing, kBall);
}

ImplicitShape outer_gallbladder(const OrganSource& source) {
  if (const auto* mesh = std::get_if<TetMesh>(&source)) {
    return filled_shape(*mesh);
  }
  if (const auto* shape = std::get_if<ImplicitShape>(&source)) {
    return *shape;
  }
  return gallbladder_outer();
}

TetMesh make_gallbladder(const OrganSource& source, const ImplicitShape& outer,
                         double wall_thickness) {
  if (const auto* mesh = std::get_if<TetMesh>(&source)) {
    return *mesh;
  }
  const ImplicitShape wall = shell_shape(outer, wall_thickness);
  const double spacing = kWallCellsPerThickness * wall_thickness;
  return std::holds_alternative<ImplicitShape>(source) ? fill(wall, spacing)
                                                       : fill(wall, spacing, kHollowBall);
}

}  // namespace

CholecystectomyAnatomy make_cholecystectomy_anatomy(const CholecystectomyOptions& options) {
  const ImplicitShape outer = outer_gallbladder(options.gallbladder);
  CholecystectomyAnatomy anatomy;
  anatomy.gallbladder = make_gallbladder(options.gallbladder, outer, options.wall_thickness);
  anatomy.liver = make_organ(options.liver, kLiverSpacing, [&] { return liver_bed(outer); });
  anatomy.cystic_duct = make_organ(options.cystic_duct, kDuctSpacing, cystic_duct);
  anatomy.cystic_artery = make_organ(options.cystic_artery, kArterySpacing, cystic_artery);
  anatomy.common_bile_duct =
      make_organ(options.common_bile_duct, kBileDuctSpacing, common_bile_duct);
  anatomy.calot_fat = make_organ(options.calot_fat, kFatSpacing, [&] { return calot_fat(outer); });
  anatomy.abdominal_wall = abdominal_wall();
  return anatomy;
}

ImplicitShape filled_shape(const TetMesh& mesh) {
  const MeshData surface = outer_surface(mesh.positions(), mesh.tets());
  return surface_shape(surface.points, surface.triangles);
}

}  // namespace pbdsurg
