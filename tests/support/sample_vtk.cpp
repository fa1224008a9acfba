// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <zlib.h>

#include "tests/support/sample_encoders.h"
#include "tests/support/sample_numbers.h"

namespace pbdsurg::testing {
namespace {

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

}  // namespace

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

std::string vtu(const MeshData& mesh, VtuData data, bool is_compressed, bool has_wide_header,
                std::endian order) {
  return Vtu(data, is_compressed, has_wide_header, order).encode(mesh);
}

}  // namespace pbdsurg::testing
