// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Writes meshes of tetrahedra and triangles, with named fields where the format has them.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// How numbers are written.
enum class MeshEncoding : std::uint8_t { ascii, binary };

/// Which variant of a format is written.
struct WriteOptions {
  /// Of the format: "2.2" or "4.1" for MSH, "4.2" for VTK. Empty: the one that most programs read
  /// (MSH 2.2).
  std::string version;
  /// Empty: binary where the format has it.
  std::optional<MeshEncoding> encoding;
};

/// One value, or one vector of three, for each point or cell.
struct MeshField {
  std::string name;           ///< not empty
  int components = 1;         ///< 1 or 3
  std::vector<float> values;  ///< [components * point_count or cell_count], in units of its own
};

/// Fields of a mesh. Its cells are the tetrahedra, then the triangles.
struct MeshFields {
  std::vector<MeshField> point;  ///< of points
  std::vector<MeshField> cell;   ///< of tetrahedra, then triangles
};

/// Writes a mesh in the format of the extension:
///
/// | extension | what is written                                                              |
/// |-----------|------------------------------------------------------------------------------|
/// | `.msh`    | Gmsh 2.2 or 4.1                                                              |
/// | `.vtk`    | legacy VTK 4.2, with fields                                                  |
/// | `.vtu`    | VTK XML, ASCII or appended raw, with fields                                  |
/// | `.stl`    | triangles, or the boundary of the tetrahedra if there are none; binary: float|
/// | `.obj`    | same, ASCII only; of the boundary the points in use only                     |
///
/// Text holds the shortest numbers that read back to the same bits, whatever the locale. The file
/// appears under its name when it is complete; a failed write leaves what was there before. A
/// comment or title says that the coordinates are metres, which LengthUnit::automatic then takes.
///
/// @param mesh  in metres
/// @throws InvalidArgument  for an extension, version, encoding or field that cannot be written
/// @throws InvalidMesh      for ids out of range, or a surface format without any triangle
/// @throws FileError        if the file cannot be written
PBDSURG_API void write_mesh(const std::filesystem::path& path, const MeshData& mesh,
                            const WriteOptions& options = {}, const MeshFields& fields = {});

}  // namespace pbdsurg
