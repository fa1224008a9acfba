// SPDX-License-Identifier: Apache-2.0
// Medit .mesh (ASCII): P. Frey, "MEDIT: an interactive mesh visualization software", 2001.
#include <array>
#include <cctype>

#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

class MeditFile {
 public:
  explicit MeditFile(const Source& source) : text_(source, '#') {}

  ParsedMesh parse() {
    if (text_.word("MeshVersionFormatted") != "MeshVersionFormatted") {
      text_.fail("the file must begin with MeshVersionFormatted (binary .meshb is not read)");
    }
    text_.number<int>("the version");
    while (!text_.at_end()) {
      const std::string_view keyword = text_.word("a keyword");
      if (keyword == "End") {
        break;
      }
      if (keyword == "Dimension") {
        const auto dimension = text_.number<int>("the dimension");
        if (dimension != 3) {
          text_.fail("the dimension is " + std::to_string(dimension) + "; it must be 3");
        }
      } else if (keyword == "Vertices") {
        read_vertices();
      } else if (keyword == "Tetrahedra") {
        read_cells<4>(CellShape::tet, "tetrahedra");
      } else if (keyword == "Triangles") {
        read_cells<3>(CellShape::triangle, "triangles");
      } else if (keyword == "Quadrilaterals") {
        read_cells<4>(CellShape::quad, "quadrilaterals");
      } else {
        skip_section(keyword);
      }
    }
    if (!vertices_read_) {
      text_.fail("the file has no section Vertices");
    }
    return {std::move(mesh_), "Medit, ASCII"};
  }

 private:
  void read_vertices() {
    if (vertices_read_) {
      text_.fail("the vertices come twice");
    }
    vertices_read_ = true;
    const std::size_t count = text_.count("vertices", 4);
    mesh_.points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      mesh_.points.push_back(text_.point());
      text_.word("a reference");
    }
  }

  template <std::size_t kCorners>
  void read_cells(CellShape shape, const char* what) {
    if (!vertices_read_) {
      text_.fail(std::string(what) + " come before the vertices");
    }
    const std::size_t count = text_.count(what, kCorners + 1);
    for (std::size_t c = 0; c < count; ++c) {
      std::array<Index, kCorners> ids;
      for (Index& corner : ids) {
        const auto id = text_.number<std::int64_t>("a vertex id");
        if (id < 1 || id > static_cast<std::int64_t>(mesh_.points.size())) {
          text_.fail("number " + std::to_string(c + 1) + " of the " + what + " " +
                     id_problem(id, 1, mesh_.points.size()));
        }
        corner = static_cast<Index>(id - 1);
      }
      text_.word("a reference");
      append_cell(mesh_, shape, ids);
    }
  }

  /// Any other section is numbers up to the next keyword.
  void skip_section(std::string_view keyword) {
    if (!is_keyword(keyword)) {
      text_.fail("'" + TextReader::printable(keyword) + "' stands where a keyword should be");
    }
    if (keyword.starts_with("Hexahedra") || keyword.starts_with("Prisms") ||
        keyword.starts_with("Wedges") || keyword.starts_with("Pyramids") ||
        keyword.starts_with("TetrahedraP")) {
      const std::string name(keyword);
      if (text_.count("volume cells", 0) > 0) {
        text_.fail("the file holds " + name + "; volume cells must be four-node tetrahedra");
      }
    }
    while (!text_.at_end() && !is_keyword(text_.peek())) {
      text_.word("a number");
    }
  }

  static bool is_keyword(std::string_view word) {
    return std::isalpha(static_cast<unsigned char>(word.front())) != 0;
  }

  TextReader text_;
  bool vertices_read_ = false;
  MeshData mesh_;
};

}  // namespace

ParsedMesh parse_medit(const Source& source) {
  return MeditFile(source).parse();
}

}  // namespace pbdsurg
