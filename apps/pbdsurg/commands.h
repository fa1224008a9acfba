// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The subcommands. Each function adds one to its parent; the subcommand runs while the command
/// line is parsed, and throws what main() reports with exit status 2.

namespace CLI {
class App;
}

namespace pbdsurg {

void add_mesh_info(CLI::App& mesh);

/// @param status  becomes 1 when a mesh has errors, 2 when one cannot be read; must outlive the
///                parsing
void add_mesh_check(CLI::App& mesh, int& status);

void add_mesh_convert(CLI::App& mesh);

void add_mesh_make(CLI::App& mesh);

/// @param status  becomes 1 when the colouring is not valid; must outlive the parsing
void add_color(CLI::App& app, int& status);

}  // namespace pbdsurg
