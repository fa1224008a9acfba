// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long a step takes on a CUDA device.

#include <optional>
#include <string>

#include "pbdsurg/solver/solver.h"

#include "bench/support/timing.h"

namespace pbdsurg::bench {

/// Why no solver here can step on a device, in one sentence; none if one can.
[[nodiscard]] std::optional<std::string> why_no_gpu();

/// How much is measured.
struct GpuEffort {
  int rounds;        ///< each of which runs one step of every kind
  int rate_steps;    ///< in a row
  int pilot_rounds;  ///< of the search for the fastest plan
};

/// Consecutive steps of 1 ms, as a haptic loop takes them.
struct Rate {
  int steps;
  int missed;  ///< took longer than 1 ms
  StepStatistics time;
  double max_ms;
};

/// One scene under the plan and strategy that are fastest on the device.
///
/// A step lasts from Solver::start_step() to the report of Solver::finish_step(), which brings the
/// watched vertices along; the state stays on the device. The step that is timed is the second from
/// the start, as the first takes the start to the device.
struct GpuTimes {
  std::string backend;
  std::string plan;
  std::string strategy;  ///< "stream", "graph" or "cluster"
  bool is_automatic;     ///< DeviceStrategy::automatic takes it
  Index colors;          ///< phases in one sweep
  Index stream_colors;
  Index watched;  ///< vertices
  int steps;      ///< timed of each kind
  StepStatistics fastest;
  StepStatistics with_copies;  ///< the fastest; all positions written before, read after the step
  StepStatistics stream;       ///< the paper's plan, one launch a phase
  double stream_over_fastest;  ///< median over rounds of the ratios within a round
  /// Largest distance of a vertex from where strict arithmetic brings it, over the mean length of
  /// edges and links.
  double distance_from_strict;
  std::optional<double> bytes;  ///< see swept_bytes(); none on a cluster, which keeps them near
  Rate rate;
};

/// Bytes that the sweeps of one step ask memory for, as computed: each constraint has its record
/// (16 bytes of a distance, 32 of a volume, 80 of a tetrahedron with its edges) and reads and
/// writes its vertices, 16 bytes each.
/// @param solver  of a separate or joint plan
[[nodiscard]] double swept_bytes(const Solver& solver);

/// @throws BackendUnavailable  if no plan and strategy can step the scene here
/// @throws Error  if steps end otherwise when they are repeated, strict ones otherwise than on the
///                serial backend, fast ones far from these, or with vertices that are not finite;
///                or if watched vertices are not where all are read
[[nodiscard]] GpuTimes measure_on_gpu(const Scene& scene, const GpuEffort& effort);

}  // namespace pbdsurg::bench
