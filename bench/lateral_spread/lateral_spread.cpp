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

#include "pbdsurg/surgery/cautery.h"

#include "support/meshes.h"
#include "viewer/plot.h"
#include "viewer/png.h"

namespace pbdsurg::bench {
namespace {

constexpr Index kCells = 28, kDepth = 14;
constexpr double kEdge = 0.75e-3;  // m
constexpr double kMiddle = kEdge * kCells / 2, kTop = kEdge * kDepth;

// How deep a condition holds, for each column of vertices: linear from the deepest one where it
// does to the next. The top itself may be cooler, under the metal.
template <class Value>
cholecystectomy::PlotSeries contour(const std::string& label, const TetMesh& mesh, double level,
                                    Value value) {
  cholecystectomy::PlotSeries line{label, {}, {}};
  const auto id = [](Index i, Index k) {
    return i + (kCells + 1) * (kCells / 2 + (kCells + 1) * k);
  };
  for (Index i = 0; i <= kCells; ++i) {
    Index k = 1;
    while (k <= kDepth && value(id(i, k)) < level) {
      ++k;
    }
    double depth = 0;
    if (k <= kDepth) {
      const double here = value(id(i, k)), below = value(id(i, k - 1));
      const double share = below < level ? (here - level) / (here - below) : 0;
      depth = kEdge * (kDepth - k + share);
    }
    line.x.push_back(1e3 * (mesh.positions()[id(i, kDepth)].x() - kMiddle));
    line.y.push_back(-1e3 * depth);
  }
  return line;
}

int run(double power, double seconds, double area, const char* path) {
  const TetMesh mesh = testing::make_box({kCells, kCells, kDepth}, kEdge);
  Scene scene;
  const ThermalBody body{scene.add_body("liver", mesh), &mesh, kLiver};
  Solver solver(scene);
  CauteryOptions options;
  options.contact_radius = std::sqrt(area / std::numbers::pi);
  Cautery cautery(solver, std::span(&body, 1), options);
  const Eigen::Vector3f tip = Eigen::Vector3d(kMiddle, kMiddle, kTop).cast<float>();
  constexpr double kStep = 10e-3;  // s
  for (int i = 0; i < std::lround(seconds / kStep); ++i) {
    cautery.update(solver, {tip, tip}, cut_settings(power), kStep);
  }
  const HeatField& field = cautery.field();
  cholecystectomy::Plot plot;
  plot.x_label = "distance from the axis [mm]";
  plot.y_label = "height [mm]";
  for (const int level : {45, 60, 80, 100}) {
    plot.series.push_back(contour("up to " + std::to_string(level) + " degC", mesh, level,
                                  [&](Index v) { return field.peak_temperatures()[v]; }));
  }
  plot.series.push_back(contour("coagulated", mesh, 1 - std::exp(-1),
                                [&](Index v) { return 1 - field.survival()[v]; }));
  const cholecystectomy::PlotSeries& coagulated = plot.series.back();
  const double depth = -*std::ranges::min_element(coagulated.y);
  double reach = 0;
  for (std::size_t i = 0; i < coagulated.x.size(); ++i) {
    reach = coagulated.y[i] < 0 ? std::max(reach, std::abs(coagulated.x[i])) : reach;
  }
  char title[160];
  std::snprintf(title, sizeof title, "%g W for %g s on %g mm2: coagulated %.1f mm deep, %.1f wide",
                power, seconds, 1e6 * area, depth, 2 * reach);
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
