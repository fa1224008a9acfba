// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One mesh in every encoding that the library reads.

#include <string>
#include <vector>

#include "pbdsurg/mesh/mesh_data.h"

#include "tests/support/temporary_folder.h"

namespace pbdsurg::testing {

/// A box of cells x cells x cells cubes of 1/64 m, six tetrahedra each, with its boundary
/// triangles. All coordinates are exact in single precision; some are negative.
[[nodiscard]] MeshData box_mesh(int cells);

/// The boundary of that box, its points numbered in order of first use.
[[nodiscard]] MeshData box_surface(int cells);

/// A file, or the two of a TetGen mesh; the first is the one to read.
struct SampleFile {
  struct Part {
    std::string name;
    std::string bytes;
  };
  std::string encoding;  ///< for messages
  std::vector<Part> parts;
};

/// Encodings of tetrahedra and triangles.
[[nodiscard]] std::vector<SampleFile> tet_samples(const MeshData& mesh);

/// Encodings of tetrahedra alone.
[[nodiscard]] std::vector<SampleFile> tet_only_samples(const MeshData& mesh);

/// Encodings of triangles alone, of points that are numbered in order of first use.
[[nodiscard]] std::vector<SampleFile> surface_samples(const MeshData& mesh);

}  // namespace pbdsurg::testing
