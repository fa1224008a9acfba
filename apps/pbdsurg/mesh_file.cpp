// SPDX-License-Identifier: Apache-2.0
#include "apps/pbdsurg/mesh_file.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <sstream>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/pbdsurg/options.h"

namespace pbdsurg {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

bool has_size(const MeshFile& file) {
  return file.longest_side > 0 && std::isfinite(file.longest_side);
}

// The side in the unit of the file, as people find it there.
std::string describe_side(const NamedMesh& mesh) {
  std::ostringstream text;
  text << mesh.file.longest_side / mesh.file.metres_per_unit;
  return text.str();
}

std::string describe_organs() {
  return describe_length(kAnyOrgan.shortest) + " to " + describe_length(kAnyOrgan.longest);
}

// @param meshes  what was guessed from, in metres; not empty
std::string describe_ambiguity(std::span<const NamedMesh* const> meshes,
                               const std::vector<LengthUnit>& plausible) {
  const NamedMesh& first = *meshes.front();
  const std::string side = "the longest side of " + describe_side(first) + " is ";
  if (!plausible.empty()) {
    const std::string others =
        meshes.size() == 1 ? "" : " (one unit for all " + std::to_string(meshes.size()) + " files)";
    return first.path + ": " + side + describe_readings(first.file.longest_side, plausible) +
           ": give --unit" + others;
  }
  if (meshes.size() == 1) {
    return first.path + ": " + side + describe_readings(first.file.longest_side, kLengthUnits) +
           "; none is that of an organ (" + describe_organs() + "): give --unit or --scale";
  }
  const auto [least, most] =
      std::minmax_element(meshes.begin(), meshes.end(), [](const NamedMesh* a, const NamedMesh* b) {
        return a->file.longest_side < b->file.longest_side;
      });
  return "no unit makes all files organs (" + describe_organs() + "): the longest side of " +
         (*least)->path + " is " + describe_side(**least) + ", that of " + (*most)->path + ' ' +
         describe_side(**most) + "; give --unit or --scale, or name fewer files";
}

}  // namespace

NamedMesh read_named_mesh(const std::string& path, const UnitOptions& options) {
  return {path, read_mesh_file(path, options.read_options())};
}

void settle_unit(std::span<NamedMesh> meshes, const UnitOptions& options) {
  if (!options.is_guessed()) {
    return;
  }
  std::vector<NamedMesh*> unknown;
  std::vector<MeasuredLength> sides;
  for (NamedMesh& mesh : meshes) {
    if (!mesh.file.stated_unit && has_size(mesh.file)) {
      unknown.push_back(&mesh);
      sides.push_back({mesh.file.longest_side});
    }
  }
  if (unknown.empty()) {
    return;
  }
  const LengthUnitGuess guess = guess_length_unit(sides);
  if (guess.ambiguous()) {
    throw InvalidArgument(describe_ambiguity(unknown, guess.plausible));
  }
  for (NamedMesh* mesh : unknown) {
    set_unit(mesh->file, guess.unit);
    std::cerr << "pbdsurg: " << mesh->path << ": coordinates taken for " << name_of(guess.unit)
              << ": the longest side is then " << describe_length(mesh->file.longest_side)
              << "; --unit would say otherwise\n";
  }
}

MeshFile read_with_unit(const std::string& path, const UnitOptions& options) {
  NamedMesh mesh = read_named_mesh(path, options);
  settle_unit({&mesh, 1}, options);
  return std::move(mesh.file);
}

std::string size_remark(const MeshFile& file) {
  if (!has_size(file) || kAnyOrgan.contains(file.longest_side)) {
    return "";
  }
  const double side = file.longest_side / file.metres_per_unit;
  const LengthUnitGuess guess = guess_length_unit(side);
  const std::string advice =
      guess.plausible.empty()
          ? "is the unit right?"
          : "it would be " + describe_readings(side, guess.plausible) + ": see --unit";
  return "the longest side of " + describe_length(file.longest_side) +
         " is not that of an organ (" + describe_organs() + "); " + advice;
}

void check_is_not_input(const std::string& input, const std::string& output) {
  std::error_code error;
  if (std::filesystem::equivalent(input, output, error)) {
    throw InvalidArgument(output + ": is the mesh that is read; name another file to write");
  }
}

void print_losses(const std::string& path, const MeshData& mesh) {
  std::string extension = std::filesystem::path(path).extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (mesh.tets.empty() || (extension != ".stl" && extension != ".obj")) {
    return;
  }
  std::cerr << "pbdsurg: " << path << ": holds triangles alone: " << mesh.tets.size()
            << " tets are left out, "
            << (mesh.triangles.empty() ? "their boundary is written"
                                       : "the " + std::to_string(mesh.triangles.size()) +
                                             " triangles beside them are written")
            << '\n';
}

nlohmann::ordered_json to_json(const MeshFile& file, const MeshReport& report) {
  return {{"vertices", report.vertices},
          {"edges", report.edges},
          {"tets", report.tets},
          {"boundary_triangles", report.boundary_triangles},
          {"components", report.components},
          {"euler", report.euler},
          {"volume_m3", report.volume},
          {"min_dihedral_deg", report.min_dihedral * kDegrees},
          {"max_dihedral_deg", report.max_dihedral * kDegrees},
          {"inverted", report.inverted},
          {"unreferenced", report.unreferenced},
          {"max_tets_per_vertex", report.max_vertex_tets},
          {"format", file.format},
          {"unit", file.metres_per_unit == metres_per(file.unit)
                       ? nlohmann::ordered_json(name_of(file.unit))
                       : nlohmann::ordered_json(nullptr)},
          {"metres_per_unit", file.metres_per_unit},
          {"unit_ambiguous", file.unit_ambiguous()},
          {"longest_side_m", file.longest_side},
          {"triangles", report.triangles},
          {"boundary_vertices", report.boundary_vertices},
          {"shells", report.shells},
          {"closed", report.closed},
          {"area_m2", report.area},
          {"shortest_edge_m", report.shortest_edge},
          {"longest_edge_m", report.longest_edge},
          {"min_radius_ratio", report.min_radius_ratio},
          {"mean_radius_ratio", report.mean_radius_ratio},
          {"turned", report.turned}};
}

std::string to_text(const std::string& path, const MeshFile& file, const MeshReport& report) {
  std::ostringstream out;
  const bool surface = report.tets == 0;
  out << path << ": " << file.format << ", coordinates in " << describe_unit(file) << '\n'
      << "  vertices            " << report.vertices << " (" << report.boundary_vertices
      << " on the boundary), " << report.unreferenced << " points not in use\n"
      << "  edges               " << report.edges << ", " << report.shortest_edge * 1e3 << " to "
      << report.longest_edge * 1e3 << " mm\n"
      << "  tets                " << report.tets << '\n'
      << "  boundary triangles  " << report.boundary_triangles << ", " << report.area * 1e4
      << " cm^2" << (report.closed ? ", closed" : ", not closed") << '\n'
      << "  parts, shells       " << report.components << ", " << report.shells
      << "; Euler characteristic " << report.euler << '\n'
      << "  longest side        " << file.longest_side * 1e3 << " mm\n";
  if (!surface || report.closed) {
    out << "  volume              " << report.volume * 1e6 << " ml\n";
  }
  if (!surface) {
    out << "  dihedral angles     " << report.min_dihedral * kDegrees << " to "
        << report.max_dihedral * kDegrees << " degrees\n"
        << "  radius ratio        " << report.min_radius_ratio << " at least, "
        << report.mean_radius_ratio << " on average\n"
        << "  tets at a vertex    " << report.max_vertex_tets << " at most\n"
        << "  inverted, flat      " << report.inverted << ", " << report.flat << '\n';
  }
  return out.str();
}

}  // namespace pbdsurg
