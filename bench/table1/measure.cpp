// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/measure.h"

#include <algorithm>
#include <functional>

#include "bench/support/gpu_times.h"
#include "bench/support/timing.h"
#include "bench/table1/colorings.h"
#include "bench/table1/gpu_coloring.h"

namespace pbdsurg::bench {
namespace {

Row measure_coloring(const Sample& sample, const std::string& name,
                     const ConstraintVertices& constraints, const ColoringOptions& options,
                     const StepTimes& step_ms, int repetitions) {
  const Coloring coloring = color_validly(constraints, options);
  std::vector<Index> sizes = color_sizes(coloring);
  std::ranges::sort(sizes, std::greater());
  return {&sample,
          name,
          options,
          pbdsurg::measure_coloring(coloring, constraints),
          std::move(sizes),
          median_time(repetitions, [&] { (void)color_constraints(constraints, options); }),
          time_gpu_coloring(constraints, options, coloring, repetitions),
          step_ms};
}

}  // namespace

std::vector<Row> measure(const Sample& sample, const Repetitions& repetitions) {
  const std::vector<ColoringOptions> colorings = table1_colorings();
  const std::vector<PlanTimes> step_ms =
      time_steps(sample, colorings, repetitions.step, !why_no_gpu());
  std::vector<Row> distance, volume, joint;
  for (std::size_t i = 0; i < colorings.size(); ++i) {
    distance.push_back(measure_coloring(sample, "distance", sample.edge_constraints(), colorings[i],
                                        step_ms[i].separate, repetitions.coloring));
    volume.push_back(measure_coloring(sample, "volume", sample.tet_constraints(), colorings[i],
                                      step_ms[i].separate, repetitions.coloring));
    joint.push_back(volume.back());  // a colouring of the tetrahedra serves both
    joint.back().constraints = "joint";
    joint.back().step_ms = step_ms[i].joint;
  }
  std::vector<Row> rows = std::move(distance);
  rows.insert(rows.end(), volume.begin(), volume.end());
  rows.insert(rows.end(), joint.begin(), joint.end());
  return rows;
}

}  // namespace pbdsurg::bench
