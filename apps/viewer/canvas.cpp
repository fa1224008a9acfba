// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/canvas.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>

#include <stb_easy_font.h>

namespace cholecystectomy {
namespace {

constexpr int kScale = 3;  // samples along each side of a pixel

constexpr Rgb8 kWhite{255, 255, 255};

std::string printable(const std::string& text) {
  std::string result = text;
  std::replace_if(
      result.begin(), result.end(), [](char c) { return c < 32 || c > 126; }, '?');
  return result;
}

int sample(double pixel, int count) {
  return static_cast<int>(std::clamp(std::round(pixel * kScale), 0.0, static_cast<double>(count)));
}

}  // namespace

Text::Text(const std::string& text) {
  std::string copy = printable(text);
  width_ = stb_easy_font_width(copy.data());
  std::vector<char> buffer(64 + 64 * 16 * copy.size());  // at most 16 quads a letter are drawn
  const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, buffer.data(),
                                        static_cast<int>(buffer.size()));
  for (int i = 0; i < quads; ++i) {
    const char* quad = buffer.data() + 64 * static_cast<std::size_t>(i);
    std::array<float, 2> low{}, high{};
    std::memcpy(low.data(), quad, sizeof(low));
    std::memcpy(high.data(), quad + 32, sizeof(high));
    rectangles_.push_back({{low[0], low[1]}, {high[0], high[1]}});
  }
}

Canvas::Canvas(int width, int height)
    : width_(width * kScale),
      height_(height * kScale),
      samples_(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_), kWhite) {}

void Canvas::fill(Point low, Point high, Rgb8 color) {
  const int y_end = sample(high.y, height_);
  const int x_end = sample(high.x, width_);
  for (int y = sample(low.y, height_); y < y_end; ++y) {
    for (int x = sample(low.x, width_); x < x_end; ++x) {
      at(x, y) = color;
    }
  }
}

void Canvas::line(Point a, Point b, double thickness, Rgb8 color, Point low, Point high) {
  const double radius = thickness / 2;
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double squared = dx * dx + dy * dy;
  const int y_end = sample(std::min(high.y, std::max(a.y, b.y) + radius + 1), height_);
  const int x_end = sample(std::min(high.x, std::max(a.x, b.x) + radius + 1), width_);
  for (int y = sample(std::max(low.y, std::min(a.y, b.y) - radius), height_); y < y_end; ++y) {
    for (int x = sample(std::max(low.x, std::min(a.x, b.x) - radius), width_); x < x_end; ++x) {
      const double px = (x + 0.5) / kScale - a.x;
      const double py = (y + 0.5) / kScale - a.y;
      const double t = squared > 0 ? std::clamp((px * dx + py * dy) / squared, 0.0, 1.0) : 0;
      if (std::hypot(px - t * dx, py - t * dy) <= radius) {
        at(x, y) = color;
      }
    }
  }
}

void Canvas::text(const Text& text, Point origin, double scale, Rgb8 color) {
  for (const Text::Rectangle& r : text.rectangles()) {
    fill({origin.x + scale * r.low.x, origin.y + scale * r.low.y},
         {origin.x + scale * r.high.x, origin.y + scale * r.high.y}, color);
  }
}

void Canvas::upward_text(const Text& text, Point origin, double scale, Rgb8 color) {
  for (const Text::Rectangle& r : text.rectangles()) {
    fill({origin.x + scale * r.low.y, origin.y - scale * r.high.x},
         {origin.x + scale * r.high.y, origin.y - scale * r.low.x}, color);
  }
}

Image Canvas::image() const {
  Image image{width_ / kScale, height_ / kScale, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      std::array<int, 3> sum{};
      for (int i = 0; i < kScale * kScale; ++i) {
        const Rgb8& color = at(x * kScale + i % kScale, y * kScale + i / kScale);
        for (std::size_t c = 0; c < 3; ++c) {
          sum[c] += color[c];
        }
      }
      for (const int s : sum) {
        image.rgb.push_back(static_cast<std::uint8_t>(s / (kScale * kScale)));
      }
    }
  }
  return image;
}

}  // namespace cholecystectomy
