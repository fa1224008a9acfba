// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The tissues of a cholecystectomy: mechanics, heat and look of each in one record.
///
///     const TissueRecord& liver = tissues::liver();
///     const Index body = scene.add_body(liver.name, mesh, liver.mechanics);
///     Tissue tissue(scene);
///     Cautery cautery(tissue, std::array{ThermalBody{body, liver.heat}});
///
/// Moduli of tissue differ by factors between persons, species and ways of measuring: a record is a
/// start. Copy it and write what you have measured. Sources, by the marks used below:
///
/// [I]  averages of the IT'IS database, as reprinted by COMSOL's bioheat library;
/// [i]  the same database as commonly quoted, not looked up;
/// [G]  Gabriel, Lau, Gabriel, Phys. Med. Biol. 41 (1996) 2271: their four-term Cole-Cole model
///      evaluated at 500 kHz;
/// [R]  Phys. Med. Biol. 64 (2019) 225001, table 1 (doi 10.1088/1361-6560/ab5010), which gathers
///      shear moduli and true strains at failure from the literature: Young's modulus is
///      2 (1 + nu) times the former, the largest stretch the exponential of the latter.
///
/// For all tissues alike:
/// - Density: [I], [i], for mechanics and heat. [R] rounds to 1060 kg/m^3, the artery to
///   1050, while [i] has 1102: taken, as the heat capacity belongs to it.
/// - The model is Neo-Hookean; springs() makes springs of it. Poisson's ratio 0.45: tissue is
///   nearly incompressible, but tetrahedra with straight edges lock towards 0.5.
/// - Damping 1 ms: an estimate. Elastography of livers finds viscosities of about 2 Pa s beside
///   shear moduli of about 2 kPa.
/// - Largest stretch: an estimate of 1.5 where no source is named.
/// - Water contents: common literature values.
/// - Look: chosen by eye.
///
/// What is called a proxy is borrowed from another tissue. Beware of stiff tissue in coarse steps:
/// what substeps and iterations cannot resolve is softer.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/tissue/look.h"
#include "pbdsurg/tissue/material.h"
#include "pbdsurg/tissue/thermal_properties.h"

namespace pbdsurg {

/// All that is known of one tissue. A density is of both: who changes one changes the other.
struct TissueRecord {
  std::string name;        ///< that of its function: "liver"
  Material mechanics;      ///< how it resists deformation
  ThermalProperties heat;  ///< how it conducts, boils and is damaged
  TissueLook look;         ///< how it looks before it is burnt
};

/// What no soft tissue has, in mechanics, heat and look, and densities that differ: each as a
/// sentence with the tissue's name, property, value and usual range. Empty for all tissues below.
PBDSURG_API std::vector<std::string> find_unphysical(const TissueRecord& tissue);

namespace tissues {

/// Density, heat [I]; perfusion [i]. Electrical conductivity: between 0.148 of [G] and the 0.33 S/m
/// that is usual for ablation, near that of fresh pig liver (0.22, Wang et al. 2014). Modulus,
/// largest stretch [R]; shear wave elastography of healthy livers finds about 5 kPa too. Coagulated
/// it has seven times that, 36 kPa: porcine liver that is necrotic throughout has 25 and more (Guo
/// et al., with a tissue elastometer), rabbit liver after radiofrequency ablation 33 to 70
/// (Diagnostics 13 (2023) 1145). Of no other tissue a figure was found: they stay as stiff.
[[nodiscard]] PBDSURG_API const TissueRecord& liver();

/// Density, heat, perfusion [i]; electrical conductivity [G]; damage of liver as a proxy. Modulus,
/// largest stretch [R].
[[nodiscard]] PBDSURG_API const TissueRecord& gallbladder_wall();

/// Density, heat [I]; perfusion [i]; electrical conductivity [G], average infiltrated fat. Modulus:
/// Samani, Zubovits, Plewes, Phys. Med. Biol. 52 (2007) 1565, of the breast.
[[nodiscard]] PBDSURG_API const TissueRecord& fat();

/// The gallbladder's wall as a proxy, whose layers the ducts continue, but for the modulus [R].
/// Springs keep no volume: a tube is hollow.
[[nodiscard]] PBDSURG_API const TissueRecord& bile_duct();

/// Vessel wall: density, heat, perfusion [i]; electrical conductivity [G] of the aorta; damage of
/// collagen as a proxy. Modulus, largest stretch [R], hepatic artery. Springs keep no volume: a
/// tube is hollow.
[[nodiscard]] PBDSURG_API const TissueRecord& artery();

/// Connective tissue: density, heat, perfusion [i]; electrically between aorta (0.324), tendon
/// (0.391) and dura (0.503 S/m) of [G], as a proxy. Modulus: an estimate, at the small end of what
/// living connective tissue has.
[[nodiscard]] PBDSURG_API const TissueRecord& membrane();

/// Muscle as a proxy: density, heat [I]; perfusion [i]; electrical conductivity [G]; damage of
/// liver as a proxy. Modulus: the geometric mean of the linea alba's 50 kPa along and 20 kPa across
/// at 6 % of strain (J. Biomech. 44 (2011) 600).
[[nodiscard]] PBDSURG_API const TissueRecord& abdominal_wall();

/// Density, heat [i]; electrical conductivity [G]; damage of liver as a proxy. Its mechanics are of
/// a clot ten minutes old (Thromb. Res. 133 (2014) 265: 1.0 kPa, after two hours 5.3 kPa).
[[nodiscard]] PBDSURG_API const TissueRecord& blood();

/// All of the above, each once.
[[nodiscard]] PBDSURG_API std::span<const TissueRecord> all();

/// @param name  "liver", "gallbladder_wall" ...: that of the function
/// @throws InvalidArgument  naming the tissues that there are
[[nodiscard]] PBDSURG_API const TissueRecord& find(std::string_view name);

}  // namespace tissues
}  // namespace pbdsurg
