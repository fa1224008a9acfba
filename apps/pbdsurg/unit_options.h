// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What --unit and --scale say of the coordinates in files, in every program.

#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/mesh/length_unit.h"
#include "pbdsurg/mesh/read.h"

#include "apps/pbdsurg/options.h"

namespace pbdsurg {

struct UnitOptions {
  LengthUnit unit = LengthUnit::automatic;
  double scale = 0;  ///< metres in one unit, in place of a unit that has a name; 0: not given

  [[nodiscard]] bool is_guessed() const { return scale == 0 && unit == LengthUnit::automatic; }

  /// For reading one file; in metres, for set_unit(), where the unit is to be guessed.
  [[nodiscard]] ReadOptions read_options() const {
    ReadOptions options;
    if (scale > 0) {
      options.scale = scale;
    } else if (!is_guessed()) {
      options.unit = unit;
    }
    return options;
  }
};

/// Adds --unit auto|mm|cm|dm|m and --scale FACTOR, which exclude each other.
/// @param options  must outlive the parsing
inline void add_unit_options(CLI::App& command, UnitOptions& options) {
  std::vector<std::pair<std::string, LengthUnit>> choices{{"auto", LengthUnit::automatic}};
  for (const LengthUnit unit : kLengthUnits) {
    choices.emplace_back(name_of(unit), unit);
  }
  CLI::Option* unit =
      add_choice(command, "--unit", options.unit, choices,
                 "Unit of the coordinates in a file; auto (default): what the file states, or the "
                 "one that makes it as large as an organ",
                 "; of any other unit, --scale says the metres (an inch: 0.0254)");
  add_positive_number(command, "--scale", options.scale, "Metres in one unit, in place of --unit")
      ->excludes(unit);
}

/// "mm", or "units of 0.0254 m".
inline std::string describe_unit(const MeshFile& file) {
  if (file.metres_per_unit == metres_per(file.unit)) {
    return name_of(file.unit);
  }
  std::ostringstream text;
  text << "units of " << file.metres_per_unit << " m";
  return text.str();
}

}  // namespace pbdsurg
