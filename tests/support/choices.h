// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Choices made by bytes: those of a fuzzer, or random ones.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg::testing {

class Choices {
 public:
  /// @param bytes  must outlive this; zeros follow them
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// In [0, count). @param count  in [1, 65536]
  Index below(Index count) {
    unsigned bits = 0;
    for (const unsigned shift : {8U, 0U}) {
      bits |= (is_spent() ? 0U : bytes_[next_]) << shift;
      ++next_;
    }
    return static_cast<Index>(bits % static_cast<unsigned>(count));
  }

  /// In [0, 1).
  double share() { return below(1024) / 1024.0; }

  /// One of a list, which has one at least.
  template <class List>
  const auto& one_of(const List& list) {
    return list[below(static_cast<Index>(std::size(list)))];
  }

  /// Whether no bytes are left.
  [[nodiscard]] bool is_spent() const { return next_ >= bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
};

[[nodiscard]] inline std::vector<std::uint8_t> random_bytes(std::uint64_t seed, std::size_t count) {
  std::vector<std::uint8_t> bytes(count);
  for (std::size_t i = 0; i < count; ++i) {
    bytes[i] = static_cast<std::uint8_t>(random_bits(seed, i) >> 56);
  }
  return bytes;
}

/// Ids in [0, count) for which a condition holds.
template <class Condition>
[[nodiscard]] std::vector<Index> find_all(std::size_t count, Condition condition) {
  std::vector<Index> found;
  for (Index id = 0; id < static_cast<Index>(count); ++id) {
    if (condition(id)) {
      found.push_back(id);
    }
  }
  return found;
}

/// Some of them, one at least if there are any, each once.
[[nodiscard]] inline std::vector<Index> pick_some(std::vector<Index> ids, Index most,
                                                  Choices& choices) {
  std::vector<Index> picked;
  for (Index wanted = choices.below(most) + 1; wanted > 0 && !ids.empty(); --wanted) {
    std::swap(ids[choices.below(static_cast<Index>(ids.size()))], ids.back());
    picked.push_back(ids.back());
    ids.pop_back();
  }
  return picked;
}

}  // namespace pbdsurg::testing
