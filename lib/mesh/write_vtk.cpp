// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstdint>
#include <span>

#include "lib/mesh/encoders.h"
#include "lib/mesh/output.h"
#include "lib/mesh/stated_unit.h"

namespace pbdsurg {
namespace {

constexpr std::int32_t kVtkTriangle = 5, kVtkTet = 10;

/// Binary legacy files are big-endian.
class Rows {
 public:
  Rows(std::string& out, MeshEncoding encoding)
      : out_(out), binary_(encoding == MeshEncoding::binary) {}

  template <class Number>
  void append(Number value) {
    if (binary_) {
      append_bytes(out_, value, std::endian::big);
    } else {
      append_text(out_, value);
      out_ += ' ';
    }
  }
  void end_row() {
    if (!binary_) {
      out_.back() = '\n';  // in place of the separator
    }
  }
  void end_array() {
    if (binary_) {
      out_ += '\n';
    }
  }

 private:
  std::string& out_;
  bool binary_;
};

/// Names are words; VTK escapes what would end one.
std::string escaped(const std::string& name) {
  constexpr std::string_view kDigits = "0123456789ABCDEF";
  std::string result;
  for (const char c : name) {
    if (c <= ' ' || c == '%' || c == '"' || c == '\x7f') {
      const auto byte = static_cast<unsigned char>(c);
      result += {'%', kDigits[byte >> 4], kDigits[byte & 15]};
    } else {
      result += c;
    }
  }
  return result;
}

void append_fields(std::string& out, Rows& rows, const char* section, std::size_t count,
                   const std::vector<MeshField>& fields) {
  if (fields.empty()) {
    return;
  }
  out += std::string(section) + ' ' + std::to_string(count) + "\nFIELD FieldData " +
         std::to_string(fields.size()) + '\n';
  for (const MeshField& field : fields) {
    out += escaped(field.name) + ' ' + std::to_string(field.components) + ' ' +
           std::to_string(count) + " float\n";
    for (const float value : field.values) {
      rows.append(value);
      rows.end_row();
    }
    rows.end_array();
  }
}

}  // namespace

std::string encode_vtk(const MeshData& mesh, const MeshFields& fields, MeshEncoding encoding) {
  const std::size_t cell_count = mesh.tets.size() + mesh.triangles.size();
  std::string out = "# vtk DataFile Version 4.2\n" + std::string(kMetresMark) + '\n';
  out += encoding == MeshEncoding::binary ? "BINARY\n" : "ASCII\n";
  out += "DATASET UNSTRUCTURED_GRID\nPOINTS " + std::to_string(mesh.points.size()) + " double\n";
  Rows rows(out, encoding);
  for (const Eigen::Vector3d& p : mesh.points) {
    for (const double x : p) {
      rows.append(x);
    }
    rows.end_row();
  }
  rows.end_array();

  out += "CELLS " + std::to_string(cell_count) + ' ' +
         std::to_string(5 * mesh.tets.size() + 4 * mesh.triangles.size()) + '\n';
  const auto append_cells = [&](const auto& cells) {
    for (const auto& cell : cells) {
      rows.append(static_cast<std::int32_t>(cell.size()));
      for (const Index v : cell) {
        rows.append(v);
      }
      rows.end_row();
    }
  };
  append_cells(mesh.tets);
  append_cells(mesh.triangles);
  rows.end_array();

  out += "CELL_TYPES " + std::to_string(cell_count) + '\n';
  for (std::size_t c = 0; c < cell_count; ++c) {
    rows.append(c < mesh.tets.size() ? kVtkTet : kVtkTriangle);
    rows.end_row();
  }
  rows.end_array();
  append_fields(out, rows, "POINT_DATA", mesh.points.size(), fields.point);
  append_fields(out, rows, "CELL_DATA", cell_count, fields.cell);
  return out;
}

}  // namespace pbdsurg
