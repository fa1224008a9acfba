// SPDX-License-Identifier: Apache-2.0
// Legacy VTK files up to 5.1: "VTK file formats", legacy section. Attributes are not read: the
// geometry ends where CELL_DATA or POINT_DATA begins.
#include <algorithm>
#include <cctype>
#include <charconv>
#include <optional>

#include "lib/mesh/byte_reader.h"
#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

constexpr int kVtkLine = 3, kVtkStrip = 6, kVtkPolygon = 7;

std::string upper(std::string_view text) {
  std::string result(text);
  for (char& c : result) {
    c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  return result;
}

/// Number types of legacy files; none for "bit" and "string".
std::optional<ScalarType> vtk_scalar_type(std::string name) {
  name = upper(name);
  if (name == "CHAR" || name == "SIGNED_CHAR" || name == "VTKTYPEINT8") {
    return ScalarType::int8;
  }
  if (name == "UNSIGNED_CHAR" || name == "VTKTYPEUINT8") {
    return ScalarType::uint8;
  }
  if (name == "SHORT" || name == "VTKTYPEINT16") {
    return ScalarType::int16;
  }
  if (name == "UNSIGNED_SHORT" || name == "VTKTYPEUINT16") {
    return ScalarType::uint16;
  }
  if (name == "INT" || name == "VTKIDTYPE" || name == "VTKTYPEINT32") {
    return ScalarType::int32;
  }
  if (name == "UNSIGNED_INT" || name == "VTKTYPEUINT32") {
    return ScalarType::uint32;
  }
  if (name == "LONG" || name == "VTKTYPEINT64") {
    return ScalarType::int64;
  }
  if (name == "UNSIGNED_LONG" || name == "VTKTYPEUINT64") {
    return ScalarType::uint64;
  }
  if (name == "FLOAT") {
    return ScalarType::float32;
  }
  if (name == "DOUBLE") {
    return ScalarType::float64;
  }
  return std::nullopt;
}

class VtkFile {
 public:
  explicit VtkFile(const Source& source) : source_(source), text_(source) {}

  ParsedMesh parse() {
    read_header();
    while (!text_.at_end()) {
      const std::string keyword = upper(text_.word("a keyword"));
      if (keyword == "CELL_DATA" || keyword == "POINT_DATA") {
        break;
      }
      read_section(keyword);
    }
    if (!points_read_) {
      text_.fail("the file has no POINTS");
    }
    return {assemble(), "legacy VTK " + version_ + (binary_ ? ", binary" : ", ASCII")};
  }

 private:
  void read_header() {
    const std::string_view first = text_.rest_of_line();
    constexpr std::string_view kMagic = "# vtk DataFile Version";
    if (!first.starts_with(kMagic)) {
      text_.fail("the first line must begin with '# vtk DataFile Version'");
    }
    const std::size_t begin = first.find_first_not_of(' ', kMagic.size());
    version_ = begin == first.npos ? "" : TextReader::printable(first.substr(begin));
    int major = 0;
    std::from_chars(version_.data(), version_.data() + version_.size(), major);
    if (major < 1 || major > 5) {
      text_.fail("version '" + version_ + "' is not supported; up to 5.1 is");
    }
    split_arrays_ = major == 5;
    text_.rest_of_line();  // the title
    const std::string encoding = upper(text_.word("ASCII or BINARY"));
    if (encoding != "ASCII" && encoding != "BINARY") {
      text_.fail("'" + TextReader::printable(encoding) +
                 "' stands where ASCII or BINARY should be");
    }
    binary_ = encoding == "BINARY";
    if (upper(text_.word("DATASET")) != "DATASET") {
      text_.fail("the keyword DATASET should be here");
    }
    const std::string kind = upper(text_.word("a kind of data set"));
    if (kind != "UNSTRUCTURED_GRID" && kind != "POLYDATA") {
      text_.fail("a data set of kind " + TextReader::printable(kind) +
                 " is no mesh; UNSTRUCTURED_GRID and POLYDATA are read");
    }
    polydata_ = kind == "POLYDATA";
  }

  void read_section(const std::string& keyword) {
    if (keyword == "POINTS") {
      read_points();
    } else if (keyword == "CELLS" && !polydata_) {
      cells_offset_ = text_.offset();
      cells_ = read_cells("cells");
    } else if (keyword == "CELL_TYPES" && !polydata_) {
      const std::size_t count = text_.count("cell types", binary_ ? 0 : 1);
      types_ = read_integers(ScalarType::int32, static_cast<std::int64_t>(count), "cell types");
    } else if (polydata_ && (keyword == "POLYGONS" || keyword == "TRIANGLE_STRIPS" ||
                             keyword == "LINES" || keyword == "VERTICES")) {
      const std::size_t at = text_.offset();
      const CellArray cells = read_cells(keyword.c_str());
      const int type = keyword == "POLYGONS"          ? kVtkPolygon
                       : keyword == "TRIANGLE_STRIPS" ? kVtkStrip
                                                      : kVtkLine;
      polys_.push_back({cells, type, at});
    } else if (keyword == "METADATA") {
      // runs to the first empty line
      text_.rest_of_line();
      while (text_.offset() < source_.bytes.size() && !text_.rest_of_line().empty()) {
      }
    } else if (keyword == "FIELD") {
      skip_field();
    } else {
      text_.fail("unknown keyword '" + TextReader::printable(keyword) + "'");
    }
  }

  void read_points() {
    if (points_read_) {
      text_.fail("POINTS comes twice");
    }
    points_read_ = true;
    std::size_t count = text_.count("points", binary_ ? 0 : 3);
    const ScalarType type = read_type();
    if (binary_) {
      ByteReader bytes = binary_reader();
      count = bytes.checked_count(static_cast<std::int64_t>(count), "points", 3 * size_of(type));
      mesh_.points.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        mesh_.points.push_back(bytes.point(type));
      }
      text_.seek(bytes.offset());
    } else {
      mesh_.points.reserve(count);
      for (std::size_t i = 0; i < count; ++i) {
        mesh_.points.push_back(text_.point());
      }
    }
  }

  /// CELLS and its sisters: one array with the sizes in line, or since 5.0 two arrays.
  CellArray read_cells(const char* what) {
    const auto first = text_.number<std::int64_t>("a cell count");
    const auto second = text_.number<std::int64_t>("the size of the cell array");
    CellArray cells;
    if (split_arrays_) {
      cells.offsets = read_named_array("OFFSETS", first);
      cells.connectivity = read_named_array("CONNECTIVITY", second);
      return cells;
    }
    const std::vector<std::int64_t> flat = read_integers(ScalarType::int32, second, what);
    cells.offsets.push_back(0);
    cells.connectivity.reserve(flat.size());
    std::size_t at = 0;
    while (at < flat.size()) {
      const std::int64_t size = flat[at++];
      if (size < 0 || static_cast<std::size_t>(size) > flat.size() - at) {
        text_.fail("cell " + std::to_string(cells.offsets.size() - 1) + " has " +
                   std::to_string(size) + " corners, but " + std::to_string(flat.size() - at) +
                   " entries are left in its array");
      }
      const auto begin = flat.begin() + static_cast<std::ptrdiff_t>(at);
      cells.connectivity.insert(cells.connectivity.end(), begin, begin + size);
      cells.offsets.push_back(static_cast<std::int64_t>(cells.connectivity.size()));
      at += static_cast<std::size_t>(size);
    }
    if (static_cast<std::int64_t>(cells.offsets.size()) - 1 != first) {
      text_.fail(std::to_string(first) + " " + what + " are announced, but their array holds " +
                 std::to_string(cells.offsets.size() - 1));
    }
    return cells;
  }

  std::vector<std::int64_t> read_named_array(const char* name, std::int64_t count) {
    if (upper(text_.word(name)) != name) {
      text_.fail("the keyword " + std::string(name) + " should be here");
    }
    const ScalarType type = read_type();
    if (!is_integer(type)) {
      text_.fail(std::string(name) + " must be integers");
    }
    return read_integers(type, count, name);
  }

  std::vector<std::int64_t> read_integers(ScalarType type, std::int64_t count, const char* what) {
    std::vector<std::int64_t> values;
    if (binary_) {
      ByteReader bytes = binary_reader();
      values.resize(bytes.checked_count(count, what, size_of(type)));
      for (std::int64_t& value : values) {
        value = bytes.number<std::int64_t>(type, what);
      }
      text_.seek(bytes.offset());
    } else {
      values.resize(text_.checked_count(count, what, 1));
      for (std::int64_t& value : values) {
        value = text_.number<std::int64_t>(what);
      }
    }
    return values;
  }

  /// FIELD name count, then count arrays: name components tuples type, values.
  void skip_field() {
    text_.word("a field name");
    const std::size_t arrays = text_.count("field arrays", 4);
    for (std::size_t a = 0; a < arrays; ++a) {
      if (upper(text_.peek()) == "METADATA") {
        text_.word("METADATA");
        read_section("METADATA");
      }
      text_.word("an array name");
      const std::size_t components = text_.count("components", 0);
      const std::size_t tuples = text_.count("tuples", 0);
      const ScalarType type = read_type();
      const auto count = static_cast<std::int64_t>(components * tuples);
      if (binary_) {
        ByteReader bytes = binary_reader();
        const std::size_t values = bytes.checked_count(count, "field values", size_of(type));
        bytes.take(values * size_of(type), "a field");
        text_.seek(bytes.offset());
      } else {
        const std::size_t values = text_.checked_count(count, "field values", 1);
        for (std::size_t i = 0; i < values; ++i) {
          text_.word("a field value");
        }
      }
    }
  }

  ScalarType read_type() {
    const std::string name(text_.word("a number type"));
    const std::optional<ScalarType> type = vtk_scalar_type(name);
    if (!type) {
      text_.fail("'" + TextReader::printable(name) + "' is no supported type of numbers");
    }
    return *type;
  }

  /// Binary data start behind the end of the current line and are big-endian.
  ByteReader binary_reader() {
    text_.rest_of_line();
    return ByteReader(source_, text_.offset(), std::endian::big);
  }

  MeshData assemble() {
    if (polydata_) {
      for (const Polys& polys : polys_) {
        append_vtk_cells(
            mesh_, polys.cells, [&](std::size_t) { return polys.type; }, 0, mesh_.points.size(),
            [&](const std::string& reason) { source_.fail_at_line(polys.offset, reason); });
      }
      return std::move(mesh_);
    }
    const std::size_t cell_count = cells_.offsets.empty() ? 0 : cells_.offsets.size() - 1;
    if (types_.size() != cell_count) {
      text_.fail("there are " + std::to_string(cell_count) + " cells, but " +
                 std::to_string(types_.size()) + " cell types");
    }
    append_vtk_cells(
        mesh_, cells_, [&](std::size_t c) { return types_[c]; }, 0, mesh_.points.size(),
        [&](const std::string& reason) { source_.fail_at_line(cells_offset_, reason); });
    return std::move(mesh_);
  }

  struct Polys {
    CellArray cells;
    int type;
    std::size_t offset;  // where the section begins
  };

  const Source& source_;
  TextReader text_;
  std::string version_;
  bool split_arrays_ = false;
  bool binary_ = false;
  bool polydata_ = false;
  bool points_read_ = false;
  CellArray cells_;
  std::size_t cells_offset_ = 0;
  std::vector<std::int64_t> types_;
  std::vector<Polys> polys_;
  MeshData mesh_;
};

}  // namespace

ParsedMesh parse_vtk(const Source& source) {
  return VtkFile(source).parse();
}

}  // namespace pbdsurg
