// SPDX-License-Identifier: Apache-2.0
// STL and OBJ.
#include <Eigen/Geometry>
#include <bit>
#include <cstdint>

#include "lib/mesh/encoders.h"
#include "lib/mesh/output.h"
#include "lib/mesh/stated_unit.h"

namespace pbdsurg {
namespace {

/// Unit normal in single precision; zero for a flat triangle, as STL asks.
Eigen::Vector3f facet_normal(const MeshData& mesh, const Triangle& triangle) {
  const Eigen::Vector3d& a = mesh.points[triangle[0]];
  const Eigen::Vector3d normal = (mesh.points[triangle[1]] - a).cross(mesh.points[triangle[2]] - a);
  const double length = normal.norm();
  if (!(length > 0)) {
    return Eigen::Vector3f::Zero();
  }
  return (normal / length).cast<float>();
}

template <class Vector>
void append_vector(std::string& out, const char* keyword, const Vector& vector) {
  out += keyword;
  for (const auto x : vector) {
    out += ' ';
    append_text(out, x);
  }
  out += '\n';
}

}  // namespace

std::string encode_stl(const MeshData& mesh, MeshEncoding encoding) {
  std::string out;
  if (encoding == MeshEncoding::ascii) {
    out = "solid " + std::string(kMetresMark) + '\n';
    for (const Triangle& triangle : mesh.triangles) {
      append_vector(out, "facet normal", facet_normal(mesh, triangle));
      out += "outer loop\n";
      for (const Index v : triangle) {
        append_vector(out, "vertex", mesh.points[v]);
      }
      out += "endloop\nendfacet\n";
    }
    return out + "endsolid " + std::string(kMetresMark) + '\n';
  }
  out = kMetresMark;  // must not begin with "solid"
  out.resize(80, ' ');
  append_bytes(out, static_cast<std::uint32_t>(mesh.triangles.size()), std::endian::little);
  const auto append = [&](const Eigen::Vector3f& vector) {
    for (const float x : vector) {
      append_bytes(out, x, std::endian::little);
    }
  };
  for (const Triangle& triangle : mesh.triangles) {
    append(facet_normal(mesh, triangle));
    for (const Index v : triangle) {
      append(mesh.points[v].cast<float>());
    }
    out.append(2, '\0');
  }
  return out;
}

std::string encode_obj(const MeshData& mesh) {
  std::string out = "# " + std::string(kMetresMark) + '\n';
  for (const Eigen::Vector3d& p : mesh.points) {
    append_vector(out, "v", p);
  }
  for (const Triangle& triangle : mesh.triangles) {
    out += 'f';
    for (const Index v : triangle) {
      out += ' ';
      append_text(out, std::int64_t{v} + 1);
    }
    out += '\n';
  }
  return out;
}

}  // namespace pbdsurg
