// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <cstdint>

#include "lib/mesh/encoders.h"
#include "lib/mesh/output.h"
#include "lib/mesh/stated_unit.h"

namespace pbdsurg {
namespace {

constexpr int kGmshTriangle = 2, kGmshTet = 4;

/// Appends numbers as text or bytes, so that one function writes both encodings.
class Numbers {
 public:
  Numbers(std::string& out, MeshEncoding encoding)
      : out_(out), binary_(encoding == MeshEncoding::binary) {}

  void integer(std::int32_t value) { append(value); }
  void size(std::uint64_t value) { append(value); }
  void point(const Eigen::Vector3d& p) {
    append(p.x());
    append(p.y());
    append(p.z());
  }
  void end_line() {
    if (!binary_) {
      out_.back() = '\n';  // in place of the separator
    }
  }

 private:
  template <class Number>
  void append(Number value) {
    if (binary_) {
      append_bytes(out_, value, std::endian::native);
    } else {
      append_text(out_, value);
      out_ += ' ';
    }
  }

  std::string& out_;
  bool binary_;
};

std::string begin_file(const char* version, MeshEncoding encoding) {
  const bool binary = encoding == MeshEncoding::binary;
  std::string out = std::string("$MeshFormat\n") + version + (binary ? " 1 8\n" : " 0 8\n");
  if (binary) {
    append_bytes(out, std::int32_t{1}, std::endian::native);
    out += '\n';
  }
  return out + "$EndMeshFormat\n";
}

std::string end_file() {
  return "$EndElements\n$Comments\n" + std::string(kMetresMark) + "\n$EndComments\n";
}

/// Elements of one type in MSH 2.2; binary files announce them as a block.
template <class Element>
void append_elements_2(std::string& out, const std::vector<Element>& elements, int type,
                       std::int32_t& id, MeshEncoding encoding) {
  constexpr std::int32_t kTags = 2;
  const bool binary = encoding == MeshEncoding::binary;
  Numbers numbers(out, encoding);
  if (binary && !elements.empty()) {
    numbers.integer(type);
    numbers.integer(static_cast<std::int32_t>(elements.size()));
    numbers.integer(kTags);
  }
  for (const Element& element : elements) {
    numbers.integer(id++);
    if (!binary) {
      numbers.integer(type);
      numbers.integer(kTags);
    }
    numbers.integer(0);  // no physical group
    numbers.integer(1);  // elementary entity
    for (const Index v : element) {
      numbers.integer(v + 1);
    }
    numbers.end_line();
  }
}

/// The surface and the volume that the elements belong to; Gmsh insists on them.
void append_entities(std::string& out, const MeshData& mesh, MeshEncoding encoding) {
  Eigen::Vector3d low = Eigen::Vector3d::Zero();
  Eigen::Vector3d high = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < mesh.points.size(); ++i) {
    low = i == 0 ? mesh.points[i] : low.cwiseMin(mesh.points[i]).eval();
    high = i == 0 ? mesh.points[i] : high.cwiseMax(mesh.points[i]).eval();
  }
  Numbers numbers(out, encoding);
  const int surfaces = mesh.triangles.empty() && !mesh.tets.empty() ? 0 : 1;
  const int volumes = mesh.tets.empty() ? 0 : 1;
  out += "$Entities\n";
  numbers.size(0);  // points
  numbers.size(0);  // curves
  numbers.size(static_cast<std::uint64_t>(surfaces));
  numbers.size(static_cast<std::uint64_t>(volumes));
  numbers.end_line();
  for (int i = 0; i < surfaces + volumes; ++i) {
    numbers.integer(1);  // entity tag
    numbers.point(low);
    numbers.point(high);
    numbers.size(0);  // physical groups
    numbers.size(0);  // bounding entities
    numbers.end_line();
  }
  out += encoding == MeshEncoding::binary ? "\n$EndEntities\n" : "$EndEntities\n";
}

/// Elements of one type in MSH 4.1: one entity block.
template <class Element>
void append_elements_4(std::string& out, const std::vector<Element>& elements, int dimension,
                       int type, std::uint64_t& id, MeshEncoding encoding) {
  if (elements.empty()) {
    return;
  }
  Numbers numbers(out, encoding);
  numbers.integer(dimension);
  numbers.integer(1);  // entity tag
  numbers.integer(type);
  numbers.size(elements.size());
  numbers.end_line();
  for (const Element& element : elements) {
    numbers.size(id++);
    for (const Index v : element) {
      numbers.size(static_cast<std::uint64_t>(v) + 1);
    }
    numbers.end_line();
  }
}

}  // namespace

std::string encode_msh2(const MeshData& mesh, MeshEncoding encoding) {
  const char* const section_end = encoding == MeshEncoding::binary ? "\n" : "";
  std::string out = begin_file("2.2", encoding);
  Numbers numbers(out, encoding);
  out += "$Nodes\n" + std::to_string(mesh.points.size()) + '\n';
  std::int32_t id = 1;
  for (const Eigen::Vector3d& p : mesh.points) {
    numbers.integer(id++);
    numbers.point(p);
    numbers.end_line();
  }
  out += section_end;
  out += "$EndNodes\n$Elements\n" + std::to_string(mesh.tets.size() + mesh.triangles.size()) + '\n';
  id = 1;
  append_elements_2(out, mesh.triangles, kGmshTriangle, id, encoding);
  append_elements_2(out, mesh.tets, kGmshTet, id, encoding);
  out += section_end;
  return out + end_file();
}

std::string encode_msh4(const MeshData& mesh, MeshEncoding encoding) {
  const char* const section_end = encoding == MeshEncoding::binary ? "\n" : "";
  std::string out = begin_file("4.1", encoding);
  Numbers numbers(out, encoding);
  const std::uint64_t point_count = mesh.points.size();

  append_entities(out, mesh, encoding);
  out += "$Nodes\n";
  const auto header = [&](std::uint64_t blocks, std::uint64_t count) {
    numbers.size(blocks);
    numbers.size(count);
    numbers.size(1);
    numbers.size(count);
    numbers.end_line();
  };
  header(1, point_count);
  numbers.integer(mesh.tets.empty() ? 2 : 3);
  numbers.integer(1);  // entity tag
  numbers.integer(0);  // not parametric
  numbers.size(point_count);
  numbers.end_line();
  for (std::uint64_t id = 1; id <= point_count; ++id) {
    numbers.size(id);
    numbers.end_line();
  }
  for (const Eigen::Vector3d& p : mesh.points) {
    numbers.point(p);
    numbers.end_line();
  }
  out += section_end;

  out += "$EndNodes\n$Elements\n";
  header((mesh.tets.empty() ? 0 : 1) + (mesh.triangles.empty() ? 0 : 1),
         mesh.tets.size() + mesh.triangles.size());
  std::uint64_t id = 1;
  append_elements_4(out, mesh.triangles, 2, kGmshTriangle, id, encoding);
  append_elements_4(out, mesh.tets, 3, kGmshTet, id, encoding);
  out += section_end;
  return out + end_file();
}

}  // namespace pbdsurg
