// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "apps/pbdsurg/commands.h"
#include "apps/pbdsurg/mesh_file.h"

namespace pbdsurg {
namespace {

struct InfoOptions {
  std::string path;
  UnitOptions unit;
  bool json = false;
};

void run(const InfoOptions& options) {
  const MeshFile file = read_with_unit(options.path, options.unit);
  const MeshReport report = check_mesh(file.mesh);
  if (options.json) {
    std::cout << to_json(file, report).dump(2) << '\n';
  } else {
    std::cout << to_text(options.path, file, report);
  }
}

}  // namespace

void add_mesh_info(CLI::App& mesh) {
  CLI::App& command = *mesh.add_subcommand("info", "Count and measure a mesh");
  const auto options = std::make_shared<InfoOptions>();
  command.add_option("file", options->path, "Mesh file")->required();
  add_unit_options(command, options->unit);
  command.add_flag("--json", options->json, "Print JSON");
  command.callback([options] { run(*options); });
}

}  // namespace pbdsurg
