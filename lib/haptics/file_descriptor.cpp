// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/file_descriptor.h"

#include <unistd.h>

namespace pbdsurg {

void FileDescriptor::close() noexcept {
  if (is_open()) {
    ::close(std::exchange(number_, -1));
  }
}

}  // namespace pbdsurg
