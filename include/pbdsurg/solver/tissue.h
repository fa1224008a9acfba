// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Materials of the tissues of a cholecystectomy.
///
///   tissue            density  modulus  max_stretch
///   liver                1079    5.2e3         1.46
///   gallbladder_wall     1071    250e3         1.54
///   fat                   911    3.3e3         1.5
///   duct                 1027    480e3         1.5
///   artery               1050    610e3         1.88
///   membrane             1027     60e3         1.5
///                      kg/m^3       Pa            1
///
/// - Densities: the IT'IS database as in tissue/thermal_properties.h; artery: the review below.
/// - Young's modulus of liver, gallbladder, duct and artery: 2 (1 + nu) times the shear moduli 1.8,
///   85, 166 and 210 kPa that Phys. Med. Biol. 64 (2019) 225001, table 1, gathers from the
///   literature (doi 10.1088/1361-6560/ab5010). Shear wave elastography of healthy livers finds
///   about 5 kPa too. Fat: Samani, Zubovits, Plewes, Phys. Med. Biol. 52 (2007) 1565, of the
///   breast. Membrane: an estimate, at the small end of what living connective tissue has.
/// - Poisson's ratio 0.45 everywhere: tissue is nearly incompressible, but tetrahedra with straight
///   edges lock towards 0.5.
/// - Largest stretch: liver, gallbladder and artery tear at true strains of 0.38, 0.43 and 0.63
///   (the same table), where the limit stands. The others: an estimate.
/// - Damping 1 ms: an estimate. Elastography of livers finds viscosities of about 2 Pa s beside
///   shear moduli of about 2 kPa.
///
/// Moduli of tissue differ by factors between persons, species and ways of measuring. Beware of
/// stiff tissue in coarse steps: what substeps and iterations cannot resolve is softer.

#include <cstdint>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/export.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/material.h"

namespace pbdsurg {

enum class Tissue : std::uint8_t { liver, gallbladder_wall, fat, duct, artery, membrane };

/// "liver", "gallbladder_wall" ...
[[nodiscard]] PBDSURG_API const char* name_of(Tissue tissue);

/// A Neo-Hookean material.
/// @throws InvalidArgument  if there is no such tissue
[[nodiscard]] PBDSURG_API Material tissue_material(Tissue tissue);

/// The same tissue as springs along edges alone, as the paper has its ducts and arteries: a hollow
/// tube, which keeps no volume. Works in both projection modes; see elastic_material().
/// @throws InvalidArgument  also if the mesh has no tetrahedra
[[nodiscard]] PBDSURG_API Material tube_material(const TetMesh& mesh, Tissue tissue);

}  // namespace pbdsurg
