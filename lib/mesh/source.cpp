// SPDX-License-Identifier: Apache-2.0
#include "lib/mesh/source.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <system_error>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

void Source::fail_at_line(std::size_t offset, const std::string& reason) const {
  const std::size_t end = std::min(offset, bytes.size());
  const auto line =
      1 + std::count(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(end), '\n');
  throw FileError::at_line(path, static_cast<long>(line), reason);
}

void Source::fail_at_byte(std::size_t offset, const std::string& reason) const {
  throw FileError::at_byte(path, static_cast<long long>(offset), reason);
}

Source read_source(const std::filesystem::path& path) {
  Source source{path.string(), {}, 0};
  std::error_code error;
  const std::filesystem::file_status status = std::filesystem::status(path, error);
  if (!std::filesystem::exists(status)) {
    throw FileError(source.path + ": no such file");
  }
  if (!std::filesystem::is_regular_file(status)) {
    throw FileError(source.path + ": is not a regular file");
  }
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) {
    throw FileError(source.path + ": " + error.message());
  }
  if (size >= (std::uintmax_t{1} << 31)) {
    throw FileError(source.path + ": has " + std::to_string(size) +
                    " bytes; files are read whole and must be under 2 GiB");
  }
  std::ifstream stream(path, std::ios::binary);
  if (!stream) {
    throw FileError(source.path + ": cannot be opened for reading");
  }
  source.bytes.resize(size);
  stream.read(source.bytes.data(), static_cast<std::streamsize>(size));
  if (stream.gcount() != static_cast<std::streamsize>(size)) {
    throw FileError(source.path + ": only " + std::to_string(stream.gcount()) + " of " +
                    std::to_string(size) + " bytes could be read");
  }
  constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
  source.text_begin = source.bytes.starts_with(kByteOrderMark) ? kByteOrderMark.size() : 0;
  return source;
}

std::string count_problem(std::int64_t count, std::string_view what, std::size_t least_bytes,
                          std::size_t left) {
  const std::string name(what);
  if (count < 0) {
    return std::to_string(count) + " is announced as the number of " + name +
           "; it must not be negative";
  }
  if (count > std::numeric_limits<Index>::max()) {
    return std::to_string(count) + " " + name + " are announced; at most 2147483647 are supported";
  }
  if (least_bytes > 0 && static_cast<std::size_t>(count) > left / least_bytes) {
    return std::to_string(count) + " " + name + " are announced, but only " + std::to_string(left) +
           " bytes are left";
  }
  return {};
}

}  // namespace pbdsurg
