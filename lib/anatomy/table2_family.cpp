// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/table2_family.h"

#include <cmath>
#include <string>
#include <utility>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "anatomy/outer_surface.h"
#include "anatomy/tetgen_program.h"

namespace pbdsurg {
namespace {

// A wall of 1 / 0.88 cells is as thin as the lattice resolves without holes. Then nearly all
// vertices are on the boundary, as in the paper's meshes, and the counts of links and tetrahedra
// follow.
constexpr double kWallCellsPerThickness = 0.88;

// m; where the search for the row's vertex count ends, so that it is over at once.
constexpr std::array<double, 5> kHollowSpacing{3.088e-3, 2.382e-3, 1.934e-3, 1.799e-3, 1.399e-3};

ImplicitShape wall_at(double spacing) {
  return gallbladder_wall(spacing / kWallCellsPerThickness);
}

TetMesh hollow_mesh(std::size_t row) {
  TetrahedralizeOptions options;
  options.spacing = kHollowSpacing[row];
  options.vertex_count = kTable2[row].vertices;
  options.euler = 2;
  return tetrahedralize(ShapeAtSpacing(wall_at), options).mesh;
}

// The outside of a meshed wall has vertices that lie on no common sphere, which keeps the Delaunay
// tetrahedra between them as irregular as those of scanned organs.
MeshData surface_with(Index vertex_count) {
  constexpr double kSurfaceArea = 8.5e-3;  // m^2
  constexpr double kTolerance = 0.004;     // tetgen may add a vertex or two
  double spacing = std::sqrt(2.05 * kSurfaceArea / vertex_count);
  MeshData best;
  for (int step = 0; step < 8; ++step) {
    TetrahedralizeOptions options;
    options.spacing = spacing;
    options.euler = 2;
    const TetMesh wall = tetrahedralize(wall_at(spacing), options).mesh;
    MeshData surface = outer_surface(wall.positions(), wall.tets());
    const auto error = [vertex_count](const MeshData& data) {
      return std::abs(static_cast<double>(data.points.size()) / vertex_count - 1);
    };
    spacing *= std::sqrt(static_cast<double>(surface.points.size()) / vertex_count);
    if (best.points.empty() || error(surface) < error(best)) {
      best = std::move(surface);
    }
    if (error(best) <= kTolerance) {
      break;
    }
  }
  return best;
}

TetMesh surface_filled_mesh(std::size_t row) {
  MeshData filled = fill_with_tetgen(surface_with(kTable2[row].vertices));
  orient_tets(filled.points, filled.tets);
  return TetMesh(std::move(filled.points), std::move(filled.tets));
}

}  // namespace

TetMesh table2_mesh(int row, Table2Kind kind) {
  if (row < 1 || row > static_cast<int>(kTable2.size())) {
    throw InvalidArgument("table 2 has the rows 1 to 5, not " + std::to_string(row));
  }
  const auto index = static_cast<std::size_t>(row - 1);
  return kind == Table2Kind::hollow ? hollow_mesh(index) : surface_filled_mesh(index);
}

}  // namespace pbdsurg
