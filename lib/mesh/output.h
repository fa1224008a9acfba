// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Builds the bytes of a file in memory and puts them in place at once.

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <filesystem>
#include <string>
#include <string_view>

#include "scalar_type.h"

namespace pbdsurg {

/// Appends the shortest text that reads back to the same number, whatever the locale.
template <class Number>
void append_text(std::string& out, Number value) {
  std::array<char, 32> buffer;
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), value);
  (void)error;  // 32 characters hold any number
  out.append(buffer.data(), end);
}

/// Appends the bytes of a number.
template <class Number>
void append_bytes(std::string& out, Number value, std::endian order) {
  const Number ordered = in_order(value, order);
  std::array<char, sizeof(Number)> bytes;
  std::memcpy(bytes.data(), &ordered, sizeof ordered);
  out.append(bytes.data(), bytes.size());
}

/// Writes a file beside its place, then moves it there: no reader ever sees half of it.
/// @throws FileError  if that fails; what was there before stays
void write_file(const std::filesystem::path& path, std::string_view bytes);

}  // namespace pbdsurg
