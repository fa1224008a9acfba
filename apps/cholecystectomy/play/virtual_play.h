// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The operation on a rig in virtual time: one thread, the same bits each time.

#include <filesystem>
#include <string>

#include "apps/cholecystectomy/organ_files.h"

namespace cholecystectomy {

struct VirtualPlayOptions {
  std::filesystem::path out = "out";
  OrganFiles organs;
  Detail detail = Detail::full;
  std::string executor = "serial";  ///< another may give other bits
  bool is_paper = false;
  std::string devices = "emulator";  ///< see rig::read_rig()
  double seconds = 0;                ///< of virtual time; 0: as long as scripts and traces are
  bool has_pictures = true;
  bool is_recorded = false;
};

/// Servos tick each millisecond of virtual time, the simulation steps after ten of them. A step is
/// as slow as it may be: what it says of contacts is published when its time is over. Emulated
/// hands drag, burn and cut; a hand that would be the mouse's rests.
///
/// Writes into the folder: hands.csv, a row a hand and tick; a picture each half second; left.trace
/// and right.trace, where they are asked for, which play the same again; and report.json, with
/// hashes of all forces and of the last state.
/// @return  the exit status
/// @throws pbdsurg::Error  if a device, the scene or the folder cannot be had
int play_in_virtual_time(const VirtualPlayOptions& options);

}  // namespace cholecystectomy
