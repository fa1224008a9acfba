// SPDX-License-Identifier: Apache-2.0
// Gmsh MSH 1.0, 2.x and 4.1: section "File formats" of the Gmsh reference manual.
#include <algorithm>
#include <array>
#include <optional>

#include "lib/mesh/byte_reader.h"
#include "lib/mesh/cells.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/point_ids.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

enum class Version { v1, v2, v4 };

/// One reader for text and binary: the blocks of MSH 4.1 hold the same numbers in the same order.
template <class Reader>
constexpr bool kIsText = std::is_same_v<Reader, TextReader>;

class MshFile {
 public:
  explicit MshFile(const Source& source) : source_(source), text_(source) {}

  ParsedMesh parse() {
    while (!text_.at_end()) {
      const std::string name(text_.word("a section"));
      if (name.front() != '$') {
        text_.fail("'" + TextReader::printable(name) + "' stands where a $Section should begin");
      }
      if (name == "$MeshFormat") {
        read_format();
      } else if (name == "$Nodes" || name == "$NOD") {
        read_section(name, [&] { read_nodes(); });
      } else if (name == "$Elements" || name == "$ELM") {
        if (!nodes_read_) {
          text_.fail(name + " comes before the nodes");
        }
        read_section(name, [&] { read_elements(); });
      } else {
        skip_section(name);
      }
    }
    if (!nodes_read_) {
      text_.fail("the file has no section $Nodes");
    }
    return {std::move(mesh_), "Gmsh MSH " + version_name_ + (binary_ ? ", binary" : ", ASCII")};
  }

 private:
  void read_format() {
    version_name_ = text_.word("the version");
    const int mode = text_.number<int>("the file type");
    word_size_ = text_.number<int>("the data size");
    if (version_name_ == "4.1") {
      version_ = Version::v4;
    } else if (version_name_ == "2" || version_name_.starts_with("2.")) {
      version_ = Version::v2;
    } else {
      text_.fail("version " + TextReader::printable(version_name_) +
                 " is not supported; 1.0, 2.x and 4.1 are (gmsh -save -format msh41 converts)");
    }
    if (mode != 0 && mode != 1) {
      text_.fail("the file type is " + std::to_string(mode) +
                 "; it must be 0 (ASCII) or 1 (binary)");
    }
    if (word_size_ != 8 && !(word_size_ == 4 && version_ == Version::v4)) {
      text_.fail("the data size is " + std::to_string(word_size_) + "; it must be 8");
    }
    binary_ = mode == 1;
    if (binary_) {
      ByteReader bytes = binary_reader();
      const char* const mark = bytes.take(4, "the byte order mark");
      if (load<std::int32_t>(mark, std::endian::little) == 1) {
        order_ = std::endian::little;
      } else if (load<std::int32_t>(mark, std::endian::big) == 1) {
        order_ = std::endian::big;
      } else {
        bytes.fail("the byte order mark is not 1 in either byte order");
      }
      text_.seek(bytes.offset());
    }
    expect("$EndMeshFormat");
  }

  template <class Body>
  void read_section(const std::string& name, Body&& body) {
    if (version_ == Version::v1 && name != "$NOD" && name != "$ELM") {
      text_.fail(name + " without a $MeshFormat before it");
    }
    body();
    expect(name == "$NOD" ? "$ENDNOD" : name == "$ELM" ? "$ENDELM" : "$End" + name.substr(1));
  }

  void expect(const std::string& word) {
    if (text_.word(word) != word) {
      text_.fail("the section should end here with " + word);
    }
  }

  void skip_section(const std::string& name) {
    // binary sections are searched, too: none of those skipped is likely to hold its own end mark
    const std::string end = "$End" + name.substr(1);
    const std::size_t found = source_.bytes.find(end, text_.offset());
    if (found == std::string::npos) {
      text_.fail("section " + TextReader::printable(name) + " has no end");
    }
    text_.seek(found + end.size());
  }

  /// Binary data start behind the end of the current line.
  ByteReader binary_reader() {
    text_.rest_of_line();
    return ByteReader(source_, text_.offset(), order_);
  }

  void read_nodes() {
    if (nodes_read_) {
      text_.fail("the nodes come twice");
    }
    nodes_read_ = true;
    if (version_ == Version::v4) {
      with_reader([&](auto& reader) { read_nodes_4(reader); });
    } else {
      const std::size_t count = text_.count("nodes", binary_ ? 0 : 4);
      if (binary_) {
        ByteReader bytes = binary_reader();
        bytes.checked_count(static_cast<std::int64_t>(count), "nodes", 28);
        read_numbered_nodes(bytes, count);
        text_.seek(bytes.offset());
      } else {
        read_numbered_nodes(text_, count);
      }
    }
    const std::string problem = ids_.finish();
    if (!problem.empty()) {
      text_.fail(problem);
    }
  }

  void read_elements() {
    if (version_ == Version::v4) {
      with_reader([&](auto& reader) { read_elements_4(reader); });
    } else if (binary_) {
      const std::size_t count = text_.count("elements", 0);
      ByteReader bytes = binary_reader();
      bytes.checked_count(static_cast<std::int64_t>(count), "elements", 8);
      read_elements_2(bytes, count);
      text_.seek(bytes.offset());
    } else {
      read_elements_ascii(text_.count("elements", 4));
    }
  }

  /// Calls body with the reader of the file's kind.
  template <class Body>
  void with_reader(Body&& body) {
    if (binary_) {
      ByteReader bytes = binary_reader();
      body(bytes);
      text_.seek(bytes.offset());
    } else {
      body(text_);
    }
  }

  template <class Reader>
  void read_numbered_nodes(Reader& reader, std::size_t count) {
    ids_.reserve(count);
    mesh_.points.reserve(count);
    for (std::size_t i = 0; i < count; ++i) {
      begin_row(reader);
      const std::int64_t id = read_int(reader, "a node id");
      ids_.add(id);
      mesh_.points.push_back(reader.point());
      end_row(reader, "node", id);
    }
  }

  // --- MSH 1 and 2 ---

  void read_elements_ascii(std::size_t count) {
    for (std::size_t i = 0; i < count; ++i) {
      begin_row(text_);
      const auto id = text_.number<std::int64_t>("an element id");
      const auto number = text_.number<std::int64_t>("an element type");
      const CellType type = checked_type(text_, number, id);
      if (version_ == Version::v1) {
        text_.number<std::int64_t>("a physical region");
        text_.number<std::int64_t>("an elementary region");
        const auto said = text_.number<std::int64_t>("a node count");
        if (said != type.node_count) {
          text_.fail("element " + std::to_string(id) + " has " + std::to_string(said) +
                     " nodes; a " + type.name + " has " + std::to_string(type.node_count));
        }
      } else {
        const std::size_t tag_count = text_.count("tags", 1);
        for (std::size_t tag = 0; tag < tag_count; ++tag) {
          text_.number<std::int64_t>("a tag");
        }
      }
      read_corners(text_, type, id, [&] { return read_int(text_, "a node id"); });
      end_row(text_, "element", id);
    }
  }

  void read_elements_2(ByteReader& bytes, std::size_t count) {
    for (std::size_t done = 0; done < count;) {
      const auto number = bytes.number<std::int32_t>("an element type");
      const auto in_block = bytes.number<std::int32_t>("the elements of a block");
      const auto tag_count = bytes.number<std::int32_t>("the tags of an element");
      const CellType type = checked_type(bytes, number, static_cast<std::int64_t>(done + 1));
      if (tag_count < 0 || tag_count > 1 << 20) {
        bytes.fail("a block of elements with " + std::to_string(tag_count) + " tags each");
      }
      const auto row = static_cast<std::size_t>(1 + tag_count + type.node_count) * 4;
      const std::size_t block = bytes.checked_count(in_block, "elements of a block", row);
      if (block == 0 || block > count - done) {
        bytes.fail("a block of " + std::to_string(block) + " elements, but " +
                   std::to_string(count - done) + " are due");
      }
      for (std::size_t i = 0; i < block; ++i) {
        const auto id = bytes.number<std::int32_t>("an element id");
        bytes.take(static_cast<std::size_t>(tag_count) * 4, "the tags of an element");
        read_corners(bytes, type, id, [&] { return read_int(bytes, "a node id"); });
      }
      done += block;
    }
  }

  // --- MSH 4.1 ---

  template <class Reader>
  void read_nodes_4(Reader& reader) {
    const std::int64_t blocks = read_size(reader, "the number of node blocks");
    const std::int64_t total = read_size(reader, "the number of nodes");
    read_size(reader, "the smallest node id");
    read_size(reader, "the largest node id");
    const std::size_t count =
        reader.checked_count(total, "nodes", kIsText<Reader> ? 4 : 24 + size_bytes());
    ids_.reserve(count);
    mesh_.points.reserve(count);
    for (std::int64_t b = 0; b < blocks; ++b) {
      begin_row(reader);
      const std::int64_t dimension = read_int(reader, "an entity dimension");
      read_int(reader, "an entity tag");
      const std::int64_t parametric = read_int(reader, "whether nodes are parametric");
      const std::size_t in_block = block_count(reader, "nodes", count - ids_.count());
      end_row(reader, "node block", b + 1);
      if (dimension < 0 || dimension > 3 || parametric < 0 || parametric > 1) {
        reader.fail("a node block of dimension " + std::to_string(dimension) +
                    " with parametric flag " + std::to_string(parametric));
      }
      for (std::size_t i = 0; i < in_block; ++i) {
        begin_row(reader);
        const std::int64_t id = read_size(reader, "a node id");
        ids_.add(id);
        end_row(reader, "node", id);
      }
      for (std::size_t i = 0; i < in_block; ++i) {
        begin_row(reader);
        mesh_.points.push_back(reader.point());
        for (std::int64_t p = 0; p < parametric * dimension; ++p) {
          read_double(reader, "a parametric coordinate");
        }
        end_row(reader, "coordinates", static_cast<std::int64_t>(mesh_.points.size()));
      }
    }
    if (ids_.count() != count) {
      reader.fail("the blocks hold " + std::to_string(ids_.count()) + " nodes, but " +
                  std::to_string(count) + " are announced");
    }
  }

  template <class Reader>
  void read_elements_4(Reader& reader) {
    const std::int64_t blocks = read_size(reader, "the number of element blocks");
    const std::int64_t total = read_size(reader, "the number of elements");
    read_size(reader, "the smallest element id");
    read_size(reader, "the largest element id");
    const std::size_t count =
        reader.checked_count(total, "elements", kIsText<Reader> ? 2 : 2 * size_bytes());
    std::size_t done = 0;
    for (std::int64_t b = 0; b < blocks; ++b) {
      begin_row(reader);
      read_int(reader, "an entity dimension");
      read_int(reader, "an entity tag");
      const std::int64_t number = read_int(reader, "an element type");
      const CellType type = checked_type(reader, number, static_cast<std::int64_t>(done + 1));
      const std::size_t in_block = block_count(reader, "elements", count - done);
      end_row(reader, "element block", b + 1);
      for (std::size_t i = 0; i < in_block; ++i) {
        begin_row(reader);
        const std::int64_t id = read_size(reader, "an element id");
        read_corners(reader, type, id, [&] { return read_size(reader, "a node id"); });
        end_row(reader, "element", id);
      }
      done += in_block;
    }
    if (done != count) {
      reader.fail("the blocks hold " + std::to_string(done) + " elements, but " +
                  std::to_string(count) + " are announced");
    }
  }

  template <class Reader>
  std::size_t block_count(Reader& reader, const char* what, std::size_t due) {
    const std::int64_t count = read_size(reader, "the size of a block");
    if (count < 0 || static_cast<std::size_t>(count) > due) {
      reader.fail("a block of " + std::to_string(count) + " " + what + ", but " +
                  std::to_string(due) + " are due");
    }
    return static_cast<std::size_t>(count);
  }

  // --- rows: nodes, elements and heads of blocks have a line each in text ---

  static void begin_row(TextReader& reader) { reader.begin_row(); }
  static void begin_row(ByteReader&) {}
  static void end_row(TextReader& reader, const char* what, std::int64_t id) {
    reader.end_row(what, id);
  }
  static void end_row(ByteReader&, const char*, std::int64_t) {}

  // --- single numbers ---

  std::size_t size_bytes() const { return static_cast<std::size_t>(word_size_); }

  static std::int64_t read_int(TextReader& reader, const char* what) {
    return reader.number<std::int64_t>(what);
  }
  static std::int64_t read_int(ByteReader& reader, const char* what) {
    return reader.number<std::int32_t>(what);
  }
  std::int64_t read_size(TextReader& reader, const char* what) const {
    return reader.number<std::int64_t>(what);
  }
  std::int64_t read_size(ByteReader& reader, const char* what) const {
    return reader.number<std::int64_t>(word_size_ == 4 ? ScalarType::uint32 : ScalarType::uint64,
                                       what);
  }
  static void read_double(TextReader& reader, const char* what) { reader.number<double>(what); }
  static void read_double(ByteReader& reader, const char* what) { reader.number<double>(what); }

  template <class Reader>
  static CellType checked_type(Reader& reader, std::int64_t number, std::int64_t element) {
    const CellType type = gmsh_element_type(number);
    const std::string problem = cell_problem(type, number, element);
    if (!problem.empty()) {
      reader.fail(problem);
    }
    return type;
  }

  template <class Reader>
  Index find_node(Reader& reader, std::int64_t node, std::int64_t element) const {
    const Index index = ids_.find(node);
    if (index == kInvalidIndex) {
      reader.fail("element " + std::to_string(element) + " refers to node " + std::to_string(node) +
                  "; no node has this id");
    }
    return index;
  }

  /// @param next_id  reads one node id
  template <class Reader, class NextId>
  void read_corners(Reader& reader, const CellType& type, std::int64_t element, NextId&& next_id) {
    std::array<Index, 4> corners{};
    for (int n = 0; n < type.node_count; ++n) {
      const std::int64_t node = next_id();
      if (type.shape != CellShape::ignored) {
        corners[static_cast<std::size_t>(n)] = find_node(reader, node, element);
      }
    }
    append_cell(mesh_, type.shape, {corners.data(), type.shape == CellShape::triangle ? 3u : 4u});
  }

  const Source& source_;
  TextReader text_;
  Version version_ = Version::v1;
  std::string version_name_ = "1.0";
  int word_size_ = 8;
  bool binary_ = false;
  bool nodes_read_ = false;
  std::endian order_ = std::endian::native;
  PointIds ids_;
  MeshData mesh_;
};

}  // namespace

ParsedMesh parse_msh(const Source& source) {
  return MshFile(source).parse();
}

}  // namespace pbdsurg
