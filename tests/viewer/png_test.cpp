// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/png.h"

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#include <filesystem>
#include <string>
#include <vector>

#include <stb_image.h>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

/// A folder of this test's own, removed with what is in it.
class Folder {
 public:
  explicit Folder(const std::string& name)
      : path_(std::filesystem::temp_directory_path() / ("pbdsurg_viewer_" + name)) {
    std::filesystem::remove_all(path_);
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

Image gradient(int width, int height) {
  Image image{width, height, {}};
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      image.rgb.push_back(static_cast<std::uint8_t>(10 * x));
      image.rgb.push_back(static_cast<std::uint8_t>(10 * y));
      image.rgb.push_back(static_cast<std::uint8_t>(x * y));
    }
  }
  return image;
}

}  // namespace

// Would catch swapped channels, a wrong stride and rows from below.
TEST_CASE("png: what is written is read back", "[unit]") {
  const Folder folder("roundtrip");
  const std::filesystem::path path = folder.path() / "a.png";
  const Image image = gradient(17, 9);

  write_png(path, image);
  write_png(path, image);  // replaces

  int width = 0, height = 0, channels = 0;
  stbi_uc* pixels = stbi_load(path.c_str(), &width, &height, &channels, 3);
  REQUIRE(pixels != nullptr);
  const std::vector<std::uint8_t> read(pixels, pixels + 3 * width * height);
  stbi_image_free(pixels);
  CHECK(width == 17);
  CHECK(height == 9);
  CHECK(channels == 3);
  CHECK(read == image.rgb);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("png: a path that cannot be written is one clear error and leaves nothing", "[unit]") {
  const Folder folder("unwritable");
  const std::filesystem::path missing = folder.path() / "missing" / "a.png";
  const std::filesystem::path taken = folder.path() / "taken";
  std::filesystem::create_directories(taken / "inside");

  CHECK_THROWS_AS(write_png(missing, gradient(4, 4)), pbdsurg::FileError);
  CHECK_THROWS_WITH(write_png(missing, gradient(4, 4)),
                    pbdsurg::testing::ContainsSubstring(missing.string()));
  CHECK_THROWS_AS(write_png(taken, gradient(4, 4)), pbdsurg::FileError);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("png: an image whose array does not fit its size is refused", "[unit]") {
  Image image = gradient(4, 4);
  image.rgb.pop_back();

  CHECK_THROWS_AS(write_png("unused.png", image), pbdsurg::InvalidArgument);
  CHECK_THROWS_AS(write_png("unused.png", Image{}), pbdsurg::InvalidArgument);
}

}  // namespace cholecystectomy
