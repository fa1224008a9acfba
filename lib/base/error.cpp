// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/base/error.h"

namespace pbdsurg {

FileError FileError::at_line(const std::string& path, long line, const std::string& reason) {
  return FileError(path + ":" + std::to_string(line) + ": " + reason);
}

FileError FileError::at_byte(const std::string& path, long long offset, const std::string& reason) {
  return FileError(path + ": byte " + std::to_string(offset) + ": " + reason);
}

}  // namespace pbdsurg
