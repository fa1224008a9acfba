// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Wall time of something short.

#include <algorithm>
#include <chrono>
#include <vector>

namespace pbdsurg::bench {

/// Median time of `run`, in ms; `prepare` runs before each and is not counted.
template <class Prepare, class Run>
double median_time(int repetitions, Prepare&& prepare, Run&& run) {
  std::vector<double> times;
  for (int i = 0; i < repetitions; ++i) {
    prepare();
    const auto start = std::chrono::steady_clock::now();
    run();
    const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
    times.push_back(time.count());
  }
  std::sort(times.begin(), times.end());
  return times[times.size() / 2];
}

template <class Run>
double median_time(int repetitions, Run&& run) {
  return median_time(
      repetitions, [] {}, run);
}

}  // namespace pbdsurg::bench
