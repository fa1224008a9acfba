// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The operation in a window.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/cholecystectomy/organ_files.h"

namespace cholecystectomy {

struct PlayOptions {
  std::filesystem::path out = "out";  ///< of screenshots
  OrganFiles organs;
  std::optional<Detail> detail;  ///< else as the settings have it
  std::string executor = "best";
  bool is_paper = false;
  std::string devices = "mouse";                  ///< see rig::read_rig()
  bool is_recorded = false;                       ///< hands, as left.trace and right.trace in `out`
  std::optional<std::filesystem::path> settings;  ///< else default_settings_path()
  std::int64_t pictures = 0;  ///< ends after so many; 0: when the window is closed
};

/// Plays until the window is closed, and says at the end how that went.
/// @return  the exit status
/// @throws pbdsurg::BackendUnavailable  in one sentence, if there is no display or no OpenGL 3.3,
///                                      or an arm does not open
/// @throws pbdsurg::Error               if the scene cannot be made
int play(const PlayOptions& options);

}  // namespace cholecystectomy
