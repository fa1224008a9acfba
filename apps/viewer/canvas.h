// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Lines, rectangles and text on a white picture. Places are pixels from the top left.

#include <string>
#include <vector>

#include "apps/viewer/image.h"

namespace cholecystectomy {

inline constexpr Rgb8 kInk{40, 44, 52};

/// Height of one line of text at scale 1.
inline constexpr double kFontHeight = 7;

struct Point {
  double x, y;
};

/// Rectangles of a text at scale 1, with the origin at its top left. What is not printable ASCII is
/// '?'.
class Text {
 public:
  explicit Text(const std::string& text);

  struct Rectangle {
    Point low, high;
  };

  [[nodiscard]] double width() const { return width_; }
  [[nodiscard]] const std::vector<Rectangle>& rectangles() const { return rectangles_; }

 private:
  double width_;
  std::vector<Rectangle> rectangles_;
};

/// Draws with several samples a pixel; averaging them smooths edges.
class Canvas {
 public:
  Canvas(int width, int height);

  void fill(Point low, Point high, Rgb8 color);

  /// A line with round ends, cut off outside of the given rectangle.
  void line(Point a, Point b, double thickness, Rgb8 color, Point low, Point high);

  void text(const Text& text, Point origin, double scale, Rgb8 color);

  /// Text that runs upwards from the origin.
  void upward_text(const Text& text, Point origin, double scale, Rgb8 color);

  [[nodiscard]] Image image() const;

 private:
  [[nodiscard]] std::size_t index(int x, int y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
           static_cast<std::size_t>(x);
  }
  Rgb8& at(int x, int y) { return samples_[index(x, y)]; }
  [[nodiscard]] const Rgb8& at(int x, int y) const { return samples_[index(x, y)]; }

  int width_;   ///< samples
  int height_;  ///< samples
  std::vector<Rgb8> samples_;
};

}  // namespace cholecystectomy
