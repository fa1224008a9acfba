// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One number for many, for telling whether anything differs.

#include <bit>
#include <cstdint>
#include <iterator>
#include <type_traits>

#include "pbdsurg/base/random.h"

namespace pbdsurg::testing {

/// Mixes numbers, one after another.
class Digest {
 public:
  template <class Number>
  void mix(Number number) {
    if constexpr (std::is_same_v<Number, float>) {
      mix(std::bit_cast<std::uint32_t>(number));
    } else if constexpr (std::is_same_v<Number, double>) {
      mix(std::bit_cast<std::uint64_t>(number));
    } else {
      value_ = detail::mix_bits(value_, static_cast<std::uint64_t>(number));
    }
  }
  template <class Range>
  void mix_all(const Range& range) {
    mix(std::size(range));
    for (const auto& entry : range) {
      if constexpr (std::is_arithmetic_v<std::remove_cvref_t<decltype(entry)>>) {
        mix(entry);
      } else {
        mix_all(entry);
      }
    }
  }

  [[nodiscard]] std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0;
};

}  // namespace pbdsurg::testing
