// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A user's own organs: files read, brought into the scene's frame, given to the anatomy.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/mesh/length_unit.h"

namespace cholecystectomy {

/// An anatomy in which some organs come from files, and what was done to them, a line each.
struct LoadedAnatomy {
  pbdsurg::CholecystectomyAnatomy anatomy;
  std::vector<std::string> notes;
};

/// Builds the anatomy.
///
/// A file with tetrahedra is taken as it is; a surface is filled, a gallbladder's with a wall of
/// the default thickness. Each is moved, never scaled, so that its centre and its principal axes
/// meet those of the organ it replaces. Liver bed and fat are made to fit the gallbladder; a liver
/// of the user's gets a fossa.
/// @throws pbdsurg::InvalidArgument  if an organ is more than four times larger or smaller than the
///                                   one it replaces
/// @throws pbdsurg::FileError, pbdsurg::InvalidMesh  if a file cannot be used, naming it
LoadedAnatomy load_anatomy(const std::map<pbdsurg::Organ, std::filesystem::path>& files,
                           pbdsurg::LengthUnit unit);

/// The organ of that name, as in the report.
/// @throws pbdsurg::InvalidArgument  naming the organs that there are
pbdsurg::Organ find_organ(const std::string& name);

}  // namespace cholecystectomy
