// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How threads of a team wait for work.

#include <cstdint>

namespace pbdsurg {

/// What a backend's threads do while they wait for each other within a step. Between steps they
/// sleep, and in a step after about a millisecond, as then the thread they wait for has lost its
/// processor to another program.
enum class ThreadWait : std::uint8_t {
  /// stay on the processor: fastest, for a machine with processors to spare; as yield where there
  /// are fewer processors than threads
  spin,
  yield,  ///< spin for about a microsecond, then offer the processor to others
  block,  ///< spin for a few microseconds, then sleep
};

}  // namespace pbdsurg
