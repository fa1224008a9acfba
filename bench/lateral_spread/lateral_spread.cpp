// SPDX-License-Identifier: Apache-2.0
// Draws how far heat has spread in liver: lateral_spread W s mm^2 FILE.png.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <numbers>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/plot.h"
#include "apps/viewer/png.h"
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

// The line in that plane along which a value passes a level, linear between vertices: a piece in
// each triangle, as which a cell counts twice.
template <class Value>
cholecystectomy::PlotSeries contour(const std::string& label, double level, Value value) {
  cholecystectomy::PlotSeries line{label, {}, {}};
  const auto add_triangle = [&](const std::array<std::array<Index, 2>, 3>& corners) {
    bool is_crossed = false;
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto [i, k] = corners[corner];
      const auto [i_next, k_next] = corners[(corner + 1) % 3];
      const double here = value(id_of(i, k)) - level;
      const double there = value(id_of(i_next, k_next)) - level;
      if ((here < 0) != (there < 0)) {
        const double share = here / (here - there);
        line.x.push_back(1e3 * (kEdge * (i + share * (i_next - i)) - kMiddle));
        line.y.push_back(1e3 * (kEdge * (k + share * (k_next - k)) - kTop));
        is_crossed = true;
      }
    }
    if (is_crossed) {
      line.x.push_back(std::nan(""));  // ends the piece
      line.y.push_back(std::nan(""));
    }
  };
  for (Index k = 0; k < kDepth; ++k) {
    for (Index i = 0; i < kCells; ++i) {
      add_triangle({{{i, k}, {i + 1, k}, {i + 1, k + 1}}});
      add_triangle({{{i, k}, {i + 1, k + 1}, {i, k + 1}}});
    }
  }
  return line;
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

// Largest |value| of those that are drawn.
double reach_of(const std::vector<double>& values) {
  double most = 0;
  for (const double value : values) {
    most = std::isnan(value) ? most : std::max(most, std::abs(value));
  }
  return most;
}

int run(double power, double seconds, double area, const char* path) {
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
  cholecystectomy::Plot plot;
  plot.x_label = "distance from the electrode's axis [mm]";
  plot.y_label = "height over the surface [mm]";
  plot.is_to_scale = true;
  plot.width = 1120;
  plot.height = 660;
  for (const int level : {45, 60, 80, 99}) {  // boiling tissue stays at 100
    plot.series.push_back(contour((level == 45 ? "reached " : "") + std::to_string(level) + " degC",
                                  level, [&](Index v) { return field.peak_temperatures()[v]; }));
  }
  plot.series.push_back(
      contour("coagulated", 1 - std::exp(-1), [&](Index v) { return 1 - field.survival()[v]; }));
  const double depth = reach_of(plot.series.back().y), reach = reach_of(plot.series.back().x);
  const std::vector<double> removed = removed_shares(solver);
  plot.series.push_back(contour("torn away", 0.5, [&](Index v) { return removed[v]; }));
  const double radius = 1e3 * options.contact_radius;
  plot.series.push_back({"electrode", {-radius, radius}, {0.1, 0.1}});
  char title[160];
  std::snprintf(title, sizeof title,
                "Liver after %g W for %g s on %g mm2: coagulated %.1f mm deep, %.1f mm wide", power,
                seconds, 1e6 * area, depth, 2 * reach);
  plot.title = title;
  cholecystectomy::write_png(path, cholecystectomy::plot_lines(plot));
  std::printf("%s; wrote %s\n", title, path);
  return 0;
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) try {
  if (argc != 5) {
    std::fprintf(stderr, "usage: lateral_spread W s mm^2 FILE.png\n");
    return 2;
  }
  return pbdsurg::bench::run(std::atof(argv[1]), std::atof(argv[2]), 1e-6 * std::atof(argv[3]),
                             argv[4]);
} catch (const std::exception& error) {
  std::fprintf(stderr, "lateral_spread: %s\n", error.what());
  return 2;
}
