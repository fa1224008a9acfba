// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the subcommands on mesh files share.

#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "pbdsurg/mesh/check.h"
#include "pbdsurg/mesh/read.h"

namespace pbdsurg {

/// Adds --unit auto|mm|cm|m; metres if it is not given.
void add_unit_option(CLI::App& command, LengthUnit& unit);

/// Reads a mesh and says on stderr which unit was guessed, if one was.
[[nodiscard]] MeshFile read_with_unit(const std::string& path, LengthUnit unit);

/// The report with the keys that scripts rely on, in a fixed order.
[[nodiscard]] nlohmann::ordered_json to_json(const MeshFile& file, const MeshReport& report);

/// The report for people: one line a quantity.
[[nodiscard]] std::string to_text(const std::string& path, const MeshFile& file,
                                  const MeshReport& report);

}  // namespace pbdsurg
