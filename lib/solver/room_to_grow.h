// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How backends that keep the state elsewhere make room for what edits bring.

#include <algorithm>
#include <cstddef>

namespace pbdsurg {

/// The room to make for what has outgrown its own: a sixteenth more than there is, so that edits
/// that bring ever more rarely come to this.
[[nodiscard]] constexpr std::size_t room_to_grow(std::size_t count) noexcept {
  constexpr std::size_t kLeast = 1024;
  return count + std::max(count / 16, kLeast);
}

}  // namespace pbdsurg
