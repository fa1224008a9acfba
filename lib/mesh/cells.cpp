// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/cells.h"

#include <utility>

namespace pbdsurg {

CellType vtk_cell_type(std::int64_t number) {
  // numbers as in vtkCellType.h
  switch (number) {
    case 0:
      return {CellShape::ignored, 0, "empty cell"};
    case 1:
    case 2:
      return {CellShape::ignored, 0, "point"};
    case 3:
    case 4:
    case 21:
    case 35:
    case 68:
    case 75:
      return {CellShape::ignored, 0, "line"};
    case 5:
      return {CellShape::triangle, 3, "triangle"};
    case 6:
      return {CellShape::strip, 0, "triangle strip"};
    case 7:
      return {CellShape::polygon, 0, "polygon"};
    case 8:
      return {CellShape::pixel, 4, "pixel"};
    case 9:
      return {CellShape::quad, 4, "quadrilateral"};
    case 10:
      return {CellShape::tet, 4, "tetrahedron"};
    case 22:
    case 23:
    case 28:
    case 30:
    case 34:
    case 36:
    case 69:
    case 70:
    case 76:
    case 77:
      return {CellShape::ignored, 0, "surface cell of higher order"};
    case 11:
      return {CellShape::refused, 8, "voxel"};
    case 12:
      return {CellShape::refused, 8, "hexahedron"};
    case 13:
      return {CellShape::refused, 6, "wedge"};
    case 14:
      return {CellShape::refused, 5, "pyramid"};
    case 15:
    case 16:
      return {CellShape::refused, 0, "prism"};
    case 24:
    case 71:
    case 78:
      return {CellShape::refused, 10, "tetrahedron of higher order"};
    case 25:
    case 29:
    case 33:
    case 72:
    case 79:
      return {CellShape::refused, 0, "hexahedron of higher order"};
    case 26:
    case 31:
    case 32:
    case 73:
    case 80:
      return {CellShape::refused, 0, "wedge of higher order"};
    case 27:
    case 37:
    case 74:
    case 81:
      return {CellShape::refused, 0, "pyramid of higher order"};
    case 41:
    case 42:
      return {CellShape::refused, 0, "polyhedron"};
    default:
      return {};
  }
}

CellType gmsh_element_type(std::int64_t number) {
  // numbers and node counts as in the "MSH file format" section of the Gmsh manual
  switch (number) {
    case 1:
      return {CellShape::ignored, 2, "line"};
    case 2:
      return {CellShape::triangle, 3, "triangle"};
    case 3:
      return {CellShape::quad, 4, "quadrangle"};
    case 4:
      return {CellShape::tet, 4, "tetrahedron"};
    case 5:
      return {CellShape::refused, 8, "hexahedron"};
    case 6:
      return {CellShape::refused, 6, "prism"};
    case 7:
      return {CellShape::refused, 5, "pyramid"};
    case 8:
      return {CellShape::ignored, 3, "second-order line"};
    case 9:
      return {CellShape::ignored, 6, "second-order triangle"};
    case 10:
      return {CellShape::ignored, 9, "second-order quadrangle"};
    case 11:
      return {CellShape::refused, 10, "second-order tetrahedron"};
    case 12:
    case 17:
      return {CellShape::refused, 0, "second-order hexahedron"};
    case 13:
    case 18:
      return {CellShape::refused, 0, "second-order prism"};
    case 14:
    case 19:
      return {CellShape::refused, 0, "second-order pyramid"};
    case 15:
      return {CellShape::ignored, 1, "point"};
    case 16:
      return {CellShape::ignored, 8, "second-order quadrangle"};
    case 20:
      return {CellShape::ignored, 9, "third-order triangle"};
    case 21:
      return {CellShape::ignored, 10, "third-order triangle"};
    case 22:
      return {CellShape::ignored, 12, "fourth-order triangle"};
    case 23:
      return {CellShape::ignored, 15, "fourth-order triangle"};
    case 24:
      return {CellShape::ignored, 15, "fifth-order triangle"};
    case 25:
      return {CellShape::ignored, 21, "fifth-order triangle"};
    case 26:
      return {CellShape::ignored, 4, "third-order edge"};
    case 27:
      return {CellShape::ignored, 5, "fourth-order edge"};
    case 28:
      return {CellShape::ignored, 6, "fifth-order edge"};
    case 29:
    case 30:
    case 31:
      return {CellShape::refused, 0, "tetrahedron of higher order"};
    case 92:
    case 93:
      return {CellShape::refused, 0, "hexahedron of higher order"};
    default:
      return {};
  }
}

std::string cell_problem(const CellType& type, std::int64_t number, std::int64_t cell) {
  if (type.shape == CellShape::refused) {
    return "cell " + std::to_string(cell) + " is a " + type.name + " (type " +
           std::to_string(number) + "); volume cells must be four-node tetrahedra";
  }
  if (type.shape == CellShape::unknown) {
    return "cell " + std::to_string(cell) + " has the unknown type " + std::to_string(number);
  }
  return {};
}

std::string corner_problem(CellShape shape, std::size_t node_count, std::int64_t cell) {
  std::size_t wanted = 4;
  if (shape == CellShape::polygon || shape == CellShape::strip) {
    if (node_count >= 3) {
      return {};
    }
    return "cell " + std::to_string(cell) + " has " + std::to_string(node_count) +
           " corners; it needs 3 at least";
  }
  if (shape == CellShape::triangle) {
    wanted = 3;
  }
  if (node_count == wanted) {
    return {};
  }
  return "cell " + std::to_string(cell) + " has " + std::to_string(node_count) +
         " corners; its type has " + std::to_string(wanted);
}

std::string id_problem(std::int64_t id, std::int64_t first, std::size_t count) {
  return "refers to point " + std::to_string(id) + "; ids must be in [" + std::to_string(first) +
         ", " + std::to_string(first + static_cast<std::int64_t>(count)) + ")";
}

void append_cell(MeshData& mesh, CellShape shape, std::span<const Index> ids) {
  switch (shape) {
    case CellShape::tet:
      mesh.tets.push_back({ids[0], ids[1], ids[2], ids[3]});
      break;
    case CellShape::pixel:
      mesh.triangles.push_back({ids[0], ids[1], ids[3]});
      mesh.triangles.push_back({ids[0], ids[3], ids[2]});
      break;
    case CellShape::strip:
      for (std::size_t i = 0; i + 2 < ids.size(); ++i) {
        Triangle triangle{ids[i], ids[i + 1], ids[i + 2]};
        if (i % 2 == 1) {
          std::swap(triangle[0], triangle[1]);
        }
        mesh.triangles.push_back(triangle);
      }
      break;
    case CellShape::triangle:
    case CellShape::quad:
    case CellShape::polygon:
      for (std::size_t i = 1; i + 1 < ids.size(); ++i) {
        mesh.triangles.push_back({ids[0], ids[i], ids[i + 1]});
      }
      break;
    case CellShape::ignored:
    case CellShape::refused:
    case CellShape::unknown:
      break;
  }
}

}  // namespace pbdsurg
