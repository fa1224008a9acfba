// SPDX-License-Identifier: Apache-2.0
#include "step_time.h"

#include "pbdsurg/core/error.h"

#include "median_time.h"

namespace pbdsurg::bench {
namespace {

constexpr float kTimeStep = 2e-4F;  // s
constexpr float kStretch = 1.1F;    // along x, the organ's long axis
constexpr double kRim = 3e-3;       // m

double time_step(const Sample& sample, const SolverOptions& options, int repetitions) {
  Scene scene;
  const Index body = scene.add_body("gallbladder", sample.mesh);
  const double end = bounding_box(sample.mesh).min().x() + kRim;
  scene.fix_where(body, [&](const Eigen::Vector3d& x) { return x.x() < end; });
  Solver solver(scene, options);
  std::vector<Eigen::Vector3f> start = solver.positions();
  for (Eigen::Vector3f& x : start) {
    x.x() *= kStretch;
  }
  solver.write_positions(start);
  const Snapshot stretched = solver.snapshot();
  Index non_finite = 0;
  const double time = median_time(
      repetitions, [&] { solver.restore(stretched); },
      [&] { non_finite += solver.step(kTimeStep).non_finite_vertices; });
  if (non_finite > 0) {
    throw Error(std::string(name_of(sample.kind)) + ": a step of plan " + solver.plan().name +
                " leaves vertices that are not finite");
  }
  return time;
}

}  // namespace

StepTimes time_steps(const Sample& sample, const ColoringOptions& coloring,
                     PlanComposition composition, int repetitions) {
  StepTimes times{};
  SolverOptions options = SolverOptions::paper();
  options.coloring = coloring;
  options.composition = composition;
  for (std::size_t b = 0; b < kStepBackends.size(); ++b) {
    options.backend = kStepBackends[b].kind;
    times[b] = time_step(sample, options, repetitions);
  }
  return times;
}

}  // namespace pbdsurg::bench
