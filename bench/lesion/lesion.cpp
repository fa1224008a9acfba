// SPDX-License-Identifier: Apache-2.0
// What a burn of liver leaves, on meshes of different sizes: means over places of the electrode.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "bench/lesion/measure.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

constexpr std::array kEdges{0.4e-3, 0.6e-3, 0.8e-3, 1.0e-3};  // m
constexpr std::array kPowers{10.0, 30.0, 50.0};               // W
constexpr double kAimedPower = 30;                            // W

// How far means on different edges may lie apart, as a share of their mean, and other limits.
constexpr double kDepthSpread = 0.1, kWidthSpread = 0.15, kRemovedSpread = 0.25;
constexpr double kHottest = 500;  // degrees Celsius
constexpr double kLedger = 1e-12;

// Mean over the places; of hottest and ledger the largest.
Lesion mean_lesion(const TetMesh& mesh, double edge, double power, int places) {
  Lesion mean;
  for (int place = 0; place < places; ++place) {
    const Lesion one = burn(mesh, edge, power, place * (kPlaces / places));
    mean.depth += one.depth / places;
    mean.width += one.width / places;
    mean.removed += one.removed / places;
    mean.hottest = std::max(mean.hottest, one.hottest);
    mean.ledger = std::max(mean.ledger, one.ledger);
  }
  return mean;
}

// Largest less smallest over the mean.
double spread(const std::vector<Lesion>& lesions, double Lesion::*part) {
  double low = lesions.front().*part, high = low, sum = 0;
  for (const Lesion& lesion : lesions) {
    low = std::min(low, lesion.*part);
    high = std::max(high, lesion.*part);
    sum += lesion.*part;
  }
  return sum > 0 ? (high - low) * static_cast<double>(lesions.size()) / sum : 0;
}

double largest(const std::vector<Lesion>& lesions, double Lesion::*part) {
  double most = 0;
  for (const Lesion& lesion : lesions) {
    most = std::max(most, lesion.*part);
  }
  return most;
}

std::string verdict_line(const char* what, double value, double limit) {
  std::array<char, 96> line;
  std::snprintf(line.data(), line.size(), "| %s | %.3g | %.3g | %s |\n", what, value, limit,
                value <= limit ? "met" : "missed");
  return line.data();
}

std::string verdicts(const std::vector<Lesion>& lesions) {
  return "\n30 W on all edges; how far they lie apart is relative to their mean:\n\n| | is | at "
         "most | |\n| --- | --- | --- | --- |\n" +
         verdict_line("depths apart", spread(lesions, &Lesion::depth), kDepthSpread) +
         verdict_line("widths apart", spread(lesions, &Lesion::width), kWidthSpread) +
         verdict_line("removed volumes apart", spread(lesions, &Lesion::removed), kRemovedSpread) +
         verdict_line("hottest, degrees Celsius", largest(lesions, &Lesion::hottest), kHottest) +
         verdict_line("the ledger lacks, of what came in", largest(lesions, &Lesion::ledger),
                      kLedger);
}

void run(const std::filesystem::path& out, bool quick) {
  const std::vector<Column> columns{{"edge_mm", "edge, mm", 1},
                                    {"depth_mm", "coagulated: mm deep", 2},
                                    {"width_mm", "mm wide", 2},
                                    {"removed_mm3", "removed, mm^3", 2},
                                    {"hottest_c", "hottest, degrees Celsius", 0}};
  Json rows = Json::array();
  std::string text =
      "# Lesions\n\n- liver, 1 s on 5 mm^2, a cutting wave; means over eight places of the "
      "electrode within a cell, of the hottest the largest\n\n" +
      markdown_header("W", columns);
  std::vector<Lesion> aimed;
  for (const double edge : kEdges) {
    if (quick && edge < 0.7e-3) {
      continue;
    }
    const TetMesh mesh = make_liver(edge);
    for (const double power : kPowers) {
      const Lesion mean = mean_lesion(mesh, edge, power, quick ? 2 : kPlaces);
      if (power == kAimedPower) {
        aimed.push_back(mean);
      }
      rows.push_back({{"power_w", power},
                      {"edge_mm", rounded(1e3 * edge, 1e3)},
                      {"depth_mm", rounded(1e3 * mean.depth, 1e3)},
                      {"width_mm", rounded(1e3 * mean.width, 1e3)},
                      {"removed_mm3", rounded(1e9 * mean.removed, 1e3)},
                      {"hottest_c", rounded(mean.hottest, 10)}});
      text += markdown_line(text_of(rows.back()["power_w"]), rows.back(), columns);
    }
  }
  text += verdicts(aimed);
  std::fputs(text.c_str(), stdout);
  write_table(out, "lesion", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("What a burn leaves, on meshes of different sizes.", "lesion");
  std::filesystem::path out = "out/tables";
  bool quick = false;
  app.add_flag("--quick", quick, "two places, edges of 0.8 and 1 mm: to see it work");
  return pbdsurg::bench::run_program(app, argc, argv, out,
                                     [&] { pbdsurg::bench::run(out, quick); });
}
