// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One function a file format: the bytes of a mesh whose ids and fields are checked.

#include <string>

#include "pbdsurg/mesh/write.h"

namespace pbdsurg {

[[nodiscard]] std::string encode_msh2(const MeshData& mesh, MeshEncoding encoding);
[[nodiscard]] std::string encode_msh4(const MeshData& mesh, MeshEncoding encoding);
[[nodiscard]] std::string encode_vtk(const MeshData& mesh, const MeshFields& fields,
                                     MeshEncoding encoding);
[[nodiscard]] std::string encode_vtu(const MeshData& mesh, const MeshFields& fields,
                                     MeshEncoding encoding);

/// The triangles of a mesh.
[[nodiscard]] std::string encode_stl(const MeshData& mesh, MeshEncoding encoding);
[[nodiscard]] std::string encode_obj(const MeshData& mesh);

}  // namespace pbdsurg
