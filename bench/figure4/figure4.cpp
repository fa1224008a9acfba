// SPDX-License-Identifier: Apache-2.0
// Figure 4 of the paper: the temperature on the gallbladder's surface where the hook touches it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/montage.h"
#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#include "bench/figure4/burn.h"
#include "bench/figure4/legend.h"
#include "bench/figure4/picture.h"
#include "bench/support/program.h"

namespace pbdsurg::bench {
namespace {

using cholecystectomy::CaptionedImage;

constexpr std::array<double, 4> kTimes{0.1, 0.5, 1, 2};  // s
constexpr int kWidth = 480, kHeight = 360;               // pixels
constexpr double kWall = 2.7e-3;                         // m, as in the demo

Color flesh() {
  const Eigen::Vector3f& color = tissues::gallbladder_wall().look.color;
  return {color.x(), color.y(), color.z(), 1};
}

struct Row {
  std::string name;
  TexelColor color_of;
  Legend legend;
};

Row temperature_row() {
  return {"temperature",
          [](double temperature, const BurnMarks&) { return false_color(temperature); },
          {"temperature",
           37,
           100,
           false_color,
           {{37, "37 degC"}, {45, "45"}, {60, "60"}, {80, "80"}, {100, "100 and above"}}}};
}

Row color_row(ColorRule rule) {
  const TexelColor color_of = [rule](double temperature, const BurnMarks& marks) {
    return tissue_color(rule, flesh(), temperature, marks);
  };
  if (rule == ColorRule::temperature) {
    return {"equation 7",
            color_of,
            {"equation 7",
             37,
             110,
             [=](double temperature) { return color_of(temperature, {}); },
             {{37, "37 degC"}, {60, "60"}, {87.4, "87.4: k = 0.8"}, {99.4, "99.4: k = 0.99"}}}};
  }
  // one mark after the other
  const auto marks_at = [](double value) {
    const auto share = [&](double from) {
      return static_cast<float>(std::clamp(value - from, 0.0, 1.0));
    };
    return BurnMarks{share(0), share(1), share(2)};
  };
  return {"state",
          color_of,
          {"state of tissue",
           0,
           3,
           [=](double value) { return color_of(kBodyTemperature, marks_at(value)); },
           {{0, "as in life"}, {1, "coagulated"}, {2, "dried"}, {3, "charred"}}}};
}

std::string text(const char* format, double value) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

// One model in two rows of pictures, the first of the whole organ at the end.
void draw(const TetMesh& mesh, const Viewpoint& view, const BurnModel& model,
          cholecystectomy::OffscreenRenderer* renderer, std::ostream& table,
          std::vector<CaptionedImage>& pictures) {
  const std::array<Row, 2> rows{temperature_row(), color_row(model.cautery.model.color)};
  std::array<std::vector<CaptionedImage>, 2> drawn;
  Burn burn(mesh, view.tip, model);
  const auto add = [&](std::size_t row, const std::string& caption, bool is_close) {
    if (renderer != nullptr) {
      drawn[row].push_back(
          {caption, renderer->render(draw_burn(mesh, burn, view, is_close, rows[row].color_of))});
    }
  };
  for (const double time : kTimes) {
    burn.run_to(time);
    for (std::size_t row = 0; row < rows.size(); ++row) {
      add(row, text("%g s", time), true);
    }
    const auto temperatures = burn.field().temperatures();
    table << model.name << ',' << time << ',' << burn.report().power << ','
          << *std::ranges::max_element(temperatures);
    for (const double level : {45, 60, 100}) {
      table << ',' << 1e6 * surface_above(mesh, burn, level);
    }
    table << ',' << 1e9 * burn.removed_volume() << '\n';
  }
  for (std::size_t row = 0; row < rows.size(); ++row) {
    add(row, model.name + ": " + rows[row].name, false);
    if (renderer != nullptr) {
      std::ranges::rotate(drawn[row], drawn[row].end() - 1);
      drawn[row].push_back({"", draw_legend(rows[row].legend, kWidth, kHeight)});
      std::ranges::move(drawn[row], std::back_inserter(pictures));
    }
  }
}

void run(const std::filesystem::path& out, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  const TetMesh mesh = tetrahedralize(gallbladder_wall(kWall), options).mesh;
  const Viewpoint view = choose_viewpoint(mesh);
  std::printf("a gallbladder of %d tetrahedra\n", mesh.tet_count());
  std::optional<cholecystectomy::OffscreenRenderer> renderer;
  std::string reason;
  try {
    renderer.emplace(cholecystectomy::OffscreenOptions{.width = kWidth, .height = kHeight});
  } catch (const BackendUnavailable& error) {
    reason = error.what();
  }
  const std::filesystem::path path = out / "figure4.csv";
  std::ofstream table(path);
  table << "model,t_s,power_w,hottest_degc,mm2_above_45,mm2_above_60,mm2_above_100,removed_mm3\n";
  std::vector<CaptionedImage> pictures;
  for (const BurnModel& model : {physical_burn(), paper_burn()}) {
    draw(mesh, view, model, renderer ? &*renderer : nullptr, table, pictures);
  }
  table.close();
  if (!table) {
    throw FileError(path.string() + ": cannot be written");
  }
  if (renderer) {
    write_png(out / "figure4.png",
              cholecystectomy::make_montage(pictures, static_cast<int>(kTimes.size()) + 2));
    std::printf("wrote %s and %s\n", (out / "figure4.png").c_str(), path.c_str());
  } else {
    std::printf("wrote %s; no picture: %s\n", path.c_str(), reason.c_str());
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("Figure 4 of the paper: temperature where the hook touches the gallbladder.",
               "figure4");
  std::filesystem::path out = "out/tables";
  double spacing = 1;
  app.add_option("--spacing", spacing, "of the mesh, mm")
      ->check(CLI::Range(0.5, 2.4))
      ->capture_default_str();
  return pbdsurg::bench::run_program(app, argc, argv, out,
                                     [&] { pbdsurg::bench::run(out, 1e-3 * spacing); });
}
