// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstdint>
#include <type_traits>

#include "lib/mesh/encoders.h"
#include "lib/mesh/output.h"
#include "lib/mesh/stated_unit.h"

namespace pbdsurg {
namespace {

std::string xml_escaped(const std::string& name) {
  std::string result;
  for (const char c : name) {
    switch (c) {
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '&':
        result += "&amp;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}

template <class Number>
constexpr const char* type_name() {
  if constexpr (std::is_same_v<Number, double>) {
    return "Float64";
  } else if constexpr (std::is_same_v<Number, float>) {
    return "Float32";
  } else if constexpr (std::is_same_v<Number, std::uint8_t>) {
    return "UInt8";
  } else {
    static_assert(std::is_same_v<Number, std::int32_t>);
    return "Int32";
  }
}

/// Adds DataArray elements: their values as text, or as an offset into the appended data.
class Arrays {
 public:
  Arrays(std::string& out, MeshEncoding encoding)
      : out_(out), binary_(encoding == MeshEncoding::binary) {}

  /// @param each  calls its argument with each value of the array
  template <class Number, class Each>
  void add(const std::string& name, int components, std::size_t value_count, Each&& each) {
    out_ += std::string("<DataArray type=\"") + type_name<Number>() + "\" Name=\"" +
            xml_escaped(name) + "\" NumberOfComponents=\"" + std::to_string(components) + '"';
    if (binary_) {
      out_ += " format=\"appended\" offset=\"" + std::to_string(appended_.size()) + "\"/>\n";
      append_bytes(appended_, static_cast<std::uint64_t>(value_count * sizeof(Number)),
                   std::endian::little);
      each([&](Number value) { append_bytes(appended_, value, std::endian::little); });
      return;
    }
    out_ += " format=\"ascii\">\n";
    each([&](Number value) {
      if constexpr (std::is_same_v<Number, std::uint8_t>) {
        append_text(out_, static_cast<int>(value));
      } else {
        append_text(out_, value);
      }
      out_ += '\n';
    });
    out_ += "</DataArray>\n";
  }

  [[nodiscard]] const std::string& appended() const { return appended_; }

 private:
  std::string& out_;
  std::string appended_;
  bool binary_;
};

void add_fields(std::string& out, Arrays& arrays, const char* section,
                const std::vector<MeshField>& fields) {
  out += std::string("<") + section + ">\n";
  for (const MeshField& field : fields) {
    arrays.add<float>(field.name, field.components, field.values.size(), [&](auto&& put) {
      for (const float value : field.values) {
        put(value);
      }
    });
  }
  out += std::string("</") + section + ">\n";
}

}  // namespace

std::string encode_vtu(const MeshData& mesh, const MeshFields& fields, MeshEncoding encoding) {
  const std::size_t tet_count = mesh.tets.size();
  const std::size_t cell_count = tet_count + mesh.triangles.size();
  std::string out = "<?xml version=\"1.0\"?>\n<!-- " + std::string(kMetresMark) +
                    " -->\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" "
                    "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<UnstructuredGrid>\n"
                    "<Piece NumberOfPoints=\"" +
                    std::to_string(mesh.points.size()) + "\" NumberOfCells=\"" +
                    std::to_string(cell_count) + "\">\n";
  Arrays arrays(out, encoding);

  out += "<Points>\n";
  arrays.add<double>("Points", 3, 3 * mesh.points.size(), [&](auto&& put) {
    for (const Eigen::Vector3d& p : mesh.points) {
      for (const double x : p) {
        put(x);
      }
    }
  });
  out += "</Points>\n<Cells>\n";
  arrays.add<std::int32_t>("connectivity", 1, 4 * tet_count + 3 * mesh.triangles.size(),
                           [&](auto&& put) {
                             for (const Tet& tet : mesh.tets) {
                               for (const Index v : tet) {
                                 put(v);
                               }
                             }
                             for (const Triangle& triangle : mesh.triangles) {
                               for (const Index v : triangle) {
                                 put(v);
                               }
                             }
                           });
  arrays.add<std::int32_t>("offsets", 1, cell_count, [&](auto&& put) {
    std::int32_t end = 0;
    for (std::size_t c = 0; c < cell_count; ++c) {
      end += c < tet_count ? 4 : 3;
      put(end);
    }
  });
  arrays.add<std::uint8_t>("types", 1, cell_count, [&](auto&& put) {
    constexpr std::uint8_t kVtkTriangle = 5, kVtkTet = 10;
    for (std::size_t c = 0; c < cell_count; ++c) {
      put(c < tet_count ? kVtkTet : kVtkTriangle);
    }
  });
  out += "</Cells>\n";
  add_fields(out, arrays, "PointData", fields.point);
  add_fields(out, arrays, "CellData", fields.cell);
  out += "</Piece>\n</UnstructuredGrid>\n";
  if (encoding == MeshEncoding::binary) {
    out += "<AppendedData encoding=\"raw\">\n_";
    out += arrays.appended();
    out += "\n</AppendedData>\n";
  }
  return out + "</VTKFile>\n";
}

}  // namespace pbdsurg
