// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Builds the bytes of a file in memory.

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <string>

#include "lib/mesh/scalar_type.h"

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

}  // namespace pbdsurg
