// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A user's organs as their files have them, in metres.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/mesh/read.h"

#include "apps/cholecystectomy/warning.h"
#include "apps/pbdsurg/unit_options.h"

namespace cholecystectomy {

/// A file that takes an organ's place.
struct OwnOrgan {
  pbdsurg::Organ organ;
  std::string name;  ///< with its file, for messages
  std::filesystem::path path;
  pbdsurg::MeshFile file;   ///< tetrahedra, or else triangles; all points are in use
  bool is_guessed = false;  ///< its unit
};

/// Reads files in the order of the organs. If the unit is to be guessed, a file that states its own
/// has that; all others share one, of which every organ has a plausible size.
/// @param warnings  gains one if a unit was guessed, and one for tetrahedra in several parts
/// @throws pbdsurg::InvalidArgument  naming the readings, if not exactly one unit is plausible
/// @throws pbdsurg::FileError, pbdsurg::InvalidMesh  if a file cannot be used, naming it; also if
/// no
///                                   connected part has half of its tetrahedra
std::vector<OwnOrgan> read_organs(const std::map<pbdsurg::Organ, std::filesystem::path>& paths,
                                  const pbdsurg::UnitOptions& unit, std::vector<Warning>& warnings);

}  // namespace cholecystectomy
