// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The external program tetgen, run as a program: nothing of it is linked.

#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// Fills a closed surface with a constrained Delaunay tetrahedralisation of its own vertices.
///
/// tetgen is looked up on PATH and gets a private temporary folder, which is removed afterwards.
/// @throws BackendUnavailable  if the program cannot be started
/// @throws InvalidMesh         if it fails, takes longer than 5 minutes or writes what we cannot
///                             read
[[nodiscard]] MeshData fill_with_tetgen(const MeshData& surface);

}  // namespace pbdsurg
