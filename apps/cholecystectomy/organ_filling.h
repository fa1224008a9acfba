// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A user's surface becomes tetrahedra, no more than asked for.

#include <string>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace cholecystectomy {

/// About how many tetrahedra fill_organ() makes, from volume and area: within a third for closed
/// surfaces.
double estimate_tets(pbdsurg::Organ organ, const pbdsurg::MeshData& surface);

/// @param tet_count  of an organ, as known or estimated
/// @param name       of the organ and its file, for the message
/// @throws pbdsurg::InvalidArgument  with what to try, if that is more than max_tets
void check_tet_count(double tet_count, pbdsurg::Index max_tets, const std::string& name);

/// fill_organ(), with its result checked.
/// @throws pbdsurg::InvalidMesh      with the name and what to try, if the shape cannot be filled
/// @throws pbdsurg::InvalidArgument  as check_tet_count()
pbdsurg::TetMesh fill(pbdsurg::Organ organ, const pbdsurg::ImplicitShape& shape,
                      pbdsurg::Index max_tets, const std::string& name);

}  // namespace cholecystectomy
