// SPDX-License-Identifier: Apache-2.0
#include <iostream>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

#include "commands.h"
#include "mesh_file.h"

namespace pbdsurg {
namespace {

struct Options {
  std::vector<std::string> paths;
  LengthUnit unit = LengthUnit::metre;
  bool json = false;
};

nlohmann::ordered_json defects_json(const MeshReport& report) {
  nlohmann::ordered_json findings = nlohmann::ordered_json::array();
  for (const Finding& finding : report.findings) {
    findings.push_back({{"severity", name_of(finding.severity)}, {"text", finding.text}});
  }
  return {{"flat", report.flat},
          {"duplicate_points", report.duplicate_points},
          {"near_points", report.near_points},
          {"duplicate_tets", report.duplicate_tets},
          {"duplicate_triangles", report.duplicate_triangles},
          {"flat_triangles", report.flat_triangles},
          {"overfull_faces", report.overfull_faces},
          {"open_edges", report.open_edges},
          {"overshared_edges", report.overshared_edges},
          {"pinched_vertices", report.pinched_vertices},
          {"badly_wound_edges", report.badly_wound_edges},
          {"inside_out", report.inside_out},
          {"ok", !report.has_errors()},
          {"findings", findings}};
}

/// @return  whether no mesh has errors
bool run(const Options& options) {
  bool good = true;
  nlohmann::ordered_json all = nlohmann::ordered_json::array();
  for (const std::string& path : options.paths) {
    const MeshFile file = read_with_unit(path, options.unit);
    const MeshReport report = check_mesh(file.mesh);
    good = good && !report.has_errors();
    if (options.json) {
      nlohmann::ordered_json entry{{"file", path}};
      entry.update(to_json(file, report));
      entry.update(defects_json(report));
      all.push_back(entry);
      continue;
    }
    std::cout << to_text(path, file, report);
    for (const Finding& finding : report.findings) {
      std::cout << "  " << name_of(finding.severity) << ": " << finding.text << '\n';
    }
    if (report.findings.empty()) {
      std::cout << "  nothing to remark\n";
    }
  }
  if (options.json) {
    std::cout << (all.size() == 1 ? all.front() : all).dump(2) << '\n';
  }
  return good;
}

}  // namespace

void add_mesh_check(CLI::App& mesh, int& status) {
  CLI::App& command = *mesh.add_subcommand(
      "check", "Report all that is wrong with meshes; exit status 1 if one cannot be simulated");
  const auto options = std::make_shared<Options>();
  command.add_option("file", options->paths, "Mesh files")->required();
  add_unit_option(command, options->unit);
  command.add_flag("--json", options->json, "Print JSON: an object, or an array for several files");
  command.callback([options, &status] { status = run(*options) ? 0 : 1; });
}

}  // namespace pbdsurg
