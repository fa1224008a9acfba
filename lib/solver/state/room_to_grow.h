// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How much room there is for what edits bring.

#include <algorithm>
#include <cstddef>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Groups of a kind that wait for constraints which find all others taken, where room was asked
/// for; and stages of a device for them. Vertices at a cut come to have that many more edges.
inline constexpr Index kWaitingGroups = 24;

/// The room that backends which keep the state elsewhere make for what has outgrown its own: a
/// sixteenth more than there is, so that edits that bring ever more rarely come to this.
[[nodiscard]] constexpr std::size_t room_to_grow(std::size_t count) noexcept {
  constexpr std::size_t kLeast = 1024;
  return count + std::max(count / 16, kLeast);
}

}  // namespace pbdsurg
