// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the window remembers from one time to the next.

#include <filesystem>
#include <optional>
#include <string>

#include "apps/cholecystectomy/organ_files.h"

namespace cholecystectomy {

/// How much a picture may cost.
enum class PictureQuality {
  automatic,  ///< quick where a processor draws, else full
  quick,
  full,
};

struct Settings {
  Detail detail = Detail::full;
  PictureQuality quality = PictureQuality::automatic;
  bool is_left_handed = false;
  std::optional<bool> follows_tips;  ///< the scope, by itself; none: as suits the hands
  double motion_scale = 1;           ///< of the mouse's moves, 0.2 to 3
  double text_scale = 1;             ///< of panels, 0.7 to 3
  double volume = 0.5;               ///< 0 to 1
  double cut_power = 30;             ///< W, 1 to 120
  double coagulation_power = 30;     ///< W, 1 to 120
  int width = 1280, height = 720;    ///< of the window, pixels
};

/// XDG_CONFIG_HOME/pbdsurg/cholecystectomy.json, by default below ~/.config; empty where neither
/// variable is set.
[[nodiscard]] std::filesystem::path default_settings_path();

/// @param complaint  becomes what is wrong with the file, in one sentence; what is wrong in it
/// keeps its
///                   default
/// @return  defaults where there is no file
[[nodiscard]] Settings load_settings(const std::filesystem::path& path, std::string& complaint);

/// Makes the folder, too.
/// @return  what went wrong, in one sentence; empty if nothing
[[nodiscard]] std::string save_settings(const std::filesystem::path& path,
                                        const Settings& settings);

}  // namespace cholecystectomy
