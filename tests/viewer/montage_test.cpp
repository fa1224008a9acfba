// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/montage.h"

#include <algorithm>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

constexpr int kWidth = 60;
constexpr int kHeight = 40;
constexpr Rgb8 kWhite{255, 255, 255};

CaptionedImage plain(const std::string& caption, Rgb8 color) {
  CaptionedImage picture{caption, {kWidth, kHeight, {}}};
  for (int i = 0; i < kWidth * kHeight; ++i) {
    picture.image.rgb.insert(picture.image.rgb.end(), color.begin(), color.end());
  }
  return picture;
}

bool has_ink(const Image& image, int left, int top, int right, int bottom) {
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) {
      if (image.at(x, y) != kWhite) {
        return true;
      }
    }
  }
  return false;
}

}  // namespace

TEST_CASE("montage: pictures stand row by row, each above its caption", "[unit]") {
  const std::vector<Rgb8> colors{{200, 0, 0}, {0, 200, 0}, {0, 0, 200}};
  const std::vector<CaptionedImage> pictures{plain("a", colors[0]), plain("b", colors[1]),
                                             plain("", colors[2])};
  const Image montage = make_montage(pictures, 2);
  CHECK(montage.width == 2 * kWidth);
  REQUIRE(montage.height > 2 * kHeight);
  REQUIRE(montage.height % 2 == 0);
  const int row = montage.height / 2;
  for (int i = 0; i < 3; ++i) {
    const int left = i % 2 * kWidth;
    const int top = i / 2 * row;
    CHECK(montage.at(left, top) == colors[i]);
    CHECK(montage.at(left + kWidth - 1, top + kHeight - 1) == colors[i]);
    CHECK(has_ink(montage, left, top + kHeight, left + kWidth, top + row) == (i < 2));
  }
  CHECK_FALSE(has_ink(montage, kWidth, row, 2 * kWidth, 2 * row));
}

TEST_CASE("montage: pictures that do not fit each other are refused", "[unit]") {
  CHECK_THROWS_AS(make_montage({}, 2), pbdsurg::InvalidArgument);
  std::vector<CaptionedImage> pictures{plain("a", kWhite), plain("b", kWhite)};
  CHECK_THROWS_AS(make_montage(pictures, 0), pbdsurg::InvalidArgument);
  --pictures[1].image.height;
  CHECK_THROWS_AS(make_montage(pictures, 2), pbdsurg::InvalidArgument);
}

}  // namespace cholecystectomy
