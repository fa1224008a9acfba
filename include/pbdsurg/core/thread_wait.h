// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How threads of a team wait for work.

#include <cstdint>

namespace pbdsurg {

/// What a backend's threads do while they wait for each other within a step. All sleep in the end,
/// and between steps.
enum class ThreadWait : std::uint8_t {
  /// stay on the processor for 200 us: fastest, for a machine with processors to spare; as yield
  /// where there are fewer processors than threads
  spin,
  yield,  ///< spin for about a microsecond, then offer the processor to others, for 50 us
  block,  ///< spin for about a microsecond
};

}  // namespace pbdsurg
