// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How much tables 2 and 3 measure of each scene.

#include <algorithm>

#include <CLI/CLI.hpp>

#include "bench/support/cpu_times.h"
#include "bench/support/gpu_times.h"

namespace pbdsurg::bench {

struct Effort {
  CpuEffort cpu;
  GpuEffort gpu;
};

inline constexpr int kCpuRounds = 100;  // p99 needs a hundred steps

/// Small meshes take more rounds, so that all take a while.
inline Effort full_effort(int cpu_rounds) {
  constexpr double kSecondsOfRound = 0.08;
  return {{cpu_rounds, kSecondsOfRound * cpu_rounds, 9}, {200, 5000, 9}};
}

/// Of a million tetrahedra, which no CPU steps at such a rate.
inline Effort large_effort(int cpu_rounds) {
  return {{std::min(cpu_rounds, 5), 0, 2}, {200, 500, 5}};
}

/// To see it work.
inline constexpr Effort kQuickEffort{{3, 0, 1}, {3, 20, 1}};

/// Adds `--cpu-rounds`.
inline void add_cpu_rounds_option(CLI::App& app, int& cpu_rounds) {
  app.add_option("--cpu-rounds", cpu_rounds, "at least as many steps of each CPU backend are timed")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
}

}  // namespace pbdsurg::bench
