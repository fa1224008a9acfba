// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <iostream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <CLI/CLI.hpp>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/mesh/write.h"

#include "apps/pbdsurg/commands.h"
#include "apps/pbdsurg/mesh_file.h"
#include "apps/pbdsurg/options.h"

namespace pbdsurg {
namespace {

constexpr double kMillimetre = 1e-3;
constexpr std::string_view kTable2Prefix = "table2:";

struct MakeOptions {
  std::string what;
  std::string output;
  Index vertex_count = 0;
  double spacing_mm = 0;
  Table2Kind kind = Table2Kind::hollow;
  bool has_kind = false;
  UnitOptions unit;
  bool has_unit = false;  // --unit or --scale
  bool json = false;
};

struct Made {
  TetMesh mesh;
  std::optional<TetrahedralizeReport> report;  // none for table 2
  std::optional<MeshReport> surface;           // that was filled, of a file
};

// What is asked for on the command line replaces the recipe's resolution.
void apply_resolution(const MakeOptions& options, TetrahedralizeOptions& recipe) {
  if (options.vertex_count > 0 || options.spacing_mm > 0) {
    recipe.vertex_count = options.vertex_count;
    recipe.spacing = kMillimetre * options.spacing_mm;
  }
}

Made make_table2(const MakeOptions& options) {
  const std::string_view row = std::string_view(options.what).substr(kTable2Prefix.size());
  int number = 0;
  const auto [end, error] = std::from_chars(row.data(), row.data() + row.size(), number);
  if (error != std::errc() || end != row.data() + row.size()) {
    throw InvalidArgument("'" + options.what + "' names no row of table 2; they are table2:1 to " +
                          "table2:5");
  }
  if (options.vertex_count > 0 || options.spacing_mm > 0) {
    throw InvalidArgument("a row of table 2 has its own size; leave out --vertices and --spacing");
  }
  return {table2_mesh(number, options.kind), {}, {}};
}

// The surface that tetrahedralize() fills, or the boundary of tetrahedra, by itself.
MeshReport check_surface(const MeshData& mesh) {
  MeshData surface{mesh.points, {}, mesh.triangles};
  if (surface.triangles.empty()) {
    for (const BoundaryTriangle& triangle : find_boundary(mesh.tets)) {
      surface.triangles.push_back(triangle.vertices);
    }
  }
  return check_mesh(surface);
}

Made make_from_file(const MakeOptions& options) {
  TetrahedralizeOptions recipe;
  recipe.vertex_count = 10'000;
  apply_resolution(options, recipe);
  check_is_not_input(options.what, options.output);
  MeshFile file = read_with_unit(options.what, options.unit);
  if (!file.mesh.tets.empty()) {
    file.mesh.triangles.clear();  // a surface beside tetrahedra is theirs
  }
  if (const std::string remark = size_remark(file); !remark.empty()) {
    std::cerr << "pbdsurg: " << options.what << ": " << remark << '\n';
  }
  try {
    Tetrahedralization result = tetrahedralize(file.mesh, recipe);
    return {std::move(result.mesh), result.report, check_surface(file.mesh)};
  } catch (const InvalidMesh& error) {
    throw InvalidMesh(options.what + ": " + error.what());
  } catch (const InvalidArgument& error) {  // of the lattice that the resolution takes
    throw InvalidArgument(options.what + ": " + error.what());
  }
}

Made make(const MakeOptions& options) {
  const auto organ = std::find_if(kOrgans.begin(), kOrgans.end(),
                                  [&](Organ o) { return options.what == name_of(o); });
  const bool from_file = organ == kOrgans.end() && !options.what.starts_with(kTable2Prefix);
  if (options.has_unit && !from_file) {
    throw InvalidArgument("--unit and --scale are for surface files only");
  }
  if (options.what.starts_with(kTable2Prefix)) {
    return make_table2(options);
  }
  if (options.has_kind) {
    throw InvalidArgument("--kind is for the rows of table 2 only");
  }
  if (from_file) {
    return make_from_file(options);
  }
  OrganRecipe recipe = organ_recipe(*organ);
  apply_resolution(options, recipe.options);
  Tetrahedralization result = tetrahedralize(recipe.shape, recipe.options);
  return {std::move(result.mesh), result.report, {}};
}

std::string describe_topology(const MeshReport& surface) {
  const auto count = [](Index number, const std::string& what) {
    return std::to_string(number) + ' ' + what + (number == 1 ? "" : "s");
  };
  if (!surface.closed || surface.pinched_vertices > 0) {  // no handles to count
    return count(surface.components, "part") + " of Euler characteristic " +
           std::to_string(surface.euler);
  }
  return count(surface.shells, "shell") + " with " +
         count(surface.shells - surface.euler / 2, "handle");
}

// What filling made of a surface.
void print_topology(const std::string& path, const MeshReport& surface,
                    const MeshReport& boundary) {
  if (surface.open_edges > 0) {
    std::cerr << "pbdsurg: " << path << ": the surface is not closed: it has " << surface.open_edges
              << " open edges, whose gaps were filled over\n";
  }
  if (surface.shells != boundary.shells || surface.euler != boundary.euler) {
    std::cerr << "pbdsurg: " << path << ": the topology has changed: of the surface, "
              << describe_topology(surface) << "; of the tets' boundary, "
              << describe_topology(boundary);
    if (boundary.shells > 1) {
      std::cerr << ", " << boundary.shells - 1 << " of them around voids";
    }
    std::cerr << '\n';
  }
}

nlohmann::ordered_json topology_json(const MeshReport& surface) {
  return {{"shells", surface.shells}, {"euler", surface.euler}, {"open_edges", surface.open_edges}};
}

// What is unusual about the mesh, for people.
void print_remarks(const MakeOptions& options, const TetrahedralizeReport& report) {
  if (report.pieces > 1) {
    std::cerr << "pbdsurg: " << options.what << ": the largest of " << report.pieces
              << " pieces is kept; " << report.dropped_tets << " tets are dropped\n";
  }
  if (report.bridges > 0) {
    std::cerr << "pbdsurg: " << options.what << ": thickened at " << report.bridges
              << " spots where it was pinched\n";
  }
  if (report.thin_share > 0.02) {
    std::cerr << "pbdsurg: " << options.what << ": " << 100 * report.thin_share
              << " % of the surface lies over parts too thin for a spacing of "
              << report.spacing / kMillimetre << " mm; details there may be lost\n";
  }
}

void run(const MakeOptions& options) {
  const Made made = make(options);
  MeshFile file;
  file.format = "made by pbdsurg";
  file.mesh.points.assign(made.mesh.positions().begin(), made.mesh.positions().end());
  file.mesh.tets.assign(made.mesh.tets().begin(), made.mesh.tets().end());
  file.longest_side = bounding_box(made.mesh).sizes().maxCoeff();
  write_mesh(options.output, file.mesh);
  print_losses(options.output, file.mesh);
  if (made.report) {
    print_remarks(options, *made.report);
  }
  std::optional<MeshReport> boundary;
  if (made.surface) {
    boundary = check_surface(file.mesh);
    print_topology(options.what, *made.surface, *boundary);
  }
  const MeshReport report = check_mesh(file.mesh);
  if (!options.json) {
    std::cout << to_text(options.output, file, report);
    return;
  }
  nlohmann::ordered_json json = to_json(file, report);
  if (made.report) {
    json["spacing_m"] = made.report->spacing;
    json["meshes_made"] = made.report->meshes_made;
    json["pieces"] = made.report->pieces;
    json["dropped_tets"] = made.report->dropped_tets;
    json["bridges"] = made.report->bridges;
    json["thin_share"] = made.report->thin_share;
  } else {
    json["kind"] = options.kind == Table2Kind::hollow ? "hollow" : "surface_filled";
  }
  if (made.surface) {
    json["surface"] = topology_json(*made.surface);
    json["boundary"] = topology_json(*boundary);
  }
  std::cout << json.dump(2) << '\n';
}

std::string organ_names() {
  std::string names;
  for (const Organ organ : kOrgans) {
    names += std::string(name_of(organ)) + ", ";
  }
  return names;
}

}  // namespace

void add_mesh_make(CLI::App& mesh) {
  CLI::App& command = *mesh.add_subcommand("make", "Make a mesh of tetrahedra");
  const auto options = std::make_shared<MakeOptions>();
  command
      .add_option("what", options->what,
                  organ_names() + "table2:1 to table2:5, or a surface file to fill")
      ->required();
  command.add_option("output", options->output, "msh, vtk, vtu, stl or obj file")->required();
  add_whole_number(command, "--vertices", options->vertex_count, 1,
                   "Wanted number of vertices (default for files: 10000)");
  add_positive_number(command, "--spacing", options->spacing_mm, "Lattice cell in mm");
  CLI::Option* kind = add_choice<Table2Kind>(
      command, "--kind", options->kind,
      {{"hollow", Table2Kind::hollow}, {"surface_filled", Table2Kind::surface_filled}},
      "Of a row of table 2");
  add_unit_options(command, options->unit);
  command.add_flag("--json", options->json, "Print JSON");
  command.callback([options, kind, &command] {
    options->has_kind = kind->count() > 0;
    options->has_unit = command.count("--unit") + command.count("--scale") > 0;
    run(*options);
  });
}

}  // namespace pbdsurg
