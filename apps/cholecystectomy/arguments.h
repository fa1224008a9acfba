// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The command line of the demo.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "apps/cholecystectomy/organ_files.h"

namespace cholecystectomy {

struct Arguments {
  std::filesystem::path out = "out";
  OrganFiles organs;
  std::uint64_t seed = 1;
  double time_scale = 1;
  std::string executor = "best";
  bool paper = false;
  bool no_pictures = false;
  bool is_headless = false;
  bool is_rig_check = false;
  // of the window
  std::optional<Detail> detail;
  std::optional<std::filesystem::path> settings;
  std::int64_t pictures = 0;  ///< to end after; 0: none
  std::string devices = "mouse";
  bool is_recorded = false;
  // of virtual time
  bool is_virtual = false;
  double seconds = 0;  ///< 0: as long as the script
};

/// Reads the command line; prints the help where that is asked for.
/// @return  nothing after the help
/// @throws pbdsurg::InvalidArgument  naming the option and what it allows
std::optional<Arguments> parse_arguments(int argument_count, const char* const* values);

}  // namespace cholecystectomy
