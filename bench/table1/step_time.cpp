// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/step_time.h"

#include <utility>

#include "apps/support/executors.h"
#include "bench/support/repeated_step.h"

namespace pbdsurg::bench {

std::vector<PlanTimes> time_steps(const Sample& sample, std::span<const ColoringOptions> colorings,
                                  int repetitions, bool has_gpu) {
  const Scene scene = make_organ_scene(sample.mesh);
  std::vector<PlanTimes> times(colorings.size());
  std::vector<std::pair<RepeatedStep, std::optional<double>*>> steps;  // and where its time goes
  for (std::size_t i = 0; i < colorings.size(); ++i) {
    SolverOptions options = SolverOptions::paper();
    options.coloring = colorings[i];
    for (std::size_t b = 0; b < kStepBackends.size(); ++b) {
      const bool is_gpu = kStepBackends[b].is_gpu;
      if (is_gpu && !has_gpu) {
        continue;
      }
      options.executor = is_gpu ? programs::device() : executor::serial();
      options.device_strategy = kStepBackends[b].strategy;
      const StepConditions conditions{.steps_before = is_gpu ? 1 : 0};
      options.composition = PlanComposition::separate;
      steps.emplace_back(RepeatedStep(scene, options, conditions), &times[i].separate[b]);
      options.composition = PlanComposition::joint;
      steps.emplace_back(RepeatedStep(scene, options, conditions), &times[i].joint[b]);
    }
  }
  for (int i = 0; i < repetitions; ++i) {
    for (auto& [step, time] : steps) {
      step.run();
    }
  }
  for (const auto& [step, time] : steps) {
    *time = median(step.times());
  }
  return times;
}

}  // namespace pbdsurg::bench
