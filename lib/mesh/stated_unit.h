// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The unit of length that our own mesh files state, in a comment or title of their format.

#include <algorithm>
#include <cstddef>
#include <string_view>

namespace pbdsurg {

/// Stands near the beginning of every file of write_mesh(), or at its end: in MSH, some readers
/// take no section before the nodes.
inline constexpr std::string_view kMetresMark = "pbdsurg mesh, coordinates in metres";

/// Whether a file says so.
[[nodiscard]] inline bool states_metres(std::string_view bytes) {
  constexpr std::size_t kReach = 256;  // bytes from either end
  const std::string_view end = bytes.substr(bytes.size() - std::min(bytes.size(), kReach));
  return bytes.substr(0, kReach).find(kMetresMark) != std::string_view::npos ||
         end.find(kMetresMark) != std::string_view::npos;
}

}  // namespace pbdsurg
