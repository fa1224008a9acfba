// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A file held in memory, with errors that say where in it something is wrong.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace pbdsurg {

/// The bytes of one file. Readers keep offsets only; a line number is counted when an error needs
/// it.
struct Source {
  std::string path;
  std::string bytes;
  std::size_t text_begin = 0;  ///< where text starts: behind a byte-order mark, if there is one

  [[noreturn]] void fail_at_line(std::size_t offset, const std::string& reason) const;
  [[noreturn]] void fail_at_byte(std::size_t offset, const std::string& reason) const;
};

/// Reads a whole file and looks for the byte-order mark of UTF-8. @throws FileError if it cannot be
/// read or has 2 GiB or more.
[[nodiscard]] Source read_source(const std::filesystem::path& path);

/// Why a file cannot hold `count` elements of `least_bytes` bytes each in the `left` bytes that
/// follow; empty when it can. Asked before anything is allocated.
[[nodiscard]] std::string count_problem(std::int64_t count, std::string_view what,
                                        std::size_t least_bytes, std::size_t left);

}  // namespace pbdsurg
