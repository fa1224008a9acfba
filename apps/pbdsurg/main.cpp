// SPDX-License-Identifier: Apache-2.0
// The command-line tool: pbdsurg mesh info|check|convert|make, pbdsurg color.
#include <exception>
#include <iostream>

#include <CLI/CLI.hpp>

#include "commands.h"

int main(int argument_count, char** arguments) {
  CLI::App app("Real-time soft tissue for surgical simulators: tools", "pbdsurg");
  app.require_subcommand(1);
  CLI::App& mesh = *app.add_subcommand("mesh", "Examine, convert and make meshes");
  mesh.require_subcommand(1);
  int status = 0;
  pbdsurg::add_mesh_info(mesh);
  pbdsurg::add_mesh_check(mesh, status);
  pbdsurg::add_mesh_convert(mesh);
  pbdsurg::add_mesh_make(mesh);
  pbdsurg::add_color(app, status);
  try {
    app.parse(argument_count, arguments);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help
      return app.exit(error);
    }
    std::cerr << "pbdsurg: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "pbdsurg: " << error.what() << '\n';
    return 2;
  }
  return status;
}
