// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/montage.h"

#include <algorithm>
#include <cstddef>

#include "pbdsurg/base/error.h"

#include "apps/viewer/canvas.h"

namespace cholecystectomy {
namespace {

constexpr double kFont = 3.6;
constexpr int kCaptionHeight = 56;  // pixels

Image draw_caption(const std::string& caption, int width) {
  Canvas canvas(width, kCaptionHeight);
  const Text text(caption);
  canvas.text(text, {(width - kFont * text.width()) / 2, 6}, kFont, kInk);
  return canvas.image();
}

void paste(const Image& part, int left, int top, Image& whole) {
  const auto row = [](const Image& image, int x, int y) {
    return 3 * (static_cast<std::ptrdiff_t>(y) * image.width + x);
  };
  for (int y = 0; y < part.height; ++y) {
    std::copy_n(part.rgb.begin() + row(part, 0, y), 3 * part.width,
                whole.rgb.begin() + row(whole, left, top + y));
  }
}

}  // namespace

Image make_montage(std::span<const CaptionedImage> pictures, int columns) {
  if (pictures.empty() || columns < 1) {
    throw pbdsurg::InvalidArgument("a montage of " + std::to_string(pictures.size()) +
                                   " pictures in " + std::to_string(columns) +
                                   " columns was asked for; it needs at least one of each");
  }
  const int width = pictures[0].image.width;
  const int height = pictures[0].image.height;
  const int count = static_cast<int>(pictures.size());
  const int rows = (count + columns - 1) / columns;
  Image montage{columns * width, rows * (height + kCaptionHeight), {}};
  montage.rgb.assign(
      3 * static_cast<std::size_t>(montage.width) * static_cast<std::size_t>(montage.height), 255);
  for (int i = 0; i < count; ++i) {
    const CaptionedImage& picture = pictures[i];
    if (picture.image.width != width || picture.image.height != height) {
      throw pbdsurg::InvalidArgument(
          "picture '" + picture.caption + "' is " + std::to_string(picture.image.width) + " x " +
          std::to_string(picture.image.height) + " pixels, the first " + std::to_string(width) +
          " x " + std::to_string(height) + "; a montage needs pictures of one size");
    }
    const int left = i % columns * width;
    const int top = i / columns * (height + kCaptionHeight);
    paste(picture.image, left, top, montage);
    paste(draw_caption(picture.caption, width), left, top + height, montage);
  }
  return montage;
}

}  // namespace cholecystectomy
