// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How a body resists deformation.

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg {

/// What holds a body's tetrahedra in shape.
enum class ElasticModel : std::uint8_t {
  springs,      ///< distances along edges and volumes of tetrahedra, as in the paper
  neo_hookean,  ///< stable Neo-Hookean tetrahedra, which have moduli; compliance mode only
};

/// m/N or m^5/N: softer than anything that can be felt. Beyond, numbers would overflow in short
/// substeps.
inline constexpr float kLargestCompliance = 1e12F;

/// How many times as stiff as its body's material a tetrahedron, or a triangle of a sheet, may be,
/// at least.
inline constexpr float kSmallestStiffness = 1e-3F;
/// And at most.
inline constexpr float kLargestStiffness = 1e3F;

/// One type of constraint's resistance, in both projection modes; the solver's mode picks one.
struct Stiffness {
  float fraction = 1;  ///< fraction mode: share of the violation removed per projection, (0, 1]
  /// compliance mode: in [0, kLargestCompliance]; distance m/N, volume m^5/N; 0 is rigid
  float compliance = 0;
};

/// Material of one body; a soft organ, unless it is told otherwise.
/// The fractions are the paper's (0.4 for stretch); compliances are rigid until given, which no
/// accuracy fits: see elastic_material().
struct PBDSURG_API Material {
  float density = 1000;                            ///< kg/m^3, positive
  ElasticModel model = ElasticModel::neo_hookean;  ///< which of the following count

  // springs
  Stiffness stretch{0.4F, 0.0F};       ///< along edges
  Stiffness volume{1.0F, 0.0F};        ///< of tetrahedra
  bool has_volume_constraints = true;  ///< false for tubes, which the paper gives edges only

  // neo_hookean
  float youngs_modulus = 5000;   ///< Pa, positive
  float poissons_ratio = 0.45F;  ///< in [0, 0.5)

  // both
  /// s, >= 0: the relaxation time of the material's inner friction, which resists the rate of
  /// deformation and never rigid motion; compliance mode only.
  float damping = 0;
  /// > 1: of its rest length, beyond which an edge resists more; infinite for no limit. Projections
  /// let no edge get longer. With vertex blocks and explicit steps it is pulled back as by a bar
  /// of the material as wide as the edge is long (stiffness E L), which makes tissue some four
  /// times as stiff there, whatever the step.
  float max_stretch = std::numeric_limits<float>::infinity();
};

/// Fibres of a tetrahedron of Neo-Hookean tissue, beside its material: collagen, muscle. Along them
/// it resists being stretched by more, see constraints/fibre.h, and compression by no more; they
/// have no mass and no inner friction.
struct Fibre {
  Eigen::Vector3f direction{1, 0, 0};  ///< at rest, of length 1 within 1e-3
  float stiffness = 0;                 ///< Pa, >= 0 and finite; 0: none
};

/// Material of a sheet: a membrane of Neo-Hookean tissue as thick as little, see
/// constraints/membrane.h, that bends as a plate. The wall of a duct, unless it is told otherwise.
struct SheetMaterial {
  float thickness = 1e-3F;       ///< m, positive
  float density = 1000;          ///< kg/m^3, positive
  float youngs_modulus = 100e3;  ///< Pa, positive
  float poissons_ratio = 0.45F;  ///< in [0, 0.5)
  float damping = 0;             ///< s, as Material::damping; of stretch and of bending
};

/// A sheet of a solid's tissue: its density, moduli and friction; a largest stretch it has none.
/// @param thickness  m
/// @throws InvalidArgument  if the solid is not Neo-Hookean
[[nodiscard]] PBDSURG_API SheetMaterial sheet_material(const Material& solid, float thickness);

/// A material whose compliances stand for an elastic solid: an edge for a bar as wide as the mesh's
/// mean edge is long (stiffness E L), a tetrahedron for the bulk modulus E / (3 (1 - 2 nu)). How
/// stiff a network of bars is as a whole depends on the mesh: take E as a scale, within a small
/// factor, not as a calibrated modulus.
///
/// @param density          kg/m^3
/// @param youngs_modulus   Pa, positive and finite; soft organs have 1e3 to 1e5
/// @param poissons_ratio   in (-1, 0.5)
/// @throws InvalidArgument  naming the value out of range, or if the mesh has no tetrahedra
[[nodiscard]] PBDSURG_API Material elastic_material(const TetMesh& mesh, double density,
                                                    double youngs_modulus,
                                                    double poissons_ratio = 0.45);

/// The same material as springs, which work in either projection mode: compliances stand for its
/// moduli as in elastic_material(), all else stays.
/// @throws InvalidArgument  if it is not Neo-Hookean; as elastic_material()
[[nodiscard]] PBDSURG_API Material springs(const TetMesh& mesh, const Material& solid);

}  // namespace pbdsurg
