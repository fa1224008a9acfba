// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A user's surface becomes tetrahedra, no more than asked for, and what that loses is told.

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

#include "apps/cholecystectomy/warning.h"

namespace cholecystectomy {

/// About how many tetrahedra fill_organ() makes, from volume and area: within a third for closed
/// surfaces.
double estimate_tets(pbdsurg::Organ organ, const pbdsurg::MeshData& surface);

/// @param tet_count  of an organ, as known or estimated
/// @param name       of the organ and its file, for the message
/// @throws pbdsurg::InvalidArgument  with what to try, if that is more than max_tets
void check_tet_count(double tet_count, pbdsurg::Index max_tets, const std::string& name);

/// What is to be filled.
struct Filling {
  pbdsurg::Organ organ;
  std::string name;  ///< of the organ and its file, for messages
  pbdsurg::ImplicitShape shape;
  Eigen::AlignedBox3d extent;       ///< m, of the file's surface, less what the shape leaves out
  pbdsurg::Index vertex_count = 0;  ///< wanted; zero: the organ's default resolution
};

/// fill_organ(), with its result checked.
/// @param warnings  gains what was dropped, thickened or too thin
/// @throws pbdsurg::InvalidMesh      with the name and what to try, if the shape cannot be filled,
///                                   or if a side of its bounding box loses more than a fifth
/// @throws pbdsurg::InvalidArgument  as check_tet_count()
pbdsurg::TetMesh fill(const Filling& filling, pbdsurg::Index max_tets,
                      std::vector<Warning>& warnings);

/// Warns of a surface that is not closed, as filling closes it.
void warn_of_gaps(const pbdsurg::MeshData& surface, const std::string& name,
                  std::vector<Warning>& warnings);

}  // namespace cholecystectomy
