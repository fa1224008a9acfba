// SPDX-License-Identifier: Apache-2.0
// TetGen .node and .ele: "File formats" of the TetGen manual.
#include <array>

#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

/// Reads a row's own number, which must count up from the first row's.
void check_row(TextReader& text, std::int64_t first, std::size_t row, const char* what) {
  const auto id = text.number<std::int64_t>("the number of a " + std::string(what));
  const std::int64_t due = first + static_cast<std::int64_t>(row);
  if (id != due) {
    text.fail("the " + std::string(what) + " is numbered " + std::to_string(id) + "; " +
              std::to_string(due) + " is due");
  }
}

std::int64_t first_number(TextReader& text, const char* what) {
  const std::size_t begin = text.offset();
  const auto first = text.number<std::int64_t>("the number of a " + std::string(what));
  if (first != 0 && first != 1) {
    text.fail("the first " + std::string(what) + " is numbered " + std::to_string(first) +
              "; it must be 0 or 1");
  }
  text.seek(begin);
  return first;
}

void skip_row(TextReader& text) {
  while (!text.at_line_end()) {
    text.word("an attribute");
  }
}

}  // namespace

ParsedMesh parse_tetgen(const Source& node, const Source& element) {
  MeshData mesh;
  TextReader nodes(node, '#');
  const std::size_t point_count = nodes.count("points", 4);
  const auto dimension = nodes.number<int>("the dimension");
  if (dimension != 3) {
    nodes.fail("the dimension is " + std::to_string(dimension) + "; it must be 3");
  }
  skip_row(nodes);
  const std::int64_t first = point_count > 0 ? first_number(nodes, "point") : 0;
  mesh.points.reserve(point_count);
  for (std::size_t i = 0; i < point_count; ++i) {
    check_row(nodes, first, i, "point");
    mesh.points.push_back(nodes.point());
    skip_row(nodes);
  }

  TextReader elements(element, '#');
  const std::size_t tet_count = elements.count("tetrahedra", 5);
  const auto corners = elements.number<int>("the corners of a tetrahedron");
  if (corners != 4) {
    elements.fail("the tetrahedra have " + std::to_string(corners) +
                  " nodes; only four-node tetrahedra are supported");
  }
  skip_row(elements);
  const std::int64_t first_tet = tet_count > 0 ? first_number(elements, "tetrahedron") : 0;
  mesh.tets.reserve(tet_count);
  for (std::size_t t = 0; t < tet_count; ++t) {
    check_row(elements, first_tet, t, "tetrahedron");
    Tet tet;
    for (Index& corner : tet) {
      const auto id = elements.number<std::int64_t>("a point id");
      if (id < first || id >= first + static_cast<std::int64_t>(point_count)) {
        elements.fail("the tetrahedron " + id_problem(id, first, point_count));
      }
      corner = static_cast<Index>(id - first);
    }
    mesh.tets.push_back(tet);
    skip_row(elements);
  }
  return {std::move(mesh), "TetGen, numbered from " + std::to_string(first)};
}

}  // namespace pbdsurg
