// SPDX-License-Identifier: Apache-2.0
// PLY, ASCII and binary: G. Turk, "The PLY polygon file format", 1994.
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "lib/mesh/byte_reader.h"
#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

struct Property {
  std::string name;
  std::optional<ScalarType> count_type;  // of a list
  ScalarType type = ScalarType::float32;
};

struct Element {
  std::string name;
  std::size_t count = 0;
  std::vector<Property> properties;
};

ScalarType ply_scalar_type(TextReader& text) {
  const std::string_view name = text.word("a type");
  constexpr std::array<std::array<std::string_view, 2>, 10> kNames{{{"char", "int8"},
                                                                    {"uchar", "uint8"},
                                                                    {"short", "int16"},
                                                                    {"ushort", "uint16"},
                                                                    {"int", "int32"},
                                                                    {"uint", "uint32"},
                                                                    {"long", "int64"},
                                                                    {"ulong", "uint64"},
                                                                    {"float", "float32"},
                                                                    {"double", "float64"}}};
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (name == kNames[i][0] || name == kNames[i][1]) {
      return static_cast<ScalarType>(i);
    }
  }
  text.fail("'" + TextReader::printable(name) + "' is no type of numbers");
}

/// Values in text: their types do not matter.
struct TextValues {
  TextReader& reader;
  static constexpr bool kIsText = true;
  double real(ScalarType) { return reader.number<double>("a property"); }
  std::int64_t integer(ScalarType) { return reader.number<std::int64_t>("a property"); }
};

struct ByteValues {
  ByteReader& reader;
  static constexpr bool kIsText = false;
  double real(ScalarType type) { return reader.number<double>(type, "a property"); }
  std::int64_t integer(ScalarType type) { return reader.number<std::int64_t>(type, "a property"); }
};

class PlyFile {
 public:
  explicit PlyFile(const Source& source) : source_(source), text_(source) {}

  ParsedMesh parse() {
    read_header();
    if (format_ == "ascii") {
      read_body(TextValues{text_});
    } else {
      ByteReader bytes(source_, text_.offset(),
                       format_ == "binary_big_endian" ? std::endian::big : std::endian::little);
      read_body(ByteValues{bytes});
    }
    return {std::move(mesh_), "PLY, " + format_};
  }

 private:
  void read_header() {
    if (text_.word("ply") != "ply") {
      text_.fail("the file must begin with 'ply'");
    }
    while (true) {
      const std::string_view keyword = text_.word("end_header");
      if (keyword == "end_header") {
        text_.rest_of_line();
        break;
      }
      if (keyword == "format") {
        format_ = text_.word("a format");
        if (format_ != "ascii" && format_ != "binary_little_endian" &&
            format_ != "binary_big_endian") {
          text_.fail("unknown format '" + TextReader::printable(format_) + "'");
        }
      } else if (keyword == "element") {
        const std::string name(text_.word("the name of an element"));
        elements_.push_back({name, text_.count(name, 0), {}});
      } else if (keyword == "property") {
        read_property();
      } else if (keyword != "comment" && keyword != "obj_info") {
        text_.fail("unknown keyword '" + TextReader::printable(keyword) + "' in the header");
      }
      text_.rest_of_line();
    }
    if (format_.empty()) {
      text_.fail("the header names no format");
    }
  }

  void read_property() {
    if (elements_.empty()) {
      text_.fail("a property before any element");
    }
    Property property;
    if (text_.peek() == "list") {
      text_.word("list");
      property.count_type = ply_scalar_type(text_);
      if (!is_integer(*property.count_type)) {
        text_.fail("the length of a list must be an integer");
      }
    }
    property.type = ply_scalar_type(text_);
    property.name = text_.word("the name of a property");
    elements_.back().properties.push_back(std::move(property));
  }

  template <class Values>
  void read_body(Values values) {
    for (const Element& element : elements_) {
      if (element.properties.empty()) {
        continue;
      }
      std::size_t least = 0;  // tokens or bytes of one element
      for (const Property& property : element.properties) {
        least += Values::kIsText ? 1 : size_of(property.count_type.value_or(property.type));
      }
      values.reader.checked_count(static_cast<std::int64_t>(element.count), element.name, least);
      if (element.name == "vertex") {
        read_vertices(values, element);
      } else if (element.name == "face") {
        read_faces(values, element);
      } else if (element.name == "tristrips" && element.count > 0) {
        values.reader.fail("triangle strips in PLY are not supported");
      } else {
        skip_elements(values, element);
      }
    }
  }

  template <class Values>
  void read_vertices(Values& values, const Element& element) {
    int axes_found = 0;
    for (const Property& property : element.properties) {
      axes_found += axis_of(property) >= 0 ? 1 : 0;
    }
    if (axes_found != 3) {
      values.reader.fail("the vertices need the properties x, y and z once each");
    }
    mesh_.points.reserve(element.count);
    for (std::size_t i = 0; i < element.count; ++i) {
      Eigen::Vector3d p = Eigen::Vector3d::Zero();
      for (const Property& property : element.properties) {
        const int axis = axis_of(property);
        if (axis < 0) {
          skip(values, property);
          continue;
        }
        p[axis] = values.real(property.type);
        if (!std::isfinite(p[axis])) {
          values.reader.fail("coordinate " + property.name + " of vertex " + std::to_string(i) +
                             " is not finite");
        }
      }
      mesh_.points.push_back(p);
    }
  }

  template <class Values>
  void read_faces(Values& values, const Element& element) {
    std::vector<Index> corners;
    for (std::size_t f = 0; f < element.count; ++f) {
      for (const Property& property : element.properties) {
        const bool ids = property.name == "vertex_indices" || property.name == "vertex_index";
        if (!ids || !property.count_type || !is_integer(property.type)) {
          skip(values, property);
          continue;
        }
        const std::size_t count = list_length(values, property);
        const std::string problem =
            corner_problem(CellShape::polygon, count, static_cast<std::int64_t>(f));
        if (!problem.empty()) {
          values.reader.fail(problem);
        }
        corners.clear();
        for (std::size_t i = 0; i < count; ++i) {
          const std::int64_t id = values.integer(property.type);
          if (id < 0 || id >= static_cast<std::int64_t>(mesh_.points.size())) {
            values.reader.fail("face " + std::to_string(f) + " " +
                               id_problem(id, 0, mesh_.points.size()));
          }
          corners.push_back(static_cast<Index>(id));
        }
        append_cell(mesh_, CellShape::polygon, corners);
      }
    }
  }

  template <class Values>
  void skip_elements(Values& values, const Element& element) {
    for (std::size_t i = 0; i < element.count; ++i) {
      for (const Property& property : element.properties) {
        skip(values, property);
      }
    }
  }

  template <class Values>
  void skip(Values& values, const Property& property) {
    const std::size_t count = property.count_type ? list_length(values, property) : 1;
    for (std::size_t i = 0; i < count; ++i) {
      values.real(property.type);
    }
  }

  template <class Values>
  std::size_t list_length(Values& values, const Property& property) {
    return values.reader.checked_count(values.integer(*property.count_type), "list entries",
                                       Values::kIsText ? 1 : size_of(property.type));
  }

  static int axis_of(const Property& property) {
    if (property.count_type) {
      return -1;
    }
    return property.name == "x" ? 0 : property.name == "y" ? 1 : property.name == "z" ? 2 : -1;
  }

  const Source& source_;
  TextReader text_;
  std::string format_;
  std::vector<Element> elements_;
  MeshData mesh_;
};

}  // namespace

ParsedMesh parse_ply(const Source& source) {
  return PlyFile(source).parse();
}

}  // namespace pbdsurg
