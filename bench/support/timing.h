// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Time of something short.

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include <time.h>

namespace pbdsurg::bench {

/// How long a call takes, ms.
template <class Run>
double time_of(Run&& run) {
  const auto start = std::chrono::steady_clock::now();
  run();
  const std::chrono::duration<double, std::milli> time = std::chrono::steady_clock::now() - start;
  return time.count();
}

/// s of processor time that the calling thread has had: what others do on a busy machine counts
/// little.
inline double thread_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The smallest value that at least a share of the values do not exceed.
/// @param values  at least one
/// @param share   in (0, 1]
inline double quantile(std::vector<double> values, double share) {
  std::sort(values.begin(), values.end());
  const double rank = std::ceil(share * static_cast<double>(values.size()));
  return values[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
}

/// @param values  at least one
inline double median(std::vector<double> values) {
  return quantile(std::move(values), 0.5);
}

/// Median time of a call that is repeated, ms.
template <class Run>
double median_time(int repetitions, Run&& run) {
  std::vector<double> times;
  for (int i = 0; i < repetitions; ++i) {
    times.push_back(time_of(run));
  }
  return median(std::move(times));
}

/// Times of one backend's steps.
struct StepStatistics {
  double median_ms;
  double p99_ms;
};

/// @param times  ms, at least one
inline StepStatistics statistics(const std::vector<double>& times) {
  return {median(times), quantile(times, 0.99)};
}

/// Of backends that take turns, so that a round sees the same machine, however busy.
/// @param times, base  ms, round by round
inline double median_ratio(const std::vector<double>& times, const std::vector<double>& base) {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < times.size(); ++i) {
    ratios.push_back(times[i] / base[i]);
  }
  return median(std::move(ratios));
}

}  // namespace pbdsurg::bench
