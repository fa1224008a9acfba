// SPDX-License-Identifier: Apache-2.0
// VTK XML unstructured grids: "VTK file formats", XML section. Point and cell data are not read.
#include <array>
#include <charconv>
#include <optional>

#include <zlib.h>

#include "lib/mesh/cells.h"
#include "lib/mesh/encoded_stream.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/scalar_type.h"
#include "lib/mesh/text_reader.h"
#include "lib/mesh/xml_reader.h"

namespace pbdsurg {
namespace {

/// A DataArray element: where its values are, not yet the values.
struct DataArray {
  std::string name;
  ScalarType type = ScalarType::float32;
  std::string format;
  std::optional<std::size_t> appended;  // offset into the appended data
  std::int64_t components = 1;
  std::size_t offset = 0;  // of the tag, for errors
  std::size_t text_begin = 0;
  std::size_t text_end = 0;
};

struct Piece {
  std::size_t point_count = 0;
  std::size_t cell_count = 0;
  std::size_t offset = 0;
  std::optional<DataArray> points, connectivity, offsets, types;
};

std::optional<ScalarType> xml_scalar_type(std::string_view name) {
  constexpr std::array<std::string_view, 10> kNames{"Int8",    "UInt8",  "Int16", "UInt16",
                                                    "Int32",   "UInt32", "Int64", "UInt64",
                                                    "Float32", "Float64"};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (kNames[i] == name) {
      return static_cast<ScalarType>(i);
    }
  }
  return std::nullopt;
}

class VtuFile {
 public:
  explicit VtuFile(const Source& source) : source_(source), xml_(source) {}

  ParsedMesh parse() {
    read_tags();
    if (!saw_grid_) {
      source_.fail_at_line(0, "the file has no <UnstructuredGrid>");
    }
    for (const Piece& piece : pieces_) {
      add_piece(piece);
    }
    return {std::move(mesh_), "VTK XML unstructured grid" + describe_encoding()};
  }

 private:
  void read_tags() {
    bool in_points = false;
    bool in_cells = false;
    while (true) {
      XmlTag tag = xml_.next();
      const bool opens = tag.kind == XmlTag::Kind::open;
      switch (tag.kind) {
        case XmlTag::Kind::end_of_file:
          if (!saw_end_) {
            source_.fail_at_line(tag.offset, "the file ends before </VTKFile>");
          }
          return;
        case XmlTag::Kind::close:
          saw_end_ = saw_end_ || tag.name == "VTKFile";
          in_points = in_points && tag.name != "Points";
          in_cells = in_cells && tag.name != "Cells";
          continue;
        case XmlTag::Kind::open:
        case XmlTag::Kind::empty:
          break;
      }
      if (tag.name == "VTKFile") {
        read_file_tag(tag);
      } else if (tag.name == "UnstructuredGrid") {
        saw_grid_ = true;
      } else if (tag.name == "Piece") {
        pieces_.push_back({count_of(tag, "NumberOfPoints"),
                           count_of(tag, "NumberOfCells"),
                           tag.offset,
                           {},
                           {},
                           {},
                           {}});
      } else if (tag.name == "Points") {
        in_points = opens;
      } else if (tag.name == "Cells") {
        in_cells = opens;
      } else if (tag.name == "DataArray" && (in_points || in_cells)) {
        keep_array(tag, in_points);
      } else if (tag.name == "AppendedData") {
        read_appended_tag(tag);
        return;  // raw data must not be searched for tags
      }
    }
  }

  void read_file_tag(const XmlTag& tag) {
    if (const std::string* type = tag.find("type");
        type != nullptr && *type != "UnstructuredGrid") {
      source_.fail_at_line(tag.offset, "a VTKFile of type " + TextReader::printable(*type) +
                                           " is not supported; UnstructuredGrid is");
    }
    if (const std::string* order = tag.find("byte_order")) {
      order_ = *order == "BigEndian" ? std::endian::big : std::endian::little;
    }
    if (const std::string* type = tag.find("header_type")) {
      if (*type != "UInt32" && *type != "UInt64") {
        source_.fail_at_line(tag.offset, "header_type must be UInt32 or UInt64");
      }
      header_type_ = *type == "UInt64" ? ScalarType::uint64 : ScalarType::uint32;
    }
    if (const std::string* compressor = tag.find("compressor");
        compressor != nullptr && !compressor->empty()) {
      if (*compressor != "vtkZLibDataCompressor") {
        source_.fail_at_line(tag.offset, "data compressed by " +
                                             TextReader::printable(*compressor) +
                                             " are not supported; zlib is");
      }
      compressed_ = true;
    }
  }

  std::size_t count_of(const XmlTag& tag, const char* attribute) const {
    const std::string* text = tag.find(attribute);
    std::int64_t value = -1;
    if (text != nullptr) {
      const auto [end, error] = std::from_chars(text->data(), text->data() + text->size(), value);
      if (error != std::errc() || end != text->data() + text->size()) {
        value = -1;
      }
    }
    if (value < 0) {
      source_.fail_at_line(tag.offset, "the tag needs " + std::string(attribute) +
                                           " with a number that is not negative");
    }
    // zlib shrinks by a factor of 1032 at best, and no element takes less than a byte
    const std::string problem = count_problem(value / 1032, attribute, 1, source_.bytes.size());
    if (!problem.empty() || value > std::numeric_limits<Index>::max()) {
      source_.fail_at_line(tag.offset, std::string(attribute) + " is " + std::to_string(value) +
                                           ", which no file of this size can hold");
    }
    return static_cast<std::size_t>(value);
  }

  void keep_array(const XmlTag& tag, bool in_points) {
    if (pieces_.empty()) {
      source_.fail_at_line(tag.offset, "a DataArray outside of any <Piece>");
    }
    DataArray array;
    const std::string* name = tag.find("Name");
    const std::string* type = tag.find("type");
    const std::string* format = tag.find("format");
    array.name = name != nullptr ? *name : in_points ? "Points" : "";
    array.format = format != nullptr ? *format : "ascii";
    array.offset = tag.offset;
    const std::optional<ScalarType> scalar =
        type != nullptr ? xml_scalar_type(*type) : std::nullopt;
    Piece& piece = pieces_.back();
    std::optional<DataArray>* place = in_points                      ? &piece.points
                                      : array.name == "connectivity" ? &piece.connectivity
                                      : array.name == "offsets"      ? &piece.offsets
                                      : array.name == "types"        ? &piece.types
                                                                     : nullptr;
    if (place == nullptr) {
      return;  // faces of polyhedra, which are refused by their type
    }
    if (!scalar) {
      fail(array, "has no known type of numbers");
    }
    array.type = *scalar;
    if (in_points) {
      array.components = tag.find("NumberOfComponents") != nullptr
                             ? static_cast<std::int64_t>(count_of(tag, "NumberOfComponents"))
                             : 1;
      if (array.components != 3) {
        fail(array, "has " + std::to_string(array.components) + " components; points have 3");
      }
    } else if (!is_integer(array.type)) {
      fail(array, "must be integers");
    }
    if (array.format == "appended") {
      array.appended = count_of(tag, "offset");
    } else if (array.format != "ascii" && array.format != "binary") {
      fail(array, "has the unknown format '" + TextReader::printable(array.format) + "'");
    }
    if (tag.kind == XmlTag::Kind::open) {
      array.text_begin = xml_.text_begin();
      array.text_end = xml_.text_end();
    }
    *place = array;
  }

  void read_appended_tag(const XmlTag& tag) {
    const std::string* encoding = tag.find("encoding");
    if (encoding != nullptr && *encoding != "raw" && *encoding != "base64") {
      source_.fail_at_line(tag.offset, "appended data must be raw or base64");
    }
    appended_base64_ = encoding == nullptr || *encoding == "base64";
    const std::size_t mark = source_.bytes.find('_', xml_.text_begin());
    if (mark == std::string::npos) {
      source_.fail_at_line(tag.offset, "appended data must begin with '_'");
    }
    appended_ = mark + 1;
  }

  void add_piece(const Piece& piece) {
    if (piece.point_count > 0 && !piece.points) {
      source_.fail_at_line(piece.offset, "the piece has no points");
    }
    const std::size_t first = mesh_.points.size();
    if (piece.points && piece.point_count > 0) {
      add_points(*piece.points, piece.point_count);
    }
    if (piece.cell_count == 0) {
      return;
    }
    for (const auto& array : {piece.connectivity, piece.offsets, piece.types}) {
      if (!array) {
        source_.fail_at_line(piece.offset,
                             "the cells need the arrays connectivity, offsets and types");
      }
    }
    CellArray cells;
    cells.offsets = read_integers(*piece.offsets, piece.cell_count);
    cells.offsets.insert(cells.offsets.begin(), 0);
    const std::int64_t entries = cells.offsets.back();
    if (entries < 0 || entries / 1032 > static_cast<std::int64_t>(source_.bytes.size())) {
      fail(*piece.offsets,
           "ends with " + std::to_string(entries) + ", which no file of this size can hold");
    }
    cells.connectivity = read_integers(*piece.connectivity, static_cast<std::size_t>(entries));
    const std::vector<std::int64_t> types = read_integers(*piece.types, piece.cell_count);
    append_vtk_cells(
        mesh_, cells, [&](std::size_t c) { return types[c]; }, first, piece.point_count,
        [&](const std::string& reason) { fail(*piece.connectivity, "is wrong: " + reason); });
  }

  void add_points(const DataArray& array, std::size_t count) {
    if (mesh_.points.size() + count > static_cast<std::size_t>(std::numeric_limits<Index>::max())) {
      fail(array, "takes the mesh beyond 2147483647 points");
    }
    if (array.format == "ascii") {
      TextReader text(source_, array.text_begin, array.text_end, '\0');
      text.checked_count(static_cast<std::int64_t>(count), "points", 3);
      mesh_.points.reserve(mesh_.points.size() + count);
      for (std::size_t i = 0; i < count; ++i) {
        mesh_.points.push_back(text.point());
      }
      return;
    }
    const std::size_t width = size_of(array.type);
    const std::string bytes = decode(array, 3 * count * width);
    mesh_.points.reserve(mesh_.points.size() + count);
    for (std::size_t i = 0; i < count; ++i) {
      Eigen::Vector3d p;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        p[static_cast<Eigen::Index>(axis)] =
            load_as<double>(array.type, bytes.data() + (3 * i + axis) * width, order_);
      }
      if (!p.allFinite()) {
        fail(array, "has a coordinate at point " + std::to_string(i) + " that is not finite");
      }
      mesh_.points.push_back(p);
    }
  }

  std::vector<std::int64_t> read_integers(const DataArray& array, std::size_t count) {
    std::vector<std::int64_t> values;
    if (array.format == "ascii") {
      TextReader text(source_, array.text_begin, array.text_end, '\0');
      values.resize(text.checked_count(static_cast<std::int64_t>(count), array.name, 1));
      for (std::int64_t& value : values) {
        value = text.number<std::int64_t>(array.name);
      }
      return values;
    }
    const std::size_t width = size_of(array.type);
    const std::string bytes = decode(array, count * width);
    values.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      values[i] = load_as<std::int64_t>(array.type, bytes.data() + i * width, order_);
    }
    return values;
  }

  /// The bytes of an array, whose number is known before anything is decoded.
  std::string decode(const DataArray& array, std::size_t wanted) {
    std::size_t begin = array.text_begin;
    std::size_t end = array.text_end;
    bool base64 = true;
    if (array.appended) {
      if (!appended_) {
        fail(array, "is in the appended data, which the file does not have");
      }
      if (*array.appended > source_.bytes.size() - *appended_) {
        fail(array, "begins behind the end of the file");
      }
      begin = *appended_ + *array.appended;
      end = source_.bytes.size();
      base64 = appended_base64_;
    }
    EncodedStream stream(std::string_view(source_.bytes).substr(0, end), begin, base64);
    const auto next_header = [&] {
      const std::string bytes = take(array, stream, size_of(header_type_));
      return load_as<std::uint64_t>(header_type_, bytes.data(), order_);
    };
    if (compressed_) {
      return inflate_blocks(array, stream, next_header, wanted);
    }
    const std::uint64_t size = next_header();
    if (size != wanted) {
      fail(array, "has " + std::to_string(size) + " bytes; its " + std::to_string(wanted) +
                      " bytes are due by the counts of the piece");
    }
    return take(array, stream, wanted);
  }

  template <class NextHeader>
  std::string inflate_blocks(const DataArray& array, EncodedStream& stream,
                             NextHeader&& next_header, std::size_t wanted) {
    const std::uint64_t blocks = next_header();
    const std::uint64_t block_size = next_header();
    const std::uint64_t last_size = next_header();
    if (blocks > stream.most_left() / size_of(header_type_)) {
      fail(array, "announces " + std::to_string(blocks) + " blocks, too many for the file");
    }
    const std::uint64_t full = last_size == 0 || blocks == 0 ? blocks : blocks - 1;
    // divided rather than multiplied, so that nothing wraps around
    if ((full > 0 && block_size > wanted / full) || last_size > wanted ||
        full * block_size + (full < blocks ? last_size : 0) != wanted) {
      fail(array, "has blocks that do not add up to its " + std::to_string(wanted) + " bytes");
    }
    std::vector<std::uint64_t> sizes(blocks);
    for (std::uint64_t& size : sizes) {
      size = next_header();
    }
    std::string bytes;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::string packed = take(array, stream, sizes[b]);
      const std::uint64_t due = b < full ? block_size : last_size;
      if (due / 1100 > packed.size()) {
        fail(array, "has a block of " + std::to_string(packed.size()) + " bytes that cannot hold " +
                        std::to_string(due));
      }
      const std::size_t done = bytes.size();
      bytes.resize(done + due);
      uLongf length = static_cast<uLongf>(due);
      const int status = uncompress(reinterpret_cast<Bytef*>(bytes.data() + done), &length,
                                    reinterpret_cast<const Bytef*>(packed.data()), packed.size());
      if (status != Z_OK || length != due) {
        fail(array,
             "has a compressed block that zlib cannot unpack to " + std::to_string(due) + " bytes");
      }
    }
    return bytes;
  }

  std::string take(const DataArray& array, EncodedStream& stream, std::size_t count) {
    std::optional<std::string> bytes = stream.take(count);
    if (!bytes) {
      source_.fail_at_byte(stream.offset(),
                           "the data of array '" + array.name + "' end too early or are damaged");
    }
    return std::move(*bytes);
  }

  [[noreturn]] void fail(const DataArray& array, const std::string& reason) const {
    source_.fail_at_line(array.offset,
                         "array '" + TextReader::printable(array.name) + "' " + reason);
  }

  std::string describe_encoding() const {
    std::string text;
    if (!pieces_.empty() && pieces_.front().points) {
      text = ", " + pieces_.front().points->format;
    }
    return text + (compressed_ ? ", zlib" : "");
  }

  const Source& source_;
  XmlReader xml_;
  std::endian order_ = std::endian::little;
  ScalarType header_type_ = ScalarType::uint32;
  bool compressed_ = false;
  bool saw_grid_ = false;
  bool saw_end_ = false;
  bool appended_base64_ = false;
  std::optional<std::size_t> appended_;
  std::vector<Piece> pieces_;
  MeshData mesh_;
};

}  // namespace

ParsedMesh parse_vtu(const Source& source) {
  return VtuFile(source).parse();
}

}  // namespace pbdsurg
