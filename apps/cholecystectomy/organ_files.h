// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A user's own organs: files read, brought into the scene's frame, given to the anatomy.

#include <filesystem>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"

#include "apps/cholecystectomy/warning.h"
#include "apps/pbdsurg/unit_options.h"

namespace cholecystectomy {

struct OrganFiles {
  std::map<pbdsurg::Organ, std::filesystem::path> paths;
  pbdsurg::UnitOptions unit;          ///< of all files
  bool keeps_placement = false;       ///< organs keep their places to one another
  pbdsurg::Index max_tets = 300'000;  ///< an organ
};

/// How fine the built-in organs are.
enum class Detail {
  full,  ///< 73,000 tetrahedra
  low,   ///< a third of these
};

/// An anatomy in which some organs come from files.
struct LoadedAnatomy {
  pbdsurg::CholecystectomyAnatomy anatomy;
  std::set<pbdsurg::Organ> own;  ///< those from files
  Detail detail = Detail::full;  ///< of the others
  /// All of the built-in anatomy in full detail, for comparison; none where nothing differs from
  /// it.
  std::map<pbdsurg::Organ, pbdsurg::TetMesh> built_in;
  std::vector<std::string> notes;  ///< what was done to files, a line each
  std::vector<Warning> warnings;
};

/// Builds the anatomy.
///
/// A file with tetrahedra is taken as it is; a surface is filled, a gallbladder's with a wall of
/// the default thickness. A liver gets a fossa, so that one with tetrahedra is filled anew, with
/// about as many vertices. Each is moved, never scaled, so that its centre and its principal axes
/// meet those of the organ it replaces; or all are by one motion, see fit_motion(). Liver bed and
/// fat are made to fit the gallbladder.
/// @throws pbdsurg::InvalidArgument  if the unit cannot be guessed, if an organ is more than four
///                                   times larger or smaller than the one it replaces, or has more
///                                   tetrahedra than allowed, which is told before it is filled
/// @throws pbdsurg::FileError, pbdsurg::InvalidMesh  if a file cannot be used, naming it
LoadedAnatomy load_anatomy(const OrganFiles& files, Detail detail = Detail::full);

/// The organ of that name, as in the report.
/// @throws pbdsurg::InvalidArgument  naming the organs that there are
pbdsurg::Organ find_organ(const std::string& name);

}  // namespace cholecystectomy
