// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All organs of the demo scene as meshes, built in or the user's own.

#include <variant>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// Where an organ comes from: nothing for the one built in, a shape that is filled with
/// tetrahedra, or a mesh that is taken as it is. All in the frame of organs.h.
using OrganSource = std::variant<std::monostate, ImplicitShape, TetMesh>;

struct CholecystectomyOptions {
  /// A shape is the organ with its lumen filled; its wall is made. The liver's fossa and the fat
  /// follow the outside of whatever is given, so a user's gallbladder gets a bed of its own.
  OrganSource gallbladder;
  OrganSource liver;
  OrganSource cystic_duct;
  OrganSource cystic_artery;
  OrganSource common_bile_duct;
  OrganSource calot_fat;

  /// m, of a gallbladder that is made here; the cells are 0.88 times as large.
  double wall_thickness = 2.7e-3;
};

struct CholecystectomyAnatomy {
  TetMesh gallbladder;       ///< the wall, hollow: about 6800 vertices and 23 300 tetrahedra
  TetMesh liver;             ///< about 4700 and 21 700
  TetMesh cystic_duct;       ///< about 1000 and 3600
  TetMesh cystic_artery;     ///< about 1350 and 4600
  TetMesh common_bile_duct;  ///< about 1250 and 4600
  TetMesh calot_fat;         ///< about 3100 and 14 700; encloses cystic duct and artery
  MeshData abdominal_wall;   ///< triangles for pictures
};

/// Makes the organs. Deterministic: equal options give equal bytes.
///
/// @throws InvalidArgument  if the wall's thickness is not positive and finite
/// @throws InvalidMesh      if an organ of the user's cannot be filled
/// @note Cost: about 1 s on one thread.
[[nodiscard]] CholecystectomyAnatomy make_cholecystectomy_anatomy(
    const CholecystectomyOptions& options = {});

/// The solid within the outer surface of a mesh: its cavities are filled.
/// @throws InvalidMesh  if the mesh has no tetrahedra
[[nodiscard]] ImplicitShape filled_shape(const TetMesh& mesh);

}  // namespace pbdsurg
