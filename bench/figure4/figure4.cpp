// SPDX-License-Identifier: Apache-2.0
// Figure 4 of the paper: the temperature on the gallbladder's surface where the hook touches it.
#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/anatomy/organs.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/tissue/library.h"

#include "apps/viewer/offscreen_renderer.h"
#include "apps/viewer/png.h"
#include "bench/figure4/burn.h"
#include "bench/figure4/picture.h"
#include "bench/support/program.h"
#include "bench/support/table_files.h"

namespace pbdsurg::bench {
namespace {

constexpr std::array<double, 4> kTimes{0.1, 0.5, 1, 2};  // s
constexpr double kWall = 2.7e-3;                         // m, as in the demo

Color flesh() {
  const Eigen::Vector3f& color = tissues::gallbladder_wall().look.color;
  return {color.x(), color.y(), color.z(), 1};
}

/// What the colours of a row of pictures mean: a scale from `low` to `high`.
struct Legend {
  struct Tick {
    double value;
    const char* label;
  };
  const char* title;  ///< without a comma, as labels
  double low, high;
  std::function<Color(double)> color_of;
  std::vector<Tick> ticks;
};

struct Row {
  std::string name;
  TexelColor color_of;
  Legend legend;
};

Row temperature_row() {
  return {"temperature",
          [](double temperature, const BurnMarks&) { return false_color(temperature); },
          {"temperature [°C]",
           37,
           100,
           false_color,
           {{37, "37"}, {45, "45"}, {60, "60"}, {80, "80"}, {100, "100 and above"}}}};
}

Row color_row(ColorRule rule) {
  const TexelColor color_of = [rule](double temperature, const BurnMarks& marks) {
    return tissue_color(rule, flesh(), temperature, marks);
  };
  if (rule == ColorRule::temperature) {
    return {"equation 7",
            color_of,
            {"equation 7 [°C]",
             37,
             110,
             [=](double temperature) { return color_of(temperature, {}); },
             {{37, "37"}, {60, "60"}, {87.4, "87.4: k = 0.8"}, {99.4, "99.4: k = 0.99"}}}};
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

/// The pictures of the figure and their legends, a line each; as scripts/plots reads them.
class Pictures {
 public:
  /// @throws BackendUnavailable  if this machine cannot draw
  explicit Pictures(std::filesystem::path folder)
      : folder_(std::move(folder)), renderer_({.width = 480, .height = 360}) {}

  void add(int row, int column, const std::string& file, const std::string& caption,
           const cholecystectomy::RenderSnapshot& snapshot) {
    write_png(folder_ / file, renderer_.render(snapshot));
    pictures_.push_back({{"figure", "figure4"},
                         {"row", row},
                         {"column", column},
                         {"picture", file},
                         {"caption", caption}});
  }

  void add_legend(int row, const Legend& legend) {
    const auto add_line = [&](double value, const char* label) {
      const Color color = legend.color_of(value);
      legends_.push_back({{"row", row},
                          {"title", legend.title},
                          {"value", value},
                          {"red", to_byte(color.red)},
                          {"green", to_byte(color.green)},
                          {"blue", to_byte(color.blue)},
                          {"label", label}});
    };
    for (int i = 0; i < kShades; ++i) {
      add_line(legend.low + (legend.high - legend.low) * (i + 0.5) / kShades, "");
    }
    for (const Legend::Tick& tick : legend.ticks) {
      add_line(tick.value, tick.label);
    }
  }

  void write_lists() const {
    write_text(folder_ / "figure4_pictures.csv", to_csv(pictures_));
    write_text(folder_ / "figure4_legends.csv", to_csv(legends_));
  }

 private:
  static constexpr int kShades = 256;

  std::filesystem::path folder_;
  cholecystectomy::OffscreenRenderer renderer_;
  Json pictures_ = Json::array(), legends_ = Json::array();
};

// One model in two rows of pictures, the first of the whole organ at the end.
void draw(const TetMesh& mesh, const Viewpoint& view, const BurnModel& model, int first_row,
          Pictures* pictures, std::ostream& table) {
  const std::array<Row, 2> rows{temperature_row(), color_row(model.cautery.model.color)};
  Burn burn(mesh, view.tip, model);
  const auto add = [&](int column, const std::string& moment, bool is_close) {
    for (int i = 0; pictures != nullptr && i < 2; ++i) {
      const std::string file = "figure4_" + model.name + (i == 0 ? "_temperature_" : "_color_") +
                               (is_close ? moment + "s" : moment) + ".png";
      const std::string caption = is_close ? moment + " s" : model.name + ": " + rows[i].name;
      pictures->add(first_row + i, column, file, caption,
                    draw_burn(mesh, burn, view, is_close, rows[i].color_of));
    }
  };
  int column = 0;
  for (const double time : kTimes) {
    burn.run_to(time);
    add(++column, text("%g", time), true);
    const auto temperatures = burn.field().temperatures();
    table << model.name << ',' << time << ',' << burn.report().power << ','
          << *std::ranges::max_element(temperatures);
    for (const double level : {45, 60, 100}) {
      table << ',' << 1e6 * surface_above(mesh, burn, level);
    }
    table << ',' << 1e9 * burn.removed_volume() << '\n';
  }
  add(0, "organ", false);
  for (int i = 0; pictures != nullptr && i < 2; ++i) {
    pictures->add_legend(first_row + i, rows[i].legend);
  }
}

void run(const std::filesystem::path& out, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  const TetMesh mesh = tetrahedralize(gallbladder_wall(kWall), options).mesh;
  const Viewpoint view = choose_viewpoint(mesh);
  std::printf("a gallbladder of %d tetrahedra\n", mesh.tet_count());
  std::optional<Pictures> pictures;
  std::string reason;
  try {
    pictures.emplace(out);
  } catch (const BackendUnavailable& error) {
    reason = error.what();
  }
  const std::filesystem::path path = out / "figure4.csv";
  std::ofstream table(path);
  table << "model,t_s,power_w,hottest_degc,mm2_above_45,mm2_above_60,mm2_above_100,removed_mm3\n";
  int row = 0;
  for (const BurnModel& model : {physical_burn(), paper_burn()}) {
    draw(mesh, view, model, row, pictures ? &*pictures : nullptr, table);
    row += 2;
  }
  table.close();
  if (!table) {
    throw FileError(path.string() + ": cannot be written");
  }
  if (pictures) {
    pictures->write_lists();
    std::printf("wrote %s and pictures\n", path.c_str());
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
