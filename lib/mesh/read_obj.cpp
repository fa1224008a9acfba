// SPDX-License-Identifier: Apache-2.0
// Wavefront OBJ: vertices and faces; everything else is skipped.
#include <charconv>
#include <vector>

#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

/// The vertex of a corner "v", "v/vt", "v//vn" or "v/vt/vn": counted from 1, or backwards from -1.
Index corner_vertex(TextReader& text, std::size_t point_count) {
  const std::string_view word = text.word("a corner");
  const std::string_view number = word.substr(0, word.find('/'));
  std::int64_t id = 0;
  const auto [end, error] = std::from_chars(number.data(), number.data() + number.size(), id);
  if (error != std::errc() || end != number.data() + number.size()) {
    text.fail("'" + TextReader::printable(word) + "' is no corner of a face");
  }
  const auto count = static_cast<std::int64_t>(point_count);
  if (id == 0 || id > count || id < -count) {
    text.fail("the face " + id_problem(id, 1, point_count) + ", or negative to count backwards");
  }
  return static_cast<Index>(id > 0 ? id - 1 : count + id);
}

}  // namespace

ParsedMesh parse_obj(const Source& source) {
  MeshData mesh;
  TextReader text(source, '#');
  std::vector<Index> corners;
  while (!text.at_end()) {
    const std::string_view keyword = text.word("a keyword");
    if (keyword == "v") {
      mesh.points.push_back(text.point());  // a weight or a colour may follow
    } else if (keyword == "f") {
      corners.clear();
      while (!text.at_line_end()) {
        if (text.peek() == "\\") {  // the line goes on below
          text.rest_of_line();
          continue;
        }
        corners.push_back(corner_vertex(text, mesh.points.size()));
      }
      const std::string problem = corner_problem(CellShape::polygon, corners.size(),
                                                 static_cast<std::int64_t>(mesh.triangles.size()));
      if (!problem.empty()) {
        text.fail(problem);
      }
      append_cell(mesh, CellShape::polygon, corners);
    }
    text.rest_of_line();
  }
  if (mesh.points.empty()) {
    text.fail("the file has no vertices ('v')");
  }
  return {std::move(mesh), "Wavefront OBJ"};
}

}  // namespace pbdsurg
