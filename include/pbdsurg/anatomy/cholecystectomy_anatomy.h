// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// All organs of the demo scene as meshes, built in or the user's own.

#include <array>
#include <cstdint>
#include <map>
#include <variant>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/length_unit.h"
#include "pbdsurg/mesh/mesh_data.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/tetrahedralize.h"

namespace pbdsurg {

/// The organs that are simulated.
enum class Organ : std::uint8_t {
  gallbladder,       ///< its wall, hollow: 6900 vertices and 23 500 tetrahedra
  liver,             ///< 4800 and 22 000
  cystic_duct,       ///< 1050 and 3800
  cystic_artery,     ///< 1350 and 4600
  common_bile_duct,  ///< 1250 and 4600
  calot_fat,         ///< 3150 and 14 800; encloses cystic duct and artery
};

/// All of them, in the order of the enumeration.
inline constexpr std::array<Organ, 6> kOrgans{Organ::gallbladder,      Organ::liver,
                                              Organ::cystic_duct,      Organ::cystic_artery,
                                              Organ::common_bile_duct, Organ::calot_fat};

/// The enumerator as text: "gallbladder", "cystic_duct".
[[nodiscard]] PBDSURG_API const char* name_of(Organ organ);

/// Longest sides of the bounding box that a file of an organ may have. Wide, to hold parts of
/// organs and ill ones, but within a factor of ten: no two units are plausible for one organ.
///
/// | organ              | mm         | adults, mm                | source                         |
/// |--------------------|------------|---------------------------|--------------------------------|
/// | gallbladder        | 30 to 250  | 70 to 100                 | Gray 1918, Anatomy             |
/// | liver              | 60 to 450  | 200 to 225; built in, 144 | the same                       |
/// | cystic duct        | 10 to 95   | 27 on average             | Marniok et al. 1999, Med. Sci. |
/// | cystic artery      |            | 27 to its fork            | Monit. 5(3)                    |
/// | common bile duct   | 25 to 200  | 50 to 150                 | Priya et al. 2023, Folia       |
/// |                    |            |                           | Morphol. 82(3)                 |
/// | Calot's fat        | 15 to 120  | built in, 38              | fills the triangle of the ducts|
[[nodiscard]] PBDSURG_API LengthRange plausible_length(Organ organ);

/// What tetrahedralize() needs to make a built-in organ in its default resolution.
struct OrganRecipe {
  ShapeAtSpacing shape;           ///< the solid, which may depend on the spacing
  TetrahedralizeOptions options;  ///< its default resolution
};

/// The recipe of an organ. To change the resolution, change the options.
///
/// @param gallbladder     with its lumen filled; wall, liver bed and fat follow it
/// @param wall_thickness  m; thicker where the spacing cannot resolve it
/// @throws InvalidArgument  if the thickness is not positive and finite
[[nodiscard]] PBDSURG_API OrganRecipe
organ_recipe(Organ organ, const ImplicitShape& gallbladder = gallbladder_outer(),
             double wall_thickness = 2.7e-3);

/// Fills an organ of the user's own, with any topology. The report tells what was lost.
///
/// @param shape         a gallbladder's has its lumen filled; its wall is made
/// @param vertex_count  wanted; zero: the default resolution of the organ
/// @throws InvalidArgument, InvalidMesh  as tetrahedralize() and organ_recipe()
[[nodiscard]] PBDSURG_API Tetrahedralization fill_organ(Organ organ, const ImplicitShape& shape,
                                                        double wall_thickness = 2.7e-3,
                                                        Index vertex_count = 0);

/// An organ of the user's own, in the frame of organs.h: a shape that is filled with tetrahedra in
/// the default resolution of the organ, or a mesh that is taken as it is. A gallbladder's shape has
/// its lumen filled; its wall is made.
using OrganSource = std::variant<ImplicitShape, TetMesh>;

/// What is not built in.
struct CholecystectomyOptions {
  /// In place of built-in organs. Liver bed and fat follow the outside of a gallbladder given here.
  std::map<Organ, OrganSource> own;

  /// m, of a gallbladder that is made here.
  double wall_thickness = 2.7e-3;

  /// Cells of built-in organs are so many times as long as by default. 1.5 gives a third of the
  /// tetrahedra and thickens the gallbladder's wall; where tubes would get holes, they are refused.
  double coarsening = 1;
};

/// The meshes of the demo scene, in the frame of organs.h.
struct CholecystectomyAnatomy {
  std::map<Organ, TetMesh> organs;  ///< all of kOrgans
  MeshData abdominal_wall;          ///< triangles for pictures
};

/// Makes the organs. Deterministic: equal options give equal bytes.
///
/// @throws InvalidArgument  if wall thickness or coarsening is not positive and finite
/// @throws InvalidMesh      naming the organ, if one of the user's, or one that follows the user's
///                          gallbladder, cannot be filled
/// @note Cost: about 0.6 s on one thread.
[[nodiscard]] PBDSURG_API CholecystectomyAnatomy
make_cholecystectomy_anatomy(const CholecystectomyOptions& options = {});

/// The solid within the outer surface of a mesh: its cavities are filled.
/// @throws InvalidMesh  if the mesh has no tetrahedra
[[nodiscard]] PBDSURG_API ImplicitShape filled_shape(const TetMesh& mesh);

}  // namespace pbdsurg
