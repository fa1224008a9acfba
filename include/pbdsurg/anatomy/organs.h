// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The organs of a cholecystectomy as implicit shapes.
///
/// One frame for all, in metres: the gallbladder lies along x from its fundus (x = -0.015) to the
/// porta hepatis (x = 0.1), the liver above it towards +z, and a laparoscope looks from -z. Sizes
/// are those of an adult. No two organs overlap, except that Calot's fat encloses the cystic duct
/// and the cystic artery.

#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg {

/// The gallbladder with its lumen filled: 89 mm long, 36 mm wide, 59 ml, with Hartmann's pouch and
/// a neck that bends towards the cystic duct.
[[nodiscard]] PBDSURG_API ImplicitShape gallbladder_outer();

/// The wall alone, hollow inside.
/// @param thickness  m; a distended gallbladder has 1 to 3 mm. At 2.5 mm the lumen holds 40 ml.
[[nodiscard]] PBDSURG_API ImplicitShape gallbladder_wall(double thickness = 2.5e-3);

/// From the gallbladder's neck to the common bile duct: 38 mm long, 3.6 mm wide.
[[nodiscard]] PBDSURG_API ImplicitShape cystic_duct();

/// From the porta hepatis across Calot's triangle along the gallbladder's upper side: 48 mm long,
/// 2.2 to 3 mm wide.
[[nodiscard]] PBDSURG_API ImplicitShape cystic_artery();

/// From below the porta hepatis past the end of the cystic duct downwards: 56 mm long, 6.5 mm wide.
/// A third of a millimetre separates it from the cystic duct; links join them.
[[nodiscard]] PBDSURG_API ImplicitShape common_bile_duct();

/// The part of the liver above the gallbladder, without the fossa: 142 x 94 x 61 mm.
[[nodiscard]] PBDSURG_API ImplicitShape liver_block();

/// The liver with a fossa for a gallbladder of any shape, `gap` metres away from it.
[[nodiscard]] PBDSURG_API ImplicitShape liver_bed(const ImplicitShape& gallbladder,
                                                  double gap = 1e-3);

/// The fat in Calot's triangle, around cystic duct and artery; it keeps clear of a gallbladder of
/// any shape by 0.4 mm, of the liver by 0.8 mm and of the common bile duct by 0.3 mm.
[[nodiscard]] PBDSURG_API ImplicitShape calot_fat(const ImplicitShape& gallbladder);

/// The abdominal wall behind and around the organs, a backdrop for pictures: an open bowl of
/// triangles that face the organs.
[[nodiscard]] PBDSURG_API MeshData abdominal_wall();

}  // namespace pbdsurg
