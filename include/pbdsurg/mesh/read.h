// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Reads meshes of tetrahedra and surfaces of triangles.
///
/// | format                     | what is read                                                   |
/// |----------------------------|----------------------------------------------------------------|
/// | Gmsh `.msh`                | 1.0, 2.x and 4.1; ASCII and binary of either byte order        |
/// | legacy VTK `.vtk`          | up to 5.1; ASCII and binary; unstructured grids and polydata   |
/// | VTK XML `.vtu`             | ASCII, base64, appended raw and base64; zlib; several pieces   |
/// | TetGen `.node` and `.ele`  | either file is named, both must be there; numbered from 0 or 1 |
/// | Medit `.mesh`              | ASCII                                                          |
/// | STL, OBJ, PLY              | surfaces; STL corners with equal coordinates are joined        |
///
/// Coordinates are metres unless ReadOptions says otherwise.
/// Four-node tetrahedra and triangles are kept; quadrilaterals, polygons and strips become
/// triangles. Lines, points and surface cells of higher order are skipped. Any other volume cell is
/// refused. What a file says about itself is checked against its size before memory is taken.
/// Text may begin with the byte-order mark of UTF-8; rows of MSH files must be one line each.
/// Files are read whole into memory and must be under 2 GiB.

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/length_unit.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// How coordinates of a file become metres.
struct ReadOptions {
  LengthUnit unit = LengthUnit::metre;  ///< what one unit of the file's coordinates is
  LengthRange expected = kAnyOrgan;     ///< longest sides that `automatic` takes for plausible
  double scale = 1;  ///< of the coordinates before that: {.scale = 0.0254} reads inches
};

/// A mesh with what was found out about its file.
struct MeshFile {
  MeshData mesh;                        ///< in metres, ids and orientation as in the file
  std::string format;                   ///< for people: "Gmsh MSH 4.1, binary"
  LengthUnit unit = LengthUnit::metre;  ///< never `automatic`: what the coordinates were taken for
  double longest_side = 0.0;            ///< m, of the bounding box of the points in use
  double metres_per_unit = 1.0;         ///< what the coordinates were multiplied by, scale included

  /// What the file says of itself, as those of write_mesh() do; `automatic` then guesses nothing.
  std::optional<LengthUnit> stated_unit;
  /// Those of the guess; `unit` alone where nothing was guessed.
  std::vector<LengthUnit> plausible_units{LengthUnit::metre};

  /// Whether the unit is a guess for which another would do as well, or none fits.
  [[nodiscard]] bool unit_ambiguous() const { return plausible_units.size() != 1; }
};

/// Reads a mesh and reports on the file. All points are kept, in the order of the file, also those
/// that nothing uses; ids with gaps are mapped to positions in that order.
///
/// @throws FileError  with path, line (text) or byte (binary) and reason, if the file cannot be
///                    read, breaks the rules of its format or holds no points
/// @throws InvalidArgument  if the scale is not positive and finite, or makes coordinates infinite
[[nodiscard]] PBDSURG_API MeshFile read_mesh_file(const std::filesystem::path& path,
                                                  const ReadOptions& options = {});

/// Takes the coordinates of a file that was read in metres for another unit: for files that share
/// one, which is guessed once all are read.
/// @throws InvalidArgument  if the file was read in another unit, or for `automatic`
PBDSURG_API void set_unit(MeshFile& file, LengthUnit unit);

/// Reads a mesh: read_mesh_file() without the report.
[[nodiscard]] PBDSURG_API MeshData read_mesh(const std::filesystem::path& path,
                                             const ReadOptions& options = {});

/// Reads a mesh of tetrahedra for simulation. If more than half of the tetrahedra have negative
/// volume, the file counts its corners the other way round and all are turned. Nothing is dropped:
/// unused points keep their ids.
///
/// @throws FileError    as read_mesh_file(), and if the file holds no tetrahedra
/// @throws InvalidMesh  with the path, if the mesh breaks a guarantee of TetMesh
[[nodiscard]] PBDSURG_API TetMesh read_tet_mesh(const std::filesystem::path& path,
                                                const ReadOptions& options = {});

/// Makes the mesh for simulation of a mesh that was read: the second half of read_tet_mesh().
/// @param path  for messages
[[nodiscard]] PBDSURG_API TetMesh to_tet_mesh(MeshData mesh, const std::filesystem::path& path);

/// Turns all tetrahedra if more than half of those that are not flat have negative volume.
/// @return  whether they were turned
/// @throws InvalidArgument  naming the vertex that there is not; then nothing has changed
PBDSURG_API bool orient_majority(MeshData& mesh);

}  // namespace pbdsurg
