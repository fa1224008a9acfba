// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <memory>

#include <CLI/CLI.hpp>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/write.h"

#include "apps/pbdsurg/commands.h"
#include "apps/pbdsurg/mesh_file.h"

namespace pbdsurg {
namespace {

struct ConvertOptions {
  std::string input;
  std::string output;
  UnitOptions unit;
  std::string version;
  bool ascii = false;
  bool binary = false;
  bool orient = false;
};

void run(const ConvertOptions& options) {
  check_is_not_input(options.input, options.output);
  MeshFile file = read_with_unit(options.input, options.unit);
  if (file.mesh.tets.empty() && file.mesh.triangles.empty()) {
    throw InvalidMesh(options.input +
                      ": has points but neither tetrahedra nor triangles; nothing is written");
  }
  if (options.orient && file.mesh.tets.empty()) {
    std::cerr << "pbdsurg: " << options.input << ": has no tets that --orient could turn\n";
  } else if (options.orient) {
    const Index swapped = orient_tets(file.mesh.points, file.mesh.tets);
    std::cout << options.input << ": " << swapped << " of " << file.mesh.tets.size()
              << " tets were inverted and are turned\n";
  } else if (const auto inverted = std::count_if(
                 file.mesh.tets.begin(), file.mesh.tets.end(),
                 [&](const Tet& tet) { return tet_volume(file.mesh.points, tet) < 0; });
             inverted > 0) {
    std::cerr << "pbdsurg: " << options.input << ": " << inverted << " of " << file.mesh.tets.size()
              << " tets are inverted; --orient would turn them\n";
  }
  WriteOptions write_options{options.version, {}};
  if (options.ascii || options.binary) {
    write_options.encoding = options.ascii ? MeshEncoding::ascii : MeshEncoding::binary;
  }
  write_mesh(options.output, file.mesh, write_options);
  print_losses(options.output, file.mesh);
}

}  // namespace

void add_mesh_convert(CLI::App& mesh) {
  CLI::App& command = *mesh.add_subcommand(
      "convert", "Write a mesh in metres in the format that the extension names");
  const auto options = std::make_shared<ConvertOptions>();
  command.add_option("input", options->input, "Mesh file")->required();
  command.add_option("output", options->output, "msh, vtk, vtu, stl or obj file")->required();
  add_unit_options(command, options->unit);
  command.add_option("--format-version", options->version, "msh: 2.2 (default) or 4.1");
  CLI::Option* ascii = command.add_flag("--ascii", options->ascii, "Write text");
  command.add_flag("--binary", options->binary, "Write binary (default where the format has it)")
      ->excludes(ascii);
  command.add_flag("--orient", options->orient, "Turn inverted tets, one by one");
  command.callback([options] { run(*options); });
}

}  // namespace pbdsurg
