// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The figures of table 1.

#include <optional>
#include <vector>

#include "bench/support/sample.h"
#include "bench/table1/step_time.h"

namespace pbdsurg::bench {

/// One way to colour one type of constraint of one mesh.
struct Row {
  const Sample* sample;
  std::string constraints;  ///< "distance", "volume" or "joint": tetrahedra that own their edges
  ColoringOptions coloring;
  ColoringStatistics statistics;
  std::vector<Index> color_sizes;       ///< constraints of each colour, the largest first
  double color_ms;                      ///< on one CPU thread
  std::optional<double> color_cuda_ms;  ///< see time_gpu_coloring()
  StepTimes step_ms;                    ///< both types coloured this way, or the joint plan
};

/// How often things are timed; what counts is the median.
struct Repetitions {
  int coloring;
  int step;
};

/// The rows of a mesh, constraint type by constraint type.
/// @throws Error  if a colouring is not valid
[[nodiscard]] std::vector<Row> measure(const Sample& sample, const Repetitions& repetitions);

}  // namespace pbdsurg::bench
