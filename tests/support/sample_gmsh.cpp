// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "tests/support/sample_encoders.h"
#include "tests/support/sample_numbers.h"

namespace pbdsurg::testing {
namespace {

/// Node ids with gaps, as older programs write them.
std::int32_t gap_id(Index v) {
  return 3 * v + 5;
}

/// @param Word  of four or eight bytes, as the header says
template <class Word>
std::string msh4_of_words(const MeshData& mesh, std::endian order) {
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

}  // namespace

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

std::string msh4_binary(const MeshData& mesh, std::endian order, int word_size) {
  return word_size == 4 ? msh4_of_words<std::uint32_t>(mesh, order)
                        : msh4_of_words<std::uint64_t>(mesh, order);
}

}  // namespace pbdsurg::testing
