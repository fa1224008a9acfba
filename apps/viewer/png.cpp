// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/png.h"

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#define STBI_WRITE_NO_STDIO
#include <cerrno>
#include <cstring>
#include <fstream>
#include <string>
#include <system_error>

#include <stb_image_write.h>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

void append(void* context, void* data, int size) {
  static_cast<std::string*>(context)->append(static_cast<const char*>(data),
                                             static_cast<std::size_t>(size));
}

}  // namespace

void write_png(const std::filesystem::path& path, const Image& image) {
  if (image.width <= 0 || image.height <= 0 ||
      image.rgb.size() !=
          3 * static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height)) {
    throw pbdsurg::InvalidArgument("an image of " + std::to_string(image.width) + " x " +
                                   std::to_string(image.height) + " pixels has " +
                                   std::to_string(image.rgb.size()) +
                                   " bytes; it must have 3 for each pixel and at least one pixel");
  }
  std::string bytes;
  if (stbi_write_png_to_func(append, &bytes, image.width, image.height, 3, image.rgb.data(),
                             3 * image.width) == 0) {
    throw pbdsurg::FileError(path.string() + ": the picture could not be encoded as PNG");
  }

  std::filesystem::path temporary = path;
  temporary += ".part";
  errno = 0;
  std::ofstream file(temporary, std::ios::binary | std::ios::trunc);
  file.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  file.close();
  std::error_code error;
  if (!file) {
    const std::string reason = errno != 0 ? std::strerror(errno) : "write failed";
    std::filesystem::remove(temporary, error);
    throw pbdsurg::FileError(path.string() + ": cannot write: " + reason);
  }
  std::filesystem::rename(temporary, path, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(temporary, error);
    throw pbdsurg::FileError(path.string() + ": cannot write: " + reason);
  }
}

}  // namespace cholecystectomy
