// SPDX-License-Identifier: Apache-2.0
#include "step_time.h"

#include <utility>

#include "pbdsurg/core/error.h"

#include "median_time.h"

namespace pbdsurg::bench {
namespace {

constexpr float kTimeStep = 2e-4F;  // s
constexpr float kStretch = 1.1F;    // along x, the organ's long axis
constexpr double kRim = 3e-3;       // m

Scene make_scene(const TetMesh& mesh) {
  Scene scene;
  const Index body = scene.add_body("gallbladder", mesh);
  const double end = bounding_box(mesh).min().x() + kRim;
  scene.fix_where(body, [&](const Eigen::Vector3d& x) { return x.x() < end; });
  return scene;
}

// One solver, stepped again and again from the same start.
class RepeatedStep {
 public:
  RepeatedStep(const Scene& scene, const SolverOptions& options) : solver_(scene, options) {
    std::vector<Eigen::Vector3f> stretched = solver_.positions();
    for (Eigen::Vector3f& x : stretched) {
      x.x() *= kStretch;
    }
    solver_.write_positions(stretched);
    start_ = solver_.snapshot();
  }

  void run() {
    solver_.restore(start_);
    StepReport report;
    times_.push_back(time_of([&] { report = solver_.step(kTimeStep); }));
    if (report.non_finite_vertices > 0) {
      throw Error("a step of plan " + solver_.plan().name +
                  " leaves vertices that are not finite, the first " +
                  std::to_string(report.first_non_finite));
    }
  }

  [[nodiscard]] double median_time() const { return median(times_); }

 private:
  Solver solver_;
  Snapshot start_;
  std::vector<double> times_;  // ms
};

}  // namespace

std::vector<PlanTimes> time_steps(const Sample& sample, std::span<const ColoringOptions> colorings,
                                  int repetitions) {
  const Scene scene = make_scene(sample.mesh);
  std::vector<PlanTimes> times(colorings.size());
  std::vector<std::pair<RepeatedStep, double*>> steps;  // and where its time goes
  for (std::size_t i = 0; i < colorings.size(); ++i) {
    SolverOptions options = SolverOptions::paper();
    options.coloring = colorings[i];
    for (std::size_t b = 0; b < kStepBackends.size(); ++b) {
      options.backend = kStepBackends[b].kind;
      options.composition = PlanComposition::separate;
      steps.emplace_back(RepeatedStep(scene, options), &times[i].separate[b]);
      options.composition = PlanComposition::joint;
      steps.emplace_back(RepeatedStep(scene, options), &times[i].joint[b]);
    }
  }
  for (int i = 0; i < repetitions; ++i) {
    for (auto& [step, time] : steps) {
      step.run();
    }
  }
  for (const auto& [step, time] : steps) {
    *time = step.median_time();
  }
  return times;
}

}  // namespace pbdsurg::bench
