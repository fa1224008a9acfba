// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Encodings of a mesh that the library reads and does not write, as other programs write them.

#include <bit>
#include <string>

#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg::testing {

[[nodiscard]] std::string msh1(const MeshData& mesh);
[[nodiscard]] std::string msh2_binary(const MeshData& mesh, std::endian order);
/// @param word_size  bytes, 4 or 8
[[nodiscard]] std::string msh4_binary(const MeshData& mesh, std::endian order, int word_size);

[[nodiscard]] std::string vtk51(const MeshData& mesh, bool binary);
/// VTK polydata whose triangles are strips of three or polygons.
[[nodiscard]] std::string polydata(const MeshData& mesh, bool strips);

enum class VtuData { inline_base64, appended_base64, appended_raw };
/// Two pieces: the tetrahedra, then the triangles, each with points of its own.
[[nodiscard]] std::string vtu(const MeshData& mesh, VtuData data, bool is_compressed,
                              bool has_wide_header, std::endian order);

}  // namespace pbdsurg::testing
