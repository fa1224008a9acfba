// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One function a file format. Each fills a mesh with all points and cells of a file, in the unit
/// of the file, and throws FileError where the format is broken.

#include <filesystem>
#include <string>

#include "pbdsurg/mesh/mesh_data.h"

#include "lib/mesh/source.h"

namespace pbdsurg {

/// What a format reader returns: the mesh and the format in words.
struct ParsedMesh {
  MeshData mesh;
  std::string format;
};

[[nodiscard]] ParsedMesh parse_msh(const Source& source);
[[nodiscard]] ParsedMesh parse_vtk(const Source& source);
[[nodiscard]] ParsedMesh parse_vtu(const Source& source);
[[nodiscard]] ParsedMesh parse_medit(const Source& source);
[[nodiscard]] ParsedMesh parse_stl(const Source& source);
[[nodiscard]] ParsedMesh parse_obj(const Source& source);
[[nodiscard]] ParsedMesh parse_ply(const Source& source);

/// @param node, element  the two files of a TetGen mesh
[[nodiscard]] ParsedMesh parse_tetgen(const Source& node, const Source& element);

}  // namespace pbdsurg
