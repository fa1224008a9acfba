// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How cells of files become tetrahedra and triangles.

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// What we make of a cell.
enum class CellShape {
  tet,
  triangle,
  quad,     ///< split into two triangles
  pixel,    ///< a quad with its last two corners swapped
  polygon,  ///< split into a fan of triangles
  strip,    ///< triangles of which every other one is flipped
  ignored,  ///< points, lines and surface cells of higher order
  refused,  ///< volume cells other than four-node tetrahedra
  unknown
};

/// A cell type of some file format.
struct CellType {
  CellShape shape = CellShape::unknown;
  int node_count = 0;  ///< 0 where it varies or does not matter
  const char* name = "";
};

/// Cell types of VTK files.
[[nodiscard]] CellType vtk_cell_type(std::int64_t number);

/// Element types of Gmsh files.
[[nodiscard]] CellType gmsh_element_type(std::int64_t number);

/// "cell 7 is a hexahedron ...": why a refused or unknown cell stops the reading.
[[nodiscard]] std::string cell_problem(const CellType& type, std::int64_t number,
                                       std::int64_t cell);

/// Why a cell of `shape` cannot have `node_count` corners; empty when it can.
[[nodiscard]] std::string corner_problem(CellShape shape, std::size_t node_count,
                                         std::int64_t cell);

/// "refers to point 9; ...": an id outside of the points of a file.
[[nodiscard]] std::string id_problem(std::int64_t id, std::int64_t first, std::size_t count);

/// Adds the tetrahedra or triangles of one cell whose corners are checked.
void append_cell(MeshData& mesh, CellShape shape, std::span<const Index> ids);

/// Cells in two flat arrays as VTK stores them.
struct CellArray {
  std::vector<std::int64_t> offsets;       ///< [cell_count + 1]
  std::vector<std::int64_t> connectivity;  ///< [offsets.back()]
};

/// Adds the cells of a VTK file, whose shapes `type_of(cell)` tells as numbers of VTK.
///
/// @param first_point  what is added to each id
/// @param point_count  ids must be below
/// @param fail         called with a reason when a cell is refused; must not return
template <class TypeOf, class Fail>
void append_vtk_cells(MeshData& mesh, const CellArray& cells, TypeOf&& type_of,
                      std::size_t first_point, std::size_t point_count, Fail&& fail) {
  std::vector<Index> ids;
  for (std::size_t c = 0; c + 1 < cells.offsets.size(); ++c) {
    const std::int64_t begin = cells.offsets[c];
    const std::int64_t end = cells.offsets[c + 1];
    if (begin < 0 || end < begin || end > static_cast<std::int64_t>(cells.connectivity.size())) {
      fail("cell " + std::to_string(c) + " takes entries " + std::to_string(begin) + " to " +
           std::to_string(end) + " of a connectivity of " +
           std::to_string(cells.connectivity.size()));
    }
    const std::int64_t number = type_of(c);
    const CellType type = vtk_cell_type(number);
    if (type.shape == CellShape::ignored) {
      continue;
    }
    std::string problem = cell_problem(type, number, static_cast<std::int64_t>(c));
    if (problem.empty()) {
      problem = corner_problem(type.shape, static_cast<std::size_t>(end - begin),
                               static_cast<std::int64_t>(c));
    }
    if (!problem.empty()) {
      fail(problem);
    }
    ids.clear();
    for (std::int64_t i = begin; i < end; ++i) {
      const std::int64_t id = cells.connectivity[static_cast<std::size_t>(i)];
      if (id < 0 || id >= static_cast<std::int64_t>(point_count)) {
        fail("cell " + std::to_string(c) + " " + id_problem(id, 0, point_count));
      }
      ids.push_back(static_cast<Index>(id + static_cast<std::int64_t>(first_point)));
    }
    append_cell(mesh, type.shape, ids);
  }
}

}  // namespace pbdsurg
