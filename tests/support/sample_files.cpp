// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sample_files.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/mesh/write.h"

#include "tests/support/sample_encoders.h"
#include "tests/support/sample_numbers.h"

namespace pbdsurg::testing {
namespace {

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
          single("msh41_little_64.msh", msh4_binary(mesh, kLittle, 8)),
          single("msh41_big_64.msh", msh4_binary(mesh, kBig, 8)),
          single("msh41_big_32.msh", msh4_binary(mesh, kBig, 4)),
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
  return {
      tetgen(mesh, 0),
      tetgen(mesh, 1),
      marked(tetgen(mesh, 0)),
      single("base64_32.vtu", vtu(mesh, VtuData::inline_base64, false, false, kLittle)),
      single("base64_64_big.vtu", vtu(mesh, VtuData::inline_base64, false, true, kBig)),
      single("base64_zlib_32.vtu", vtu(mesh, VtuData::inline_base64, true, false, kLittle)),
      single("base64_zlib_64_big.vtu", vtu(mesh, VtuData::inline_base64, true, true, kBig)),
      single("appended_base64_32.vtu", vtu(mesh, VtuData::appended_base64, false, false, kLittle)),
      single("appended_base64_zlib_64.vtu",
             vtu(mesh, VtuData::appended_base64, true, true, kLittle)),
      single("appended_raw_32_big.vtu", vtu(mesh, VtuData::appended_raw, false, false, kBig)),
      single("appended_raw_zlib_32.vtu", vtu(mesh, VtuData::appended_raw, true, false, kLittle)),
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
