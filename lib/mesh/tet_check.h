// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Volumes, angles and faces of the tetrahedra of a mesh, for its report.

#include <cstddef>
#include <span>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/check.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// @param twice  how many use a vertex twice: they are flat, and known to be
void measure_tets(const MeshData& mesh, std::size_t twice, MeshReport& report);

/// @param tets  that use no vertex twice
void count_faces(std::span<const Tet> tets, MeshReport& report);

}  // namespace pbdsurg
