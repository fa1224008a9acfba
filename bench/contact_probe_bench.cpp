// SPDX-License-Identifier: Apache-2.0
// What the two halves of contact cost: the patch of tissue near a tool, after a step, and the
// packet that a servo gets of it. The tool is a jaw of 20 mm of eight balls, the organ the hollow
// gallbladder of row 2 of table 2, of 10,800 triangles. The jaw lies on it, or is 4 cm above.
#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <benchmark/benchmark.h>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_surface.h"

#include "bench/support/paper_step.h"

namespace pbdsurg::bench {
namespace {

constexpr float kRadius = 2.5e-3F;  // m
constexpr float kDepth = 1e-3F;     // m, of the jaw's lower side under the top of the organ
constexpr float kAbove = 40e-3F;    // m
constexpr double kFastPeriod = 1e-3, kSlowPeriod = 20e-3;  // s, between steps

std::vector<ToolPoint> jaw() {
  std::vector<ToolPoint> points;
  for (int i = 0; i < 8; ++i) {
    points.push_back({{2.5e-3F * static_cast<float>(i), 0, 0}, kRadius});
  }
  return points;
}

struct Touch {
  explicit Touch(float height)
      : solver(make_organ_scene(table2_mesh(2), tissues::gallbladder_wall().mechanics)),
        surface(shared_surface(solver.tissue(), 0)),
        positions(solver.positions()),
        probe(solver, std::vector<Index>{0}, jaw()) {
    const Eigen::Vector3f top =
        *std::ranges::max_element(positions, {}, [](const Eigen::Vector3f& x) { return x.z(); });
    ToolPose pose = ToolPose::Identity();
    pose.translation() = top + Eigen::Vector3f(-10e-3F, 0, kRadius - kDepth + height);
    tool = solver.add_tool({}, pose);
  }

  Solver solver;
  std::shared_ptr<const LiveSurface> surface;
  std::vector<Eigen::Vector3f> positions;
  ContactProbe probe;
  ToolId tool;
  ContactPatch patch;
  std::uint64_t steps = 0;
};

void count(benchmark::State& state, const Touch& touch) {
  state.counters["surface"] = touch.surface->triangle_count();
  state.counters["patch"] = static_cast<double>(touch.patch.triangles.size());
  state.counters["planes"] = make_contact_packet(touch.patch).plane_count;
}

// The probe reads the solver: all of the surface after 20 ms, mostly what is near after 1 ms.
void BM_patch(benchmark::State& state, float height, double period) {
  Touch touch(height);
  for (auto _ : state) {
    ++touch.steps;
    touch.probe.collect_patch(touch.solver, touch.tool, GraspState::open, touch.steps,
                              period * static_cast<double>(touch.steps), touch.patch);
  }
  count(state, touch);
}

// The surface was read already.
void BM_patch_of_surfaces(benchmark::State& state, float height) {
  Touch touch(height);
  const TouchedSurface surface{touch.surface->triangles(), touch.positions};
  for (auto _ : state) {
    touch.probe.collect_patch(std::span(&surface, 1), touch.solver, touch.tool, GraspState::open,
                              ++touch.steps, 0, touch.patch);
  }
  count(state, touch);
}

void BM_packet(benchmark::State& state, float height) {
  Touch touch(height);
  touch.probe.collect_patch(touch.solver, touch.tool, GraspState::open, 1, 0, touch.patch);
  for (auto _ : state) {
    benchmark::DoNotOptimize(make_contact_packet(touch.patch));
  }
  count(state, touch);
}

BENCHMARK_CAPTURE(BM_patch, touching_all, 0, kSlowPeriod)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_patch, touching_near, 0, kFastPeriod)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_patch, far_all, kAbove, kSlowPeriod)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_patch_of_surfaces, touching, 0)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_patch_of_surfaces, far, kAbove)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_packet, touching, 0)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(BM_packet, far, kAbove)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace pbdsurg::bench

BENCHMARK_MAIN();
