// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What another thread will have done soon.

#include <chrono>
#include <thread>

namespace pbdsurg::testing {

/// s, for what takes long where sanitizers are slow.
inline constexpr double kPatience = 300;

/// Asks once a millisecond until it is so, for at most ten seconds.
template <class Condition>
[[nodiscard]] bool eventually(Condition condition) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(10);
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) {
      return false;
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  return true;
}

}  // namespace pbdsurg::testing
