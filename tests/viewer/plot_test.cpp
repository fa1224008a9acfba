// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/plot.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

constexpr Rgb8 kFirst{0, 114, 178};
constexpr Rgb8 kSecond{213, 94, 0};

struct Box {
  int low_x = std::numeric_limits<int>::max(), high_x = -1;
  int low_y = std::numeric_limits<int>::max(), high_y = -1;
  int count = 0;
};

/// Where a colour is, up to a difference that smoothed edges make.
Box find_color(const Image& image, Rgb8 color, int tolerance = 0) {
  const auto matches = [&](Rgb8 other) {
    return std::equal(color.begin(), color.end(), other.begin(),
                      [tolerance](int a, int b) { return std::abs(a - b) <= tolerance; });
  };
  Box box;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (matches(image.at(x, y))) {
        box.low_x = std::min(box.low_x, x);
        box.high_x = std::max(box.high_x, x);
        box.low_y = std::min(box.low_y, y);
        box.high_y = std::max(box.high_y, y);
        ++box.count;
      }
    }
  }
  return box;
}

}  // namespace

// Would catch a flipped axis, a scale that ignores the data and a curve that leaves the axes.
TEST_CASE("plot: a rising line runs from the lower left to the upper right", "[unit]") {
  Plot plot;
  plot.series = {{"force", {0, 10}, {0, 5}}};

  const Image image = plot_lines(plot);

  REQUIRE(image.width == plot.width);
  REQUIRE(image.rgb.size() == static_cast<std::size_t>(3 * plot.width * plot.height));
  const Box box = find_color(image, kFirst);
  CHECK(box.low_x < plot.width / 8);
  CHECK(box.high_x > plot.width * 7 / 8);
  CHECK(box.low_y < plot.height / 8);
  CHECK(box.high_y > plot.height * 3 / 4);
  const auto row_of = [&](int x) {
    for (int y = 0; y < image.height; ++y) {
      if (image.at(x, y) == kFirst) {
        return y;
      }
    }
    return -1;
  };
  CHECK(row_of(plot.width / 4) > row_of(3 * plot.width / 4));
}

TEST_CASE("plot: points that are not finite break the line and nothing else", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Plot plot;
  plot.series = {{"", {0, 1, 2, 3, 4}, {1, 1, nan, 1, 1}}, {"", {0, 4}, {0, 2}}};

  const Image image = plot_lines(plot);

  const Box box = find_color(image, kFirst);
  REQUIRE(box.count > 0);
  const int middle = (find_color(image, kSecond).low_x + find_color(image, kSecond).high_x) / 2;
  int in_gap = 0;
  for (int y = plot.height / 4; y < plot.height; ++y) {  // below the legend
    in_gap += image.at(middle, y) == kFirst ? 1 : 0;
  }
  CHECK(in_gap == 0);
}

// Would catch a division by an empty range, endless ticks and an overflow.
TEST_CASE("plot: odd ranges are drawn", "[unit]") {
  const double huge = std::numeric_limits<double>::max();
  const auto [low, high] =
      GENERATE(std::pair<double, double>{0, 0}, std::pair<double, double>{3, 3},
               std::pair<double, double>{-1e-9, 1e-9}, std::pair<double, double>{1e12, 1e12 + 1},
               std::pair<double, double>{-1e300, 1e300}, std::pair<double, double>{0, 5e-324});
  Plot plot;
  plot.series = {{"s", {low, high}, {low, high}}};
  CHECK(find_color(plot_lines(plot), kFirst, 60).count > 0);  // perhaps a mere dot
  plot.series = {{"s", {0, 1}, {-huge, huge}}};               // beyond what is drawn
  CHECK(find_color(plot_lines(plot), kFirst, 60).count == 0);
}

TEST_CASE("plot: no series gives empty axes, any text is drawn", "[unit]") {
  Plot plot;
  const Image bare = plot_lines(plot);
  plot.title = "caf\xc3\xa9 \x01";
  plot.x_label = "time [s]";
  const Image titled = plot_lines(plot);

  CHECK(find_color(bare, {255, 255, 255}).count > plot.width * plot.height / 2);
  CHECK(bare.rgb != titled.rgb);
}

TEST_CASE("plot: wrong input is refused", "[unit]") {
  Plot plot;
  plot.series = {{"force", {0, 1}, {0}}};
  CHECK_THROWS_WITH(plot_lines(plot), pbdsurg::testing::ContainsSubstring("'force'"));
  plot.series.clear();
  plot.width = 100;
  CHECK_THROWS_AS(plot_lines(plot), pbdsurg::InvalidArgument);
}

}  // namespace cholecystectomy
