// SPDX-License-Identifier: Apache-2.0
// The command-line tool: pbdsurg mesh info|check|convert|make, pbdsurg color.
#include <exception>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/base/version.h"

#include "apps/pbdsurg/commands.h"

namespace {

/// Why no subcommand was found where one is needed; empty if none is needed.
std::string subcommand_problem(const CLI::App& app) {
  const CLI::App* last = &app;
  while (!last->get_subcommands().empty()) {
    last = last->get_subcommands().front();
  }
  std::string known;
  for (const CLI::App* subcommand : last->get_subcommands([](const CLI::App*) { return true; })) {
    known += (known.empty() ? "" : ", ") + subcommand->get_name();
  }
  const std::vector<std::string> unknown = last->remaining();
  if (known.empty()) {
    return "";
  }
  const std::string kind =
      !unknown.empty() && unknown.front().starts_with('-') ? "option" : "subcommand";
  return (unknown.empty() ? "a subcommand is missing"
                          : "there is no " + kind + " '" + unknown.front() + "'") +
         "; the subcommands of " + last->get_name() + " are " + known;
}

}  // namespace

int main(int argument_count, char** arguments) {
  CLI::App app("Real-time soft tissue for surgical simulators: tools", "pbdsurg");
  app.set_version_flag("--version", std::string("pbdsurg ") + pbdsurg::build_id());
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
  } catch (const CLI::RequiredError& error) {
    const std::string problem = subcommand_problem(app);
    std::cerr << "pbdsurg: " << (problem.empty() ? error.what() : problem) << '\n';
    return 2;
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // --help, --version
      return app.exit(error);
    }
    std::cerr << "pbdsurg: " << error.what() << '\n';
    return 2;
  } catch (const std::exception& error) {
    std::cerr << "pbdsurg: " << error.what() << '\n';
    return 2;
  }
  std::cout.flush();
  if (!std::cout) {
    std::cerr << "pbdsurg: the standard output cannot be written\n";
    return 2;
  }
  return status;
}
