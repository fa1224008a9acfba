// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/write.h"

#include <cctype>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/write_file.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/mesh/encoders.h"

namespace pbdsurg {
namespace {

template <class Element>
void check_ids(const std::vector<Element>& elements, const char* what, std::size_t point_count) {
  for (std::size_t e = 0; e < elements.size(); ++e) {
    for (const Index v : elements[e]) {
      if (v < 0 || static_cast<std::size_t>(v) >= point_count) {
        throw InvalidMesh(std::string(what) + ' ' + std::to_string(e) + " refers to point " +
                          std::to_string(v) + "; ids must be in [0, " +
                          std::to_string(point_count) + ")");
      }
    }
  }
}

void check_fields(const std::vector<MeshField>& fields, const char* what, std::size_t count) {
  for (const MeshField& field : fields) {
    if (field.name.empty()) {
      throw InvalidArgument("a field of " + std::string(what) + " has no name");
    }
    if (field.components != 1 && field.components != 3) {
      throw InvalidArgument("field '" + field.name + "' has " + std::to_string(field.components) +
                            " components; 1 or 3 can be written");
    }
    const std::size_t due = count * static_cast<std::size_t>(field.components);
    if (field.values.size() != due) {
      throw InvalidArgument("field '" + field.name + "' has " +
                            std::to_string(field.values.size()) + " values; " +
                            std::to_string(count) + ' ' + what + " need " + std::to_string(due));
    }
  }
}

/// What STL and OBJ hold of a mesh: its triangles, or the boundary of its tetrahedra with the
/// points it uses.
MeshData surface_of(const MeshData& mesh) {
  if (!mesh.triangles.empty()) {
    return {mesh.points, {}, mesh.triangles};
  }
  if (mesh.tets.empty()) {
    throw InvalidMesh("a mesh with neither triangles nor tetrahedra has no surface to write");
  }
  MeshData surface;
  std::vector<Index> new_of_old(mesh.points.size(), kInvalidIndex);
  for (const BoundaryTriangle& boundary : find_boundary(mesh.tets)) {
    for (const Index v : boundary.vertices) {
      new_of_old[v] = 0;
    }
    surface.triangles.push_back(boundary.vertices);
  }
  for (std::size_t v = 0; v < new_of_old.size(); ++v) {
    if (new_of_old[v] == 0) {
      new_of_old[v] = static_cast<Index>(surface.points.size());
      surface.points.push_back(mesh.points[v]);
    }
  }
  for (Triangle& triangle : surface.triangles) {
    for (Index& v : triangle) {
      v = new_of_old[v];
    }
  }
  return surface;
}

}  // namespace

void write_mesh(const std::filesystem::path& path, const MeshData& mesh,
                const WriteOptions& options, const MeshFields& fields) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  const bool msh = extension == ".msh";
  const bool vtk = extension == ".vtk";
  const bool vtu = extension == ".vtu";
  const bool obj = extension == ".obj";
  if (!msh && !vtk && !vtu && !obj && extension != ".stl") {
    throw InvalidArgument(path.string() + ": the extension '" + extension +
                          "' is none that can be written (msh, vtk, vtu, stl, obj)");
  }
  const std::string& version = options.version;
  if (!(version.empty() || (msh && (version == "2.2" || version == "4.1")) ||
        (vtk && version == "4.2"))) {
    throw InvalidArgument(path.string() + ": version '" + version + "' of " + extension +
                          " cannot be written (msh: 2.2, 4.1; vtk: 4.2)");
  }
  if (obj && options.encoding == MeshEncoding::binary) {
    throw InvalidArgument(path.string() + ": OBJ is a text format");
  }
  if (!vtk && !vtu && !(fields.point.empty() && fields.cell.empty())) {
    throw InvalidArgument(path.string() + ": fields can be written to vtk and vtu only");
  }
  check_ids(mesh.tets, "tet", mesh.points.size());
  check_ids(mesh.triangles, "triangle", mesh.points.size());
  check_fields(fields.point, "points", mesh.points.size());
  check_fields(fields.cell, "cells", mesh.tets.size() + mesh.triangles.size());

  const MeshEncoding encoding = options.encoding.value_or(MeshEncoding::binary);
  if (msh) {
    write_file(path, version == "4.1" ? encode_msh4(mesh, encoding) : encode_msh2(mesh, encoding));
  } else if (vtk) {
    write_file(path, encode_vtk(mesh, fields, encoding));
  } else if (vtu) {
    write_file(path, encode_vtu(mesh, fields, encoding));
  } else {
    const MeshData surface = surface_of(mesh);
    write_file(path, obj ? encode_obj(surface) : encode_stl(surface, encoding));
  }
}

}  // namespace pbdsurg
