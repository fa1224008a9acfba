// SPDX-License-Identifier: Apache-2.0
#include "lib/haptics/open_device.h"

#include <cerrno>
#include <system_error>

#include <fcntl.h>
#include <unistd.h>

namespace pbdsurg {

std::string open_refusal(const std::filesystem::path& path, int error, const OpenAdvice& advice) {
  std::string text = path.string() + ": ";
  switch (error) {
    case EACCES:
    case EPERM:
      return text.append("you are not allowed to read it; ").append(advice.not_allowed);
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return text.append("there is no such device; ").append(advice.not_there);
    case EBUSY:
      return text.append("another program has it; end that program");
    default:
      return text.append(std::generic_category().message(error));
  }
}

FileDescriptor open_device(const std::filesystem::path& path, const OpenAdvice& advice) {
  FileDescriptor descriptor(::open(path.c_str(), O_RDONLY | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!descriptor.is_open()) {
    throw FileError(open_refusal(path, errno, advice));
  }
  return descriptor;
}

long read_available(const FileDescriptor& descriptor, void* bytes, std::size_t size) noexcept {
  while (true) {
    const ssize_t count = ::read(descriptor.number(), bytes, size);
    if (count >= 0) {
      return count;
    }
    if (errno == EAGAIN || errno == EWOULDBLOCK) {
      return -1;
    }
    if (errno != EINTR) {
      return 0;  // what is unplugged can be read no more
    }
  }
}

}  // namespace pbdsurg
