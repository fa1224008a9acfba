// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/read.h"

#include <algorithm>
#include <cctype>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"
#include "lib/mesh/formats.h"
#include "lib/mesh/stated_unit.h"
#include "lib/mesh/text_reader.h"
#include "lib/mesh/vertex_ids.h"

namespace pbdsurg {
namespace {

std::string lower_extension(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) {
    c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  return extension;
}

bool starts_with(const Source& source, std::string_view text) {
  return std::string_view(source.bytes).substr(source.text_begin).starts_with(text);
}

ParsedMesh parse_tetgen_pair(const std::filesystem::path& path) {
  std::filesystem::path node = path;
  std::filesystem::path element = path;
  node.replace_extension(".node");
  element.replace_extension(".ele");
  for (const std::filesystem::path& file : {node, element}) {
    if (!std::filesystem::exists(file)) {
      throw FileError(path.string() + ": a TetGen mesh is two files, and " +
                      file.filename().string() + " is not there");
    }
  }
  return parse_tetgen(read_source(node), read_source(element));
}

/// What the first bytes say goes before the name; STL, OBJ and Medit have no sure sign.
ParsedMesh parse(const Source& source, const std::string& extension) {
  if (source.bytes.empty()) {
    throw FileError(source.path + ": is empty");
  }
  if (starts_with(source, "$MeshFormat") || starts_with(source, "$NOD")) {
    return parse_msh(source);
  }
  if (starts_with(source, "# vtk DataFile")) {
    return parse_vtk(source);
  }
  if (starts_with(source, "ply\n") || starts_with(source, "ply\r")) {
    return parse_ply(source);
  }
  if (starts_with(source, "MeshVersionFormatted")) {
    return parse_medit(source);
  }
  if (extension == ".vtu" || (starts_with(source, "<") &&
                              source.bytes.substr(0, 4096).find("<VTKFile") != std::string::npos)) {
    return parse_vtu(source);
  }
  if (extension == ".msh") {
    return parse_msh(source);
  }
  if (extension == ".vtk") {
    return parse_vtk(source);
  }
  if (extension == ".mesh") {
    return parse_medit(source);
  }
  if (extension == ".stl") {
    return parse_stl(source);
  }
  if (extension == ".obj") {
    return parse_obj(source);
  }
  if (extension == ".ply") {
    return parse_ply(source);
  }
  throw FileError(source.path + ": neither its first bytes nor its extension '" + extension +
                  "' are those of a known format (msh, vtk, vtu, node, ele, mesh, stl, obj, ply)");
}

/// Longest side of the bounding box of the points in use, or of all if none is.
double longest_side(const MeshData& mesh) {
  Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
  Eigen::Array3d high = -low;
  const auto add = [&](const Eigen::Vector3d& p) {
    low = low.min(p.array());
    high = high.max(p.array());
  };
  for (const Tet& tet : mesh.tets) {
    for (const Index v : tet) {
      add(mesh.points[v]);
    }
  }
  for (const Triangle& triangle : mesh.triangles) {
    for (const Index v : triangle) {
      add(mesh.points[v]);
    }
  }
  if (mesh.tets.empty() && mesh.triangles.empty()) {
    for (const Eigen::Vector3d& p : mesh.points) {
      add(p);
    }
  }
  return (high - low).maxCoeff();
}

/// A mesh in the coordinates of its file, as if they were metres.
MeshFile read_unscaled(const std::filesystem::path& path) {
  ParsedMesh parsed;
  bool are_metres_stated = false;
  const std::string extension = lower_extension(path);
  if (extension == ".node" || extension == ".ele") {
    parsed = parse_tetgen_pair(path);
  } else {
    const Source source = read_source(path);
    parsed = parse(source, extension);
    are_metres_stated = states_metres(source.bytes);
  }
  if (parsed.mesh.points.empty()) {
    throw FileError(path.string() + ": the mesh is empty: it has no points");
  }
  MeshFile file;
  file.mesh = std::move(parsed.mesh);
  file.format = std::move(parsed.format);
  file.longest_side = longest_side(file.mesh);
  if (are_metres_stated) {
    file.stated_unit = LengthUnit::metre;
  }
  return file;
}

void multiply(MeshFile& file, double factor) {
  if (factor == 1) {
    return;
  }
  for (std::size_t i = 0; i < file.mesh.points.size(); ++i) {
    const Eigen::Vector3d& p = file.mesh.points[i];
    if (p.allFinite() && !(factor * p).allFinite()) {
      throw InvalidArgument("the scale of a mesh is " + describe(factor) + "; point " +
                            std::to_string(i) + " would be no longer finite");
    }
  }
  file.longest_side *= factor;
  file.metres_per_unit *= factor;
  for (Eigen::Vector3d& p : file.mesh.points) {
    p *= factor;
  }
}

}  // namespace

MeshFile read_mesh_file(const std::filesystem::path& path, const ReadOptions& options) {
  check_positive("the scale of a mesh", options.scale, "");
  MeshFile file = read_unscaled(path);
  multiply(file, options.scale);
  if (options.unit != LengthUnit::automatic) {
    set_unit(file, options.unit);
  } else if (file.stated_unit) {
    set_unit(file, *file.stated_unit);
  } else {
    LengthUnitGuess guess = guess_length_unit(file.longest_side, options.expected);
    set_unit(file, guess.unit);
    file.plausible_units = std::move(guess.plausible);
  }
  return file;
}

void set_unit(MeshFile& file, LengthUnit unit) {
  if (file.unit != LengthUnit::metre) {
    throw InvalidArgument(std::string("the mesh was read in ") + name_of(file.unit) +
                          "; to take it for another unit, it must have been read in metres");
  }
  multiply(file, metres_per(unit));
  file.unit = unit;
  file.plausible_units = {unit};
}

MeshData read_mesh(const std::filesystem::path& path, const ReadOptions& options) {
  return read_mesh_file(path, options).mesh;
}

bool orient_majority(MeshData& mesh) {
  check_vertex_ids<Tet>(static_cast<Index>(mesh.points.size()), mesh.tets);
  std::ptrdiff_t balance = 0;
  for (const Tet& tet : mesh.tets) {
    if (!is_flat(mesh.points, tet)) {
      balance += tet_volume(mesh.points, tet) > 0 ? 1 : -1;
    }
  }
  if (balance >= 0) {
    return false;
  }
  for (Tet& tet : mesh.tets) {
    std::swap(tet[2], tet[3]);
  }
  return true;
}

TetMesh read_tet_mesh(const std::filesystem::path& path, const ReadOptions& options) {
  return to_tet_mesh(read_mesh(path, options), path);
}

TetMesh to_tet_mesh(MeshData mesh, const std::filesystem::path& path) {
  if (mesh.tets.empty()) {
    if (mesh.triangles.empty()) {
      throw FileError(path.string() + ": has points but neither tetrahedra nor triangles");
    }
    throw FileError(path.string() + ": is a surface of " + std::to_string(mesh.triangles.size()) +
                    " triangles without tetrahedra; fill it first: pbdsurg mesh make " +
                    path.string() + " OUT.vtu");
  }
  try {
    orient_majority(mesh);
  } catch (const InvalidArgument& error) {
    throw InvalidMesh(path.string() + ": " + error.what());
  }
  const auto inverted = std::count_if(mesh.tets.begin(), mesh.tets.end(), [&mesh](const Tet& tet) {
    return tet_volume(mesh.points, tet) < 0;
  });
  const std::string advice =
      inverted == 0
          ? ""
          : "; of " + std::to_string(mesh.tets.size()) + " tets, " + std::to_string(inverted) +
                " have negative volume: pbdsurg mesh convert --orient turns them";
  try {
    return TetMesh(std::move(mesh.points), std::move(mesh.tets));
  } catch (const InvalidMesh& error) {
    throw InvalidMesh(path.string() + ": " + error.what() + advice);
  }
}

}  // namespace pbdsurg
