// SPDX-License-Identifier: Apache-2.0
#include "mesh_file.h"

#include <iostream>
#include <numbers>
#include <sstream>

#include "options.h"

namespace pbdsurg {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

}  // namespace

void add_unit_option(CLI::App& command, LengthUnit& unit) {
  add_choice<LengthUnit>(command, "--unit", unit,
                         {{"auto", LengthUnit::automatic},
                          {"mm", LengthUnit::millimetre},
                          {"cm", LengthUnit::centimetre},
                          {"m", LengthUnit::metre}},
                         "Unit of the coordinates in the file (default: m)");
}

MeshFile read_with_unit(const std::string& path, LengthUnit unit) {
  MeshFile file = read_mesh_file(path, {unit});
  if (unit == LengthUnit::automatic) {
    std::cerr << "pbdsurg: " << path << ": coordinates taken for " << name_of(file.unit)
              << ": the longest side is then " << file.longest_side << " m"
              << (file.unit_ambiguous() ? "; this is ambiguous, --unit would settle it" : "")
              << '\n';
  }
  return file;
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
          {"unit", name_of(file.unit)},
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
  out << path << ": " << file.format << ", coordinates in " << name_of(file.unit) << '\n'
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
