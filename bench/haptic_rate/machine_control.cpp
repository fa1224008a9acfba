// SPDX-License-Identifier: Apache-2.0
#include "bench/haptic_rate/machine_control.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <random>

#include "pbdsurg/base/clock.h"

#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr double kPeriod = 2e-3;  // s
constexpr std::size_t kCells = (std::size_t{1} << 20) / sizeof(std::uint32_t);
constexpr int kSteps = 50000;

// One circle through all cells, in random order.
std::vector<std::uint32_t> make_circle() {
  std::vector<std::uint32_t> order(kCells), next(kCells);
  std::iota(order.begin(), order.end(), 0U);
  std::shuffle(order.begin(), order.end(), std::mt19937(1));
  for (std::size_t i = 0; i < kCells; ++i) {
    next[order[i]] = order[(i + 1) % kCells];
  }
  return next;
}

}  // namespace

std::vector<double> walk_times(double seconds) {
  const std::vector<std::uint32_t> next = make_circle();
  std::vector<double> times;
  volatile std::uint32_t place = 0;  // else nothing would need the walk
  RealClock clock;
  for (double due = 0; due < seconds; due += kPeriod) {
    clock.wait_until(due);
    times.push_back(time_of([&] {
      std::uint32_t at = place;
      for (int i = 0; i < kSteps; ++i) {
        at = next[at];
      }
      place = at;
    }));
  }
  return times;
}

}  // namespace pbdsurg::bench
