// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <iostream>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>

#include "pbdsurg/base/error.h"

#include "apps/pbdsurg/commands.h"
#include "apps/pbdsurg/mesh_file.h"

namespace pbdsurg {
namespace {

struct CheckOptions {
  std::vector<std::string> paths;
  UnitOptions unit;
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
          {"self_crossings", report.self_crossings},
          {"welded_open_edges", report.welded_open_edges},
          {"welded_components", report.welded_components},
          {"ok", !report.has_errors()},
          {"findings", findings},
          {"checked", report.checked},
          {"not_checked", report.not_checked}};
}

void print_list(const char* title, const std::vector<std::string>& items) {
  const char* separator = title;
  for (const std::string& item : items) {
    std::cout << separator << item;
    separator = "; ";
  }
  std::cout << (items.empty() ? "" : "\n");
}

// What the tool knows and check_mesh() does not: the unit, and how to repair.
void add_findings(MeshReport& report, const MeshFile& file) {
  if (std::string remark = size_remark(file); !remark.empty()) {
    const auto notes = std::find_if(report.findings.begin(), report.findings.end(),
                                    [](const Finding& f) { return f.severity == Severity::note; });
    report.findings.insert(notes, {Severity::warning, std::move(remark)});
  }
  if (report.inverted > 0) {
    report.findings.push_back(
        {Severity::note, "pbdsurg mesh convert IN OUT --orient turns inverted tets one by one"});
  }
}

void print_text(const NamedMesh& mesh, const MeshReport& report) {
  std::cout << to_text(mesh.path, mesh.file, report);
  for (const Finding& finding : report.findings) {
    std::cout << "  " << name_of(finding.severity) << ": " << finding.text << '\n';
  }
  if (report.findings.empty()) {
    std::cout << "  nothing to remark\n";
  }
  print_list("  checked: ", report.checked);
  print_list("  not checked: ", report.not_checked);
}

/// @return  the exit status: 2 if a file cannot be read, else 1 if a mesh has errors
int run(const CheckOptions& options) {
  int status = 0;
  std::vector<NamedMesh> meshes;
  std::map<std::string, nlohmann::ordered_json> entries;  // by path
  for (const std::string& path : options.paths) {
    try {
      meshes.push_back(read_named_mesh(path, options.unit));
    } catch (const Error& error) {
      std::cerr << "pbdsurg: " << error.what() << '\n';
      entries[path] = {{"file", path}, {"ok", false}, {"error", error.what()}};
      status = 2;
    }
  }
  settle_unit(meshes, options.unit);
  for (const NamedMesh& mesh : meshes) {
    MeshReport report = check_mesh(mesh.file.mesh);
    add_findings(report, mesh.file);
    if (report.has_errors()) {
      status = std::max(status, 1);
    }
    if (options.json) {
      nlohmann::ordered_json entry{{"file", mesh.path}};
      entry.update(to_json(mesh.file, report));
      entry.update(defects_json(report));
      entries[mesh.path] = std::move(entry);
    } else {
      print_text(mesh, report);
    }
  }
  if (options.json) {
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    for (const std::string& path : options.paths) {
      all.push_back(entries.at(path));
    }
    std::cout << (all.size() == 1 ? all.front() : all).dump(2) << '\n';
  }
  return status;
}

}  // namespace

void add_mesh_check(CLI::App& mesh, int& status) {
  CLI::App& command = *mesh.add_subcommand(
      "check",
      "Report all that is wrong with meshes; exit status 1 if one cannot be simulated, 2 if one "
      "cannot be read");
  const auto options = std::make_shared<CheckOptions>();
  command.add_option("file", options->paths, "Mesh files")->required();
  add_unit_options(command, options->unit);
  command.add_flag("--json", options->json, "Print JSON: an object, or an array for several files");
  command.callback([options, &status] { status = run(*options); });
}

}  // namespace pbdsurg
