// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which organs are joined to which, and where.

#include <array>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/surgery/membrane.h"

#include "apps/cholecystectomy/organ_files.h"
#include "apps/cholecystectomy/warning.h"

namespace cholecystectomy {

using pbdsurg::Organ;

/// Two organs that connective tissue joins.
struct Joint {
  Organ first, second;
  double reach;              ///< m, between surfaces: no strand joins what is farther apart
  bool is_enclosed = false;  ///< the first runs through the second
};

inline constexpr double kMembraneReach = 4.5e-3;    // m, up to the liver's coarser mesh
inline constexpr double kConnectionReach = 2.5e-3;  // m, between the other organs

/// All joints, the membrane of the gallbladder first.
inline constexpr std::array<Joint, 8> kJoints{
    {{Organ::gallbladder, Organ::liver, kMembraneReach},
     {Organ::calot_fat, Organ::gallbladder, kConnectionReach},
     {Organ::calot_fat, Organ::liver, kConnectionReach},
     {Organ::cystic_artery, Organ::gallbladder, kConnectionReach},
     {Organ::cystic_duct, Organ::gallbladder, kConnectionReach},
     {Organ::cystic_duct, Organ::common_bile_duct, kConnectionReach},
     {Organ::cystic_duct, Organ::calot_fat, kConnectionReach, true},
     {Organ::cystic_artery, Organ::calot_fat, kConnectionReach, true}}};

/// How many fibres run in all links.
pbdsurg::Index fibres_of(const std::vector<pbdsurg::MembraneLink>& links);

/// Where the strands of a joint run.
///
/// Built-in organs in full detail are linked vertex by vertex. Where either organ is a user's, or
/// coarser, fibres go by area, as many for an area as between the built-in organs, however fine the
/// mesh.
/// @param warnings  gains one if there are less than a quarter of the built-in fibres, or none
///                  because the organs are farther apart than the joint's reach
std::vector<pbdsurg::MembraneLink> find_links(const Joint& joint, const LoadedAnatomy& loaded,
                                              std::vector<Warning>& warnings);

}  // namespace cholecystectomy
