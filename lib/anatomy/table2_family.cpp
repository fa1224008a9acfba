// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/table2_family.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "lib/anatomy/tetgen_program.h"
#include "lib/anatomy/wall_cells.h"
#include "lib/mesh/outer_surface.h"

namespace pbdsurg {
namespace {

// m; where the search for the row's vertex count ends, so that it is over at once.
constexpr std::array<double, 5> kHollowSpacing{3.088e-3, 2.382e-3, 1.934e-3, 1.799e-3, 1.399e-3};

// The same for surface-filled meshes, whose vertices are those of the outer surface. Noise in parts
// of the spacing, chosen so that the number of tetrahedra a vertex is that of the paper's row.
constexpr std::array<double, 5> kFilledSpacing{2.088e-3, 1.604e-3, 1.280e-3, 1.177e-3, 0.9112e-3};
constexpr std::array<double, 5> kNoise{0.075, 0.070, 0.060, 0.060, 0.050};

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

// The gallbladder is a body of revolution nearly everywhere: rings of vertices lie on common
// spheres, and Delaunay tetrahedra connect them in all directions, twice as many as between the
// vertices of a scanned organ. Noise of a few hundredths of an edge, as scans have it, makes the
// counts alike.
void roughen(MeshData& surface, double noise) {
  for (std::size_t v = 0; v < surface.points.size(); ++v) {
    for (int axis = 0; axis < 3; ++axis) {
      const double unit = random_unit(0, v, static_cast<std::uint64_t>(axis));
      surface.points[v][axis] += noise * (unit - 0.5);
    }
  }
}

// The outside of a meshed wall with as many vertices as the row.
MeshData surface_of(std::size_t row) {
  constexpr double kTolerance = 0.004;  // tetgen may add a vertex or two
  const double wanted = kTable2[row].vertices;
  const auto error = [wanted](const MeshData& data) {
    return std::abs(static_cast<double>(data.points.size()) / wanted - 1);
  };
  MeshData best;
  double spacing = kFilledSpacing[row];
  for (int step = 0; step < 8; ++step) {
    TetrahedralizeOptions options;
    options.spacing = spacing;
    options.euler = 2;
    const TetMesh wall = tetrahedralize(wall_at(spacing), options).mesh;
    MeshData surface = outer_surface(wall.positions(), wall.tets());
    roughen(surface, kNoise[row] * spacing);
    spacing *= std::sqrt(static_cast<double>(surface.points.size()) / wanted);
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
  MeshData filled = fill_with_tetgen(surface_of(row));
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
