// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sample_files.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <locale>
#include <map>
#include <sstream>

#include <zlib.h>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/mesh/write.h"

namespace pbdsurg::testing {
namespace {

template <class Number>
std::string packed(Number value, std::endian order) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (order != std::endian::native) {
    std::reverse(bytes.begin(), bytes.end());
  }
  return bytes;
}

std::string text(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  out << value;
  return out.str();
}

std::string point_text(const Eigen::Vector3d& p) {
  return text(p.x()) + ' ' + text(p.y()) + ' ' + text(p.z());
}

template <class Element>
std::string ids_text(const Element& element, int base) {
  std::string out;
  for (const Index v : element) {
    out += ' ' + std::to_string(v + base);
  }
  return out;
}

std::string base64(const std::string& bytes) {
  constexpr const char* kAlphabet =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    std::uint32_t bits = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      bits = bits << 8 | (i + k < bytes.size() ? static_cast<unsigned char>(bytes[i + k]) : 0u);
    }
    for (std::size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kAlphabet[bits >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

// --- Gmsh ---

/// Node ids with gaps, as older programs write them.
std::int32_t gap_id(Index v) {
  return 3 * v + 5;
}

std::string msh1(const MeshData& mesh) {
  std::string out = "$NOD\n" + std::to_string(mesh.points.size()) + '\n';
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    out += std::to_string(gap_id(static_cast<Index>(v))) + ' ' + point_text(mesh.points[v]) + '\n';
  }
  out += "$ENDNOD\n$ELM\n" + std::to_string(mesh.tets.size() + mesh.triangles.size() + 1) + '\n';
  out += "1 15 1 1 1 " + std::to_string(gap_id(0)) + '\n';  // a point, to be skipped
  int id = 2;
  const auto add = [&](const auto& elements, const char* type) {
    for (const auto& element : elements) {
      out += std::to_string(id++) + type;
      for (const Index v : element) {
        out += ' ' + std::to_string(gap_id(v));
      }
      out += '\n';
    }
  };
  add(mesh.triangles, " 2 1 1 3");
  add(mesh.tets, " 4 1 1 4");
  return out + "$ENDELM\n";
}

std::string msh2_binary(const MeshData& mesh, std::endian order) {
  std::string out = "$MeshFormat\n2.2 1 8\n" + packed(std::int32_t{1}, order) +
                    "\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"liver\"\n$EndPhysicalNames\n"
                    "$Nodes\n" +
                    std::to_string(mesh.points.size()) + '\n';
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    out += packed(gap_id(static_cast<Index>(v)), order);
    for (const double x : mesh.points[v]) {
      out += packed(x, order);
    }
  }
  out +=
      "\n$EndNodes\n$Elements\n" + std::to_string(mesh.tets.size() + mesh.triangles.size()) + '\n';
  std::int32_t id = 1;
  const auto add = [&](const auto& elements, std::int32_t type, std::size_t block) {
    for (std::size_t e = 0; e < elements.size(); ++e) {
      if (e % block == 0) {
        out += packed(type, order) +
               packed(static_cast<std::int32_t>(std::min(block, elements.size() - e)), order) +
               packed(std::int32_t{3}, order);
      }
      out += packed(id++, order);
      for (std::int32_t tag = 1; tag <= 3; ++tag) {
        out += packed(tag, order);
      }
      for (const Index v : elements[e]) {
        out += packed(gap_id(v), order);
      }
    }
  };
  add(mesh.triangles, 2, 1);
  add(mesh.tets, 4, 7);
  return out + "\n$EndElements\n";
}

/// @param Word  of four or eight bytes, as the header says
template <class Word>
std::string msh4_binary(const MeshData& mesh, std::endian order) {
  const auto i32 = [&](std::int32_t value) { return packed(value, order); };
  const auto word = [&](std::size_t value) { return packed(static_cast<Word>(value), order); };
  const std::size_t half = mesh.points.size() / 2;
  std::string out = "$MeshFormat\n4.1 1 " + std::to_string(sizeof(Word)) + '\n' + i32(1) +
                    "\n$EndMeshFormat\n$Nodes\n" + word(2) + word(mesh.points.size()) + word(5) +
                    word(static_cast<std::size_t>(gap_id(static_cast<Index>(mesh.points.size()))));
  for (int block = 0; block < 2; ++block) {
    const std::size_t begin = block == 0 ? 0 : half;
    const std::size_t end = block == 0 ? half : mesh.points.size();
    out += i32(2) + i32(1) + i32(block) + word(end - begin);  // the second block is parametric
    for (std::size_t v = begin; v < end; ++v) {
      out += word(static_cast<std::size_t>(gap_id(static_cast<Index>(v))));
    }
    for (std::size_t v = begin; v < end; ++v) {
      for (const double x : mesh.points[v]) {
        out += packed(x, order);
      }
      out += block == 1 ? packed(0.25, order) + packed(0.75, order) : "";
    }
  }
  out += "\n$EndNodes\n$Elements\n" + word(2) + word(mesh.tets.size() + mesh.triangles.size()) +
         word(1) + word(mesh.tets.size() + mesh.triangles.size());
  std::size_t id = 1;
  const auto add = [&](const auto& elements, int dimension, int type) {
    out += i32(dimension) + i32(1) + i32(type) + word(elements.size());
    for (const auto& element : elements) {
      out += word(id++);
      for (const Index v : element) {
        out += word(static_cast<std::size_t>(gap_id(v)));
      }
    }
  };
  add(mesh.triangles, 2, 2);
  add(mesh.tets, 3, 4);
  return out + "\n$EndElements\n";
}

// --- VTK ---

std::string vtk51(const MeshData& mesh, bool binary) {
  const std::size_t cells = mesh.tets.size() + mesh.triangles.size();
  std::string out = std::string("# vtk DataFile Version 5.1\ntitle\n") +
                    (binary ? "BINARY" : "ASCII") +
                    "\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTIME 1 1 double\n" +
                    (binary ? packed(0.5, std::endian::big) : "0.5") + "\nPOINTS " +
                    std::to_string(mesh.points.size()) + " double\n";
  const auto add = [&](auto value) {
    out += binary ? packed(value, std::endian::big) : text(static_cast<double>(value)) + '\n';
  };
  for (const Eigen::Vector3d& p : mesh.points) {
    for (const double x : p) {
      add(x);
    }
  }
  out += "\nMETADATA\nINFORMATION 1\nNAME L2_NORM LOCATION vtkDataArray\n\nCELLS " +
         std::to_string(cells + 1) + ' ' +
         std::to_string(4 * mesh.tets.size() + 3 * mesh.triangles.size()) +
         "\nOFFSETS vtktypeint64\n";
  std::int64_t end = 0;
  add(end);
  for (std::size_t c = 0; c < cells; ++c) {
    end += c < mesh.tets.size() ? 4 : 3;
    add(end);
  }
  out += "\nCONNECTIVITY vtktypeint64\n";
  const auto add_ids = [&](const auto& elements) {
    for (const auto& element : elements) {
      for (const Index v : element) {
        add(std::int64_t{v});
      }
    }
  };
  add_ids(mesh.tets);
  add_ids(mesh.triangles);
  out += "\nCELL_TYPES " + std::to_string(cells) + '\n';
  for (std::size_t c = 0; c < cells; ++c) {
    add(std::int32_t{c < mesh.tets.size() ? 10 : 5});
  }
  return out + "\nPOINT_DATA " + std::to_string(mesh.points.size()) + '\n';
}

enum class VtuData { inline_base64, appended_base64, appended_raw };

/// Encoder of one .vtu flavour.
class Vtu {
 public:
  Vtu(VtuData data, bool compressed, bool wide_header, std::endian order)
      : data_(data), compressed_(compressed), wide_(wide_header), order_(order) {}

  /// Two pieces: the tetrahedra, then the triangles, each with points of its own.
  std::string encode(const MeshData& mesh) {
    std::string out = std::string(
                          "<?xml version='1.0'?>\n<!-- <Piece> -->\n<VTKFile "
                          "type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"") +
                      (order_ == std::endian::big ? "BigEndian" : "LittleEndian") +
                      "\" header_type=\"" + (wide_ ? "UInt64" : "UInt32") + '"' +
                      (compressed_ ? " compressor=\"vtkZLibDataCompressor\"" : "") +
                      ">\n<UnstructuredGrid>\n";
    out += piece(mesh.points, mesh.tets, 10);
    out += piece({}, mesh.triangles, 5);
    out += "</UnstructuredGrid>\n";
    if (data_ != VtuData::inline_base64) {
      out += std::string("<AppendedData encoding=\"") +
             (data_ == VtuData::appended_raw ? "raw" : "base64") + "\">\n_" + appended_ +
             "\n</AppendedData>\n";
    }
    return out + "</VTKFile>\n";
  }

 private:
  template <class Element>
  std::string piece(const std::vector<Eigen::Vector3d>& points,
                    const std::vector<Element>& elements, std::uint8_t type) {
    // a piece without points of its own is left empty: ids are local to their piece
    const std::size_t cells = points.empty() ? 0 : elements.size();
    std::string coordinates, connectivity, offsets, types;
    for (const Eigen::Vector3d& p : points) {
      for (const double x : p) {
        coordinates += packed(static_cast<float>(x), order_);
      }
    }
    std::int64_t end = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      for (const Index v : elements[c]) {
        connectivity += packed(std::int64_t{v}, order_);
      }
      end += static_cast<std::int64_t>(elements[c].size());
      offsets += packed(end, order_);
      types += packed(type, order_);
    }
    return "<Piece NumberOfPoints=\"" + std::to_string(points.size()) + "\" NumberOfCells='" +
           std::to_string(cells) + "'>\n<PointData>\n</PointData>\n<Points>\n" +
           array("Float32", "a &lt;&#65;&gt; name", "NumberOfComponents=\"3\"", coordinates) +
           "</Points>\n<Cells>\n" + array("Int64", "connectivity", "", connectivity) +
           array("Int64", "offsets", "", offsets) + array("UInt8", "types", "", types) +
           "</Cells>\n</Piece>\n";
  }

  std::string array(const char* type, const char* name, const char* more, const std::string& raw) {
    std::string out = std::string("<DataArray type=\"") + type + "\" Name=\"" + name + "\" " + more;
    if (data_ == VtuData::inline_base64) {
      return out + " format=\"binary\">\n  " + encoded(raw) + "\n</DataArray>\n";
    }
    out += " format=\"appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
    appended_ += encoded(raw);
    return out;
  }

  std::string header(std::uint64_t value) const {
    return wide_ ? packed(value, order_) : packed(static_cast<std::uint32_t>(value), order_);
  }

  /// Header and data are encoded apart when compressed and together when not, as VTK does.
  std::string encoded(const std::string& raw) const {
    const bool plain = data_ == VtuData::appended_raw;
    if (!compressed_) {
      const std::string all = header(raw.size()) + raw;
      return plain ? all : base64(all);
    }
    constexpr std::size_t kBlock = 1000;
    const std::size_t blocks = (raw.size() + kBlock - 1) / kBlock;
    std::string head = header(blocks) + header(kBlock) + header(raw.size() % kBlock);
    std::string body;
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::string part = raw.substr(b * kBlock, kBlock);
      uLongf size = compressBound(part.size());
      std::string packed_part(size, '\0');
      compress(reinterpret_cast<Bytef*>(packed_part.data()), &size,
               reinterpret_cast<const Bytef*>(part.data()), part.size());
      packed_part.resize(size);
      head += header(size);
      body += packed_part;
    }
    return plain ? head + body : base64(head) + base64(body);
  }

  VtuData data_;
  bool compressed_;
  bool wide_;
  std::endian order_;
  std::string appended_;
};

// --- others ---

std::string medit(const MeshData& mesh) {
  std::string out = "MeshVersionFormatted 2\n# a comment\nDimension\n3\nVertices\n" +
                    std::to_string(mesh.points.size()) + '\n';
  for (const Eigen::Vector3d& p : mesh.points) {
    out += point_text(p) + " 7\n";
  }
  out += "Corners\n2\n1\n2\nTriangles\n" + std::to_string(mesh.triangles.size()) + '\n';
  for (const Triangle& triangle : mesh.triangles) {
    out += ids_text(triangle, 1) + " 1\n";
  }
  out += "Tetrahedra\n" + std::to_string(mesh.tets.size()) + '\n';
  for (const Tet& tet : mesh.tets) {
    out += ids_text(tet, 1) + " 2\n";
  }
  return out + "End\n";
}

SampleFile tetgen(const MeshData& mesh, int base) {
  std::string node = "# nodes\n" + std::to_string(mesh.points.size()) + "  3  1  1\n";
  for (std::size_t v = 0; v < mesh.points.size(); ++v) {
    node += std::to_string(v + static_cast<std::size_t>(base)) + ' ' + point_text(mesh.points[v]) +
            " 0.5 1  # attribute, marker\n";
  }
  std::string element = std::to_string(mesh.tets.size()) + " 4 0\n";
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    element +=
        std::to_string(t + static_cast<std::size_t>(base)) + ids_text(mesh.tets[t], base) + '\n';
  }
  const std::string stem = "tetgen" + std::to_string(base) + ".1";
  SampleFile file{stem, {{stem + ".node", node}, {stem + ".ele", element}}};
  if (base == 1) {
    std::swap(file.parts[0], file.parts[1]);  // either file may be named
  }
  return file;
}

std::string ply(const MeshData& mesh, const std::string& format) {
  const bool binary = format != "ascii";
  const std::endian order = format == "binary_big_endian" ? std::endian::big : std::endian::little;
  std::string out = "ply\nformat " + format + " 1.0\ncomment made by hand\nelement vertex " +
                    std::to_string(mesh.points.size()) +
                    "\nproperty uchar red\nproperty float x\nproperty double y\nproperty float z\n"
                    "property list uchar short extra\nelement face " +
                    std::to_string(mesh.triangles.size()) +
                    "\nproperty list uchar int vertex_indices\nproperty ushort flag\nend_header\n";
  const auto add = [&](auto value) {
    out += binary ? packed(value, order) : text(static_cast<double>(value)) + ' ';
  };
  for (const Eigen::Vector3d& p : mesh.points) {
    add(std::uint8_t{255});
    add(static_cast<float>(p.x()));
    add(p.y());
    add(static_cast<float>(p.z()));
    add(std::uint8_t{2});
    add(std::int16_t{-1});
    add(std::int16_t{1});
    out += binary ? "" : "\n";
  }
  for (const Triangle& triangle : mesh.triangles) {
    add(std::uint8_t{3});
    for (const Index v : triangle) {
      add(v);
    }
    add(std::uint16_t{9});
    out += binary ? "" : "\n";
  }
  return out;
}

/// VTK polydata whose triangles are strips of three or polygons.
std::string polydata(const MeshData& mesh, bool strips) {
  std::string out = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\nPOINTS " +
                    std::to_string(mesh.points.size()) + " float\n";
  for (const Eigen::Vector3d& p : mesh.points) {
    out += point_text(p) + '\n';
  }
  const std::string count = std::to_string(mesh.triangles.size());
  out += (strips ? "TRIANGLE_STRIPS " : "POLYGONS ") + count + ' ' +
         std::to_string(4 * mesh.triangles.size()) + '\n';
  for (const Triangle& triangle : mesh.triangles) {
    out += '3' + ids_text(triangle, 0) + '\n';
  }
  return out + "CELL_DATA " + count + "\nSCALARS s float\n";
}

/// What the library itself writes.
SampleFile written(const MeshData& mesh, const std::string& name, const WriteOptions& options) {
  const TemporaryFolder folder;
  write_mesh(folder / name, mesh, options);
  return {name, {{name, read_bytes(folder / name)}}};
}

SampleFile single(const std::string& name, std::string bytes) {
  return {name, {{name, std::move(bytes)}}};
}

/// The same file as some editors save it: behind a byte-order mark.
SampleFile marked(SampleFile file) {
  const std::string old_stem = file.parts[0].name.substr(0, file.parts[0].name.find('.'));
  file.encoding += " with a byte-order mark";
  for (SampleFile::Part& part : file.parts) {
    part.name = old_stem + "_marked" + part.name.substr(old_stem.size());
    part.bytes.insert(0, "\xEF\xBB\xBF");
  }
  return file;
}

/// ASCII STL in capitals, numbers included.
SampleFile in_capitals(SampleFile file) {
  for (char& c : file.parts[0].bytes) {
    c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  }
  file.encoding = file.parts[0].name = "capitals.stl";
  return file;
}

}  // namespace

MeshData box_mesh(int cells) {
  MeshData mesh;
  const int side = cells + 1;
  for (int k = 0; k < side; ++k) {
    for (int j = 0; j < side; ++j) {
      for (int i = 0; i < side; ++i) {
        mesh.points.emplace_back((i - 1) / 64.0, j / 64.0, k / 64.0);
      }
    }
  }
  // Kuhn's division: one tetrahedron for each order in which a path runs along the three axes
  constexpr std::array<std::array<int, 3>, 6> kOrders{
      {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}}};
  const std::array<Index, 3> step{1, side, side * side};
  for (int k = 0; k < cells; ++k) {
    for (int j = 0; j < cells; ++j) {
      for (int i = 0; i < cells; ++i) {
        for (std::size_t o = 0; o < kOrders.size(); ++o) {
          Tet tet{i + side * (j + side * k), 0, 0, 0};
          for (std::size_t n = 0; n < 3; ++n) {
            tet[n + 1] = tet[n] + step[static_cast<std::size_t>(kOrders[o][n])];
          }
          if (o >= 3) {  // odd orders are inverted
            std::swap(tet[1], tet[2]);
          }
          mesh.tets.push_back(tet);
        }
      }
    }
  }
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets)) {
    mesh.triangles.push_back(triangle.vertices);
  }
  return mesh;
}

MeshData box_surface(int cells) {
  const MeshData box = box_mesh(cells);
  MeshData surface;
  std::map<Index, Index> new_of_old;
  for (Triangle triangle : box.triangles) {
    for (Index& v : triangle) {
      const auto [entry, added] =
          new_of_old.try_emplace(v, static_cast<Index>(surface.points.size()));
      if (added) {
        surface.points.push_back(box.points[v]);
      }
      v = entry->second;
    }
    surface.triangles.push_back(triangle);
  }
  return surface;
}

std::vector<SampleFile> tet_samples(const MeshData& mesh) {
  constexpr std::endian kBig = std::endian::big, kLittle = std::endian::little;
  return {written(mesh, "msh22_ascii.msh", {"2.2", MeshEncoding::ascii}),
          written(mesh, "msh22_binary.msh", {"2.2", MeshEncoding::binary}),
          written(mesh, "msh41_ascii.msh", {"4.1", MeshEncoding::ascii}),
          written(mesh, "msh41_binary.msh", {"4.1", MeshEncoding::binary}),
          written(mesh, "vtk42_ascii.vtk", {"4.2", MeshEncoding::ascii}),
          written(mesh, "vtk42_binary.vtk", {"4.2", MeshEncoding::binary}),
          written(mesh, "ascii.vtu", {"", MeshEncoding::ascii}),
          written(mesh, "appended_raw_64.vtu", {"", MeshEncoding::binary}),
          single("msh1.msh", msh1(mesh)),
          single("msh22_little.msh", msh2_binary(mesh, kLittle)),
          single("msh22_big.msh", msh2_binary(mesh, kBig)),
          single("msh41_little_64.msh", msh4_binary<std::uint64_t>(mesh, kLittle)),
          single("msh41_big_64.msh", msh4_binary<std::uint64_t>(mesh, kBig)),
          single("msh41_big_32.msh", msh4_binary<std::uint32_t>(mesh, kBig)),
          single("vtk51_ascii.vtk", vtk51(mesh, false)),
          single("vtk51_binary.vtk", vtk51(mesh, true)),
          single("medit.mesh", medit(mesh)),
          marked(written(mesh, "msh22_ascii.msh", {"2.2", MeshEncoding::ascii})),
          marked(written(mesh, "msh41_ascii.msh", {"4.1", MeshEncoding::ascii})),
          marked(single("msh1.msh", msh1(mesh))),
          marked(single("vtk51_ascii.vtk", vtk51(mesh, false))),
          marked(written(mesh, "ascii.vtu", {"", MeshEncoding::ascii})),
          marked(written(mesh, "appended_raw_64.vtu", {"", MeshEncoding::binary})),
          marked(single("medit.mesh", medit(mesh)))};
}

std::vector<SampleFile> tet_only_samples(const MeshData& mesh) {
  constexpr std::endian kBig = std::endian::big, kLittle = std::endian::little;
  const auto vtu = [&](VtuData data, bool compressed, bool wide, std::endian order) {
    return Vtu(data, compressed, wide, order).encode(mesh);
  };
  return {
      tetgen(mesh, 0),
      tetgen(mesh, 1),
      marked(tetgen(mesh, 0)),
      single("base64_32.vtu", vtu(VtuData::inline_base64, false, false, kLittle)),
      single("base64_64_big.vtu", vtu(VtuData::inline_base64, false, true, kBig)),
      single("base64_zlib_32.vtu", vtu(VtuData::inline_base64, true, false, kLittle)),
      single("base64_zlib_64_big.vtu", vtu(VtuData::inline_base64, true, true, kBig)),
      single("appended_base64_32.vtu", vtu(VtuData::appended_base64, false, false, kLittle)),
      single("appended_base64_zlib_64.vtu", vtu(VtuData::appended_base64, true, true, kLittle)),
      single("appended_raw_32_big.vtu", vtu(VtuData::appended_raw, false, false, kBig)),
      single("appended_raw_zlib_32.vtu", vtu(VtuData::appended_raw, true, false, kLittle)),
  };
}

std::vector<SampleFile> surface_samples(const MeshData& mesh) {
  SampleFile solid = written(mesh, "binary_solid.stl", {"", MeshEncoding::binary});
  solid.parts[0].bytes.replace(0, 6, "solid ");  // as many programs write it
  return {written(mesh, "ascii.stl", {"", MeshEncoding::ascii}),
          written(mesh, "binary.stl", {"", MeshEncoding::binary}),
          solid,
          in_capitals(written(mesh, "ascii.stl", {"", MeshEncoding::ascii})),
          marked(written(mesh, "ascii.stl", {"", MeshEncoding::ascii})),
          marked(written(mesh, "surface.obj", {})),
          marked(single("ascii.ply", ply(mesh, "ascii"))),
          marked(single("little.ply", ply(mesh, "binary_little_endian"))),
          written(mesh, "surface.obj", {}),
          single("ascii.ply", ply(mesh, "ascii")),
          single("little.ply", ply(mesh, "binary_little_endian")),
          single("big.ply", ply(mesh, "binary_big_endian")),
          single("polygons.vtk", polydata(mesh, false)),
          single("strips.vtk", polydata(mesh, true))};
}

}  // namespace pbdsurg::testing
