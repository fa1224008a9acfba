// SPDX-License-Identifier: Apache-2.0
#include "output.h"

#include <fstream>
#include <system_error>

#include "pbdsurg/core/error.h"

namespace pbdsurg {

void write_file(const std::filesystem::path& path, std::string_view bytes) {
  std::filesystem::path part = path;
  part += ".part";
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    throw FileError(path.string() + ": is a directory");
  }
  {
    std::ofstream stream(part, std::ios::binary | std::ios::trunc);
    if (!stream) {
      throw FileError(path.string() + ": cannot be written: " + part.string() +
                      " cannot be opened");
    }
    stream.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    stream.close();
    if (!stream) {
      std::filesystem::remove(part, error);
      throw FileError(path.string() + ": writing " + std::to_string(bytes.size()) +
                      " bytes failed; is the disk full?");
    }
  }
  std::filesystem::rename(part, path, error);
  if (error) {
    const std::string reason = error.message();
    std::filesystem::remove(part, error);
    throw FileError(path.string() + ": cannot be replaced: " + reason);
  }
}

}  // namespace pbdsurg
