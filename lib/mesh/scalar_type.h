// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Numbers whose type is named in a file.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace pbdsurg {

enum class ScalarType {
  int8,
  uint8,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64
};

[[nodiscard]] constexpr std::size_t size_of(ScalarType type) {
  constexpr std::array<std::size_t, 10> kSizes{1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

[[nodiscard]] constexpr bool is_integer(ScalarType type) {
  return type < ScalarType::float32;
}

/// Reverses the bytes of a number when they are not in the order of this machine.
template <class Number>
[[nodiscard]] Number in_order(Number value, std::endian order) {
  if (order != std::endian::native) {
    std::array<char, sizeof(Number)> bytes;
    std::memcpy(bytes.data(), &value, sizeof value);
    std::reverse(bytes.begin(), bytes.end());
    std::memcpy(&value, bytes.data(), sizeof value);
  }
  return value;
}

/// The number at an address of any alignment.
template <class Number>
[[nodiscard]] Number load(const char* bytes, std::endian order) {
  Number value;
  std::memcpy(&value, bytes, sizeof value);
  return in_order(value, order);
}

/// Same, converted from a type known at run time only. Ask for an integer only where the stored
/// type is one: see is_integer(). Unsigned numbers beyond the signed range become negative.
template <class Number>
[[nodiscard]] Number load_as(ScalarType type, const char* bytes, std::endian order) {
  switch (type) {
    case ScalarType::int8:
      return static_cast<Number>(load<std::int8_t>(bytes, order));
    case ScalarType::uint8:
      return static_cast<Number>(load<std::uint8_t>(bytes, order));
    case ScalarType::int16:
      return static_cast<Number>(load<std::int16_t>(bytes, order));
    case ScalarType::uint16:
      return static_cast<Number>(load<std::uint16_t>(bytes, order));
    case ScalarType::int32:
      return static_cast<Number>(load<std::int32_t>(bytes, order));
    case ScalarType::uint32:
      return static_cast<Number>(load<std::uint32_t>(bytes, order));
    case ScalarType::int64:
      return static_cast<Number>(load<std::int64_t>(bytes, order));
    case ScalarType::uint64:
      return static_cast<Number>(load<std::uint64_t>(bytes, order));
    case ScalarType::float32:
      return static_cast<Number>(load<float>(bytes, order));
    case ScalarType::float64:
      return static_cast<Number>(load<double>(bytes, order));
  }
  return {};
}

}  // namespace pbdsurg
