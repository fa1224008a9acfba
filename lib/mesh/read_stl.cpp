// SPDX-License-Identifier: Apache-2.0
// STL, ASCII and binary: 3D Systems, "Stereolithography interface specification", 1988.
#include <algorithm>
#include <cctype>
#include <numeric>
#include <tuple>

#include "lib/mesh/byte_reader.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/text_reader.h"

namespace pbdsurg {
namespace {

constexpr std::size_t kHeaderBytes = 84;
constexpr std::size_t kFacetBytes = 50;

/// Joins corners with equal coordinates; points are numbered in order of first use.
MeshData weld(const std::vector<Eigen::Vector3d>& corners) {
  std::vector<Index> order(corners.size());
  std::iota(order.begin(), order.end(), 0);
  const auto key = [&](Index i) {
    const Eigen::Vector3d& p = corners[static_cast<std::size_t>(i)];
    return std::tuple(p.x(), p.y(), p.z());
  };
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
  std::vector<Index> first(corners.size());  // the first corner at the same place
  for (std::size_t i = 0; i < order.size(); ++i) {
    const bool same = i > 0 && key(order[i]) == key(order[i - 1]);
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  MeshData mesh;
  std::vector<Index> point_of(corners.size());
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (first[i] == static_cast<Index>(i)) {
      point_of[i] = static_cast<Index>(mesh.points.size());
      mesh.points.push_back(corners[i]);
    } else {
      point_of[i] = point_of[first[i]];
    }
    if (i % 3 == 2) {
      mesh.triangles.push_back({point_of[i - 2], point_of[i - 1], point_of[i]});
    }
  }
  return mesh;
}

/// Whether a word is a keyword, which some programs write in capitals.
bool is_keyword(std::string_view word, std::string_view keyword) {
  return std::equal(word.begin(), word.end(), keyword.begin(), keyword.end(), [](char a, char b) {
    return std::tolower(static_cast<unsigned char>(a)) == b;
  });
}

std::size_t binary_size(const Source& source) {
  const auto count = load<std::uint32_t>(source.bytes.data() + 80, std::endian::little);
  return kHeaderBytes + kFacetBytes * static_cast<std::size_t>(count);
}

/// A binary header may begin with "solid", so the size decides; text must go on with "facet".
bool is_ascii(const Source& source) {
  if (source.bytes.size() >= kHeaderBytes && binary_size(source) == source.bytes.size()) {
    return false;
  }
  TextReader text(source);
  if (!is_keyword(text.peek(), "solid")) {
    return false;
  }
  text.rest_of_line();
  const std::string_view second = text.peek();
  return is_keyword(second, "facet") || is_keyword(second, "endsolid") || second.empty();
}

std::vector<Eigen::Vector3d> read_ascii(const Source& source) {
  TextReader text(source);
  std::vector<Eigen::Vector3d> corners;
  const auto expect = [&](const char* keyword) {
    if (!is_keyword(text.word(keyword), keyword)) {
      text.fail("the keyword '" + std::string(keyword) + "' should be here");
    }
  };
  while (!text.at_end()) {
    expect("solid");
    text.rest_of_line();
    while (is_keyword(text.peek(), "facet")) {
      text.rest_of_line();  // the normal follows from the corners
      expect("outer");
      expect("loop");
      for (int corner = 0; corner < 3; ++corner) {
        expect("vertex");
        corners.push_back(text.point());
      }
      expect("endloop");
      expect("endfacet");
    }
    expect("endsolid");
    text.rest_of_line();
  }
  return corners;
}

std::vector<Eigen::Vector3d> read_binary(const Source& source) {
  ByteReader bytes(source, 0, std::endian::little);
  bytes.take(80, "the header");
  const auto count = bytes.number<std::uint32_t>("the number of triangles");
  if (binary_size(source) != source.bytes.size()) {
    bytes.fail(std::to_string(count) + " triangles take " + std::to_string(binary_size(source)) +
               " bytes, but the file has " + std::to_string(source.bytes.size()));
  }
  std::vector<Eigen::Vector3d> corners;
  corners.reserve(3 * static_cast<std::size_t>(count));
  for (std::uint32_t t = 0; t < count; ++t) {
    bytes.take(12, "a normal");
    for (int corner = 0; corner < 3; ++corner) {
      corners.push_back(bytes.point(ScalarType::float32));
    }
    bytes.take(2, "the attributes of a triangle");
  }
  return corners;
}

}  // namespace

ParsedMesh parse_stl(const Source& source) {
  const bool ascii = is_ascii(source);
  return {weld(ascii ? read_ascii(source) : read_binary(source)),
          ascii ? "STL, ASCII" : "STL, binary"};
}

}  // namespace pbdsurg
