// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "pbdsurg/base/error.h"

#include "apps/viewer/canvas.h"

namespace cholecystectomy {
namespace {

constexpr Rgb8 kGrid{226, 229, 234};

/// Told apart by colour-blind readers too (Okabe and Ito 2008, "Color universal design").
constexpr std::array<Rgb8, 7> kPalette{{{0, 114, 178},
                                        {213, 94, 0},
                                        {0, 158, 115},
                                        {204, 121, 167},
                                        {230, 159, 0},
                                        {86, 180, 233},
                                        {0, 0, 0}}};

/// Beyond this, the arithmetic of axes overflows; ranges below its inverse count as flat.
constexpr double kLargest = 1e300;

bool is_drawn(const PlotSeries& series, std::size_t i) {
  return std::abs(series.x[i]) <= kLargest && std::abs(series.y[i]) <= kLargest;  // false for NaN
}

/// Round numbers that enclose a range.
struct Axis {
  double first = 0;
  double step = 1;
  int count = 2;  ///< ticks

  [[nodiscard]] double last() const { return first + step * (count - 1); }
  [[nodiscard]] double tick(int i) const { return first + step * i; }
};

/// @param most  about how many ticks there is room for
Axis make_axis(double low, double high, int most) {
  if (!(low <= high)) {  // no finite point
    low = 0;
    high = 1;
  }
  // a flat curve, or a range that rounding would eat
  const double widest = std::max(std::abs(low), std::abs(high));
  if (!(high - low > std::max(1e-9 * widest, 1 / kLargest))) {
    const double margin = widest > 1 / kLargest ? 0.1 * widest : 0.5;
    low -= margin;
    high += margin;
  }
  const double rough = (high - low) / most;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double lead = rough / power;
  Axis axis;
  axis.step = power * (lead <= 1 ? 1 : lead <= 2 ? 2 : lead <= 5 ? 5 : 10);
  const double slack = 1e-6;  // of a step: keeps 0.30000000000000004 from opening another one
  const double start = std::floor(low / axis.step + slack);
  axis.first = start * axis.step;
  axis.count = static_cast<int>(std::ceil(high / axis.step - slack) - start) + 1;
  return axis;
}

std::string tick_label(const Axis& axis, int i) {
  double value = axis.tick(i);
  if (std::abs(value) < 1e-6 * axis.step) {
    value = 0;  // never "-0"
  }
  std::array<char, 32> text{};
  const double widest = std::max(std::abs(axis.first), std::abs(axis.last()));
  if (widest >= 1e5 || widest < 1e-3) {
    std::snprintf(text.data(), text.size(), "%.3g", value);
  } else {
    const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(axis.step) + 1e-9)));
    std::snprintf(text.data(), text.size(), "%.*f", decimals, value);
  }
  return text.data();
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

void check(const Plot& plot) {
  if (plot.width < 240 || plot.height < 160 || plot.width > 8192 || plot.height > 8192) {
    throw pbdsurg::InvalidArgument("a plot of " + std::to_string(plot.width) + " x " +
                                   std::to_string(plot.height) +
                                   " pixels was asked for; expected 240 x 160 to 8192 x 8192");
  }
  for (const PlotSeries& series : plot.series) {
    if (series.x.size() != series.y.size()) {
      throw pbdsurg::InvalidArgument(
          "series '" + series.label + "' has " + std::to_string(series.x.size()) + " x and " +
          std::to_string(series.y.size()) + " y values; expected the same number");
    }
  }
}

/// Where the parts of a plot lie, in pixels.
class Layout {
 public:
  explicit Layout(const Plot& plot) : plot_(plot), canvas_(plot.width, plot.height) {
    Range x, y;
    for (const PlotSeries& series : plot.series) {
      for (std::size_t i = 0; i < series.x.size(); ++i) {
        if (is_drawn(series, i)) {
          x.include(series.x[i]);
          y.include(series.y[i]);
        }
      }
    }
    x_axis_ = make_axis(x.low, x.high, std::max(3, plot.width / 110));
    y_axis_ = make_axis(y.low, y.high, std::max(3, plot.height / 70));
    double widest_tick = 0;
    for (int i = 0; i < y_axis_.count; ++i) {
      widest_tick = std::max(widest_tick, kFont * Text(tick_label(y_axis_, i)).width());
    }
    const bool titled = !plot.title.empty();
    const bool legend = plot.series.size() > 1;
    low_ = {20 + (plot.y_label.empty() ? 0 : 30) + widest_tick,
            16.0 + (titled ? 34 : 0) + (legend ? 28 : 0)};
    high_ = {plot.width - 30.0, plot.height - 34.0 - (plot.x_label.empty() ? 0 : 26)};
  }

  Image draw() {
    draw_axes();
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      draw_series(plot_.series[i], kPalette[i % kPalette.size()]);
    }
    draw_labels();
    if (plot_.series.size() > 1) {
      draw_legend();
    }
    return canvas_.image();
  }

 private:
  static constexpr double kFont = 1.7;
  static constexpr double kTitleFont = 2.2;
  static constexpr double kLineThickness = 2.2;

  [[nodiscard]] Point place(double x, double y) const {
    const double u = (x - x_axis_.first) / (x_axis_.last() - x_axis_.first);
    const double v = (y - y_axis_.first) / (y_axis_.last() - y_axis_.first);
    return {low_.x + u * (high_.x - low_.x), high_.y - v * (high_.y - low_.y)};
  }

  void draw_axes() {
    for (int i = 0; i < x_axis_.count; ++i) {
      const double x = place(x_axis_.tick(i), y_axis_.first).x;
      canvas_.fill({x - 0.5, low_.y}, {x + 0.5, high_.y}, kGrid);
      const Text label(tick_label(x_axis_, i));
      canvas_.fill({x - 0.5, high_.y}, {x + 0.5, high_.y + 5}, kInk);
      canvas_.text(label, {x - kFont * label.width() / 2, high_.y + 10}, kFont, kInk);
    }
    for (int i = 0; i < y_axis_.count; ++i) {
      const double y = place(x_axis_.first, y_axis_.tick(i)).y;
      canvas_.fill({low_.x, y - 0.5}, {high_.x, y + 0.5}, kGrid);
      const Text label(tick_label(y_axis_, i));
      canvas_.fill({low_.x - 5, y - 0.5}, {low_.x, y + 0.5}, kInk);
      canvas_.text(label, {low_.x - 10 - kFont * label.width(), y - kFont * kFontHeight / 2}, kFont,
                   kInk);
    }
    canvas_.fill({low_.x - 0.7, low_.y}, {low_.x + 0.7, high_.y}, kInk);
    canvas_.fill({low_.x, high_.y - 0.7}, {high_.x, high_.y + 0.7}, kInk);
  }

  void draw_series(const PlotSeries& series, Rgb8 color) {
    bool joined = false;
    Point previous{};
    for (std::size_t i = 0; i < series.x.size(); ++i) {
      if (!is_drawn(series, i)) {
        joined = false;
        continue;
      }
      const Point point = place(series.x[i], series.y[i]);
      // a point alone is drawn as a dot
      canvas_.line(joined ? previous : point, point, kLineThickness, color, low_,
                   {high_.x + kLineThickness, high_.y + kLineThickness});
      previous = point;
      joined = true;
    }
  }

  void draw_labels() {
    const Text title(plot_.title);
    canvas_.text(title, {(plot_.width - kTitleFont * title.width()) / 2, 16}, kTitleFont, kInk);
    const Text x_label(plot_.x_label);
    canvas_.text(x_label, {(low_.x + high_.x - kFont * x_label.width()) / 2, high_.y + 36}, kFont,
                 kInk);
    const Text y_label(plot_.y_label);
    canvas_.upward_text(y_label, {14, (low_.y + high_.y + kFont * y_label.width()) / 2}, kFont,
                        kInk);
  }

  /// One row above the axes, where it hides no curve.
  void draw_legend() {
    double x = low_.x + 4;
    const double y = low_.y - 22;
    for (std::size_t i = 0; i < plot_.series.size(); ++i) {
      const Text label(plot_.series[i].label);
      const double middle = y + kFont * kFontHeight / 2 - 1;
      canvas_.fill({x, middle - 1.5}, {x + 24, middle + 1.5}, kPalette[i % kPalette.size()]);
      canvas_.text(label, {x + 31, y}, kFont, kInk);
      x += 31 + kFont * label.width() + 24;
    }
  }

  const Plot& plot_;
  Canvas canvas_;
  Axis x_axis_;
  Axis y_axis_;
  Point low_{};   ///< top left of the axes
  Point high_{};  ///< bottom right
};

}  // namespace

Image plot_lines(const Plot& plot) {
  check(plot);
  return Layout(plot).draw();
}

}  // namespace cholecystectomy
