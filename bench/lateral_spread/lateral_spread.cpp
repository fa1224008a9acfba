// SPDX-License-Identifier: Apache-2.0
// How far heat has spread in liver, as lines of a section: lateral_spread W s mm^2 DIR.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr Index kCells = 28, kDepth = 14;
constexpr double kEdge = 0.75e-3;  // m
constexpr double kMiddle = kEdge * kCells / 2, kTop = kEdge * kDepth;

// Vertex (i, k) of the plane through the axis: column, row from below.
Index id_of(Index i, Index k) {
  return i + (kCells + 1) * (kCells / 2 + (kCells + 1) * k);
}

// A line in that plane, from the electrode's axis and over the surface, mm.
struct Segment {
  std::array<double, 2> from, to;
};

// Where a value passes a level, linear between vertices: a piece in each triangle, as which a cell
// counts twice.
template <class Value>
std::vector<Segment> contour(double level, Value value) {
  std::vector<Segment> segments;
  const auto add_triangle = [&](const std::array<std::array<Index, 2>, 3>& corners) {
    std::vector<std::array<double, 2>> ends;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto [i, k] = corners[corner];
      const auto [i_next, k_next] = corners[(corner + 1) % 3];
      const double here = value(id_of(i, k)) - level;
      const double there = value(id_of(i_next, k_next)) - level;
      if ((here < 0) != (there < 0)) {
        const double share = here / (here - there);
        ends.push_back({1e3 * (kEdge * (i + share * (i_next - i)) - kMiddle),
                        1e3 * (kEdge * (k + share * (k_next - k)) - kTop)});
      }
    }
    if (!ends.empty()) {
      segments.push_back({ends[0], ends[1]});
    }
  };
  for (Index k = 0; k < kDepth; ++k) {
    for (Index i = 0; i < kCells; ++i) {
      add_triangle({{{i, k}, {i + 1, k}, {i + 1, k + 1}}});
      add_triangle({{{i, k}, {i + 1, k + 1}, {i, k + 1}}});
    }
  }
  return segments;
}

// Share of the tetrahedra at each vertex that have gone. [vertex_count]
std::vector<double> removed_shares(const Solver& solver) {
  std::vector<double> all(static_cast<std::size_t>(solver.vertex_count())), gone(all.size());
  for (std::size_t t = 0; t < solver.tissue().tets().size(); ++t) {
    for (const Index v : solver.tissue().tets()[t]) {
      all[v] += 1;
      gone[v] += solver.tissue().is_tet_alive(static_cast<Index>(t)) ? 0 : 1;
    }
  }
  for (std::size_t v = 0; v < all.size(); ++v) {
    gone[v] /= std::max(1.0, all[v]);
  }
  return gone;
}

// How far segments go from the origin along an axis, mm.
double reach_of(const std::vector<Segment>& segments, std::size_t axis) {
  double most = 0;
  for (const Segment& segment : segments) {
    most = std::max({most, std::abs(segment.from[axis]), std::abs(segment.to[axis])});
  }
  return most;
}

int run(double power, double seconds, double area, const std::filesystem::path& folder) {
  const TetMesh mesh = testing::make_box({kCells, kCells, kDepth}, kEdge);
  Scene scene;
  const ThermalBody body{scene.add_body("liver", mesh), tissues::liver().heat};
  Solver solver(scene);
  CauteryOptions options;
  options.contact_radius = std::sqrt(area / std::numbers::pi);
  Cautery cautery(solver.tissue(), std::span(&body, 1), options);
  const Eigen::Vector3f tip = Eigen::Vector3d(kMiddle, kMiddle, kTop).cast<float>();
  constexpr double kStep = 10e-3;  // s
  for (int i = 0; i < std::lround(seconds / kStep); ++i) {
    cautery.update(solver, {tip, tip}, cut_settings(power), kStep);
  }
  const HeatField& field = cautery.field();
  const std::filesystem::path path = folder / "lateral_spread.csv";
  std::filesystem::create_directories(folder);
  std::ofstream table(path);
  table << "power_w,time_s,area_mm2,line,x1_mm,height1_mm,x2_mm,height2_mm\n";
  const auto add_line = [&](const std::string& name, const std::vector<Segment>& segments) {
    for (const auto& [from, to] : segments) {
      table << power << ',' << seconds << ',' << 1e6 * area << ',' << name << ',' << from[0] << ','
            << from[1] << ',' << to[0] << ',' << to[1] << '\n';
    }
  };
  for (const int level : {45, 60, 80, 99}) {  // boiling tissue stays at 100
    add_line(std::to_string(level) + " °C",
             contour(level, [&](Index v) { return field.peak_temperatures()[v]; }));
  }
  const std::vector<Segment> coagulated =
      contour(1 - std::exp(-1), [&](Index v) { return 1 - field.survival()[v]; });
  add_line("coagulated", coagulated);
  const std::vector<double> removed = removed_shares(solver);
  add_line("torn away", contour(0.5, [&](Index v) { return removed[v]; }));
  const double radius = 1e3 * options.contact_radius;
  add_line("electrode", {{{-radius, 0.1}, {radius, 0.1}}});
  table.close();
  if (!table) {
    throw FileError(path.string() + ": cannot be written");
  }
  std::printf(
      "Liver after %g W for %g s on %g mm2: coagulated %.1f mm deep, %.1f mm wide; wrote %s\n",
      power, seconds, 1e6 * area, reach_of(coagulated, 1), 2 * reach_of(coagulated, 0),
      path.c_str());
  return 0;
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) try {
  if (argc != 5) {
    std::fprintf(stderr, "usage: lateral_spread W s mm^2 DIR\n");
    return 2;
  }
  return pbdsurg::bench::run(std::atof(argv[1]), std::atof(argv[2]), 1e-6 * std::atof(argv[3]),
                             argv[4]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "lateral_spread: %s\n", error.what());
  return 2;
}
