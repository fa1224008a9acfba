// SPDX-License-Identifier: Apache-2.0
#include "bench/sizes/measure.h"

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "pbdsurg/base/error.h"

#include "bench/sizes/memory.h"
#include "bench/sizes/operation.h"
#include "bench/support/timing.h"
#include "tests/support/small_steps.h"

namespace pbdsurg::bench {
namespace {

constexpr double kMostMissed = 0.05;  // of a frame, by its stages

void time_constructions(SizeTimes& times, const TetMesh& liver, const Executor& executor,
                        int rounds) {
  Scene scene;
  scene.add_body("liver", liver, tissues::liver().mechanics);
  const std::array burnt{ThermalBody{0, tissues::liver().heat}};
  CauteryOptions options;
  options.heat.executor = options.potential.executor = executor;
  std::vector<double> tissue_times, solver_times, heat_times;
  for (int round = 0; round < rounds; ++round) {
    std::optional<Tissue> tissue;
    std::optional<Solver> solver;
    std::optional<Cautery> cautery;
    tissue_times.push_back(time_of([&] { tissue.emplace(scene); }));
    solver_times.push_back(
        time_of([&] { solver.emplace(*tissue, testing::small_steps({.executor = executor})); }));
    heat_times.push_back(time_of([&] { cautery.emplace(*tissue, burnt, options); }));
  }
  times.tissue_ms = median(tissue_times);
  times.solver_ms = median(solver_times);
  times.heat_ms = median(heat_times);
}

template <class MakeFrame>
FrameTimes time_frames(int count, MakeFrame&& make_frame) {
  std::vector<double> heat, edit, step, readback, frames, shares;
  for (int i = 0; i < count; ++i) {
    const auto [frame, ms] = make_frame();
    const Frame::Times& times = frame.times;
    heat.push_back(1e3 * times.heat);
    edit.push_back(1e3 * times.edit);
    step.push_back(1e3 * times.step);
    readback.push_back(1e3 * times.readback);
    frames.push_back(ms);
    shares.push_back(1e3 * (times.heat + times.edit + times.step + times.readback) / ms);
  }
  const FrameTimes result{median(heat),     median(edit),   median(step),
                          median(readback), median(frames), median(shares)};
  if (std::abs(result.stages_over_frame - 1) > kMostMissed) {
    throw Error("the stages of a frame take " + std::to_string(result.stages_over_frame) +
                " of its time");
  }
  return result;
}

void measure_frames(SizeTimes& times, const TetMesh& liver, const Executor& executor, int frames) {
  const std::int64_t resident = resident_bytes(), heap = heap_bytes();
  Operation operation(liver, testing::small_steps({.executor = executor}));
  double energy = 0;
  const auto count = [&](const Timed& timed) {
    times.removed_tets += timed.frame.removed_tets;
    energy += timed.frame.cauteries.front().energy;
    return timed;
  };
  times.quiet = time_frames(frames, [&] { return count(operation.quiet_frame()); });
  times.burn = time_frames(frames, [&] { return count(operation.burn_frame()); });
  if (energy <= 0) {
    throw Error("the hook heats nothing");
  }
  World& world = operation.world();
  times.backend = world.solver().backend_name();
  times.tissue_bytes = static_cast<std::int64_t>(world.tissue().memory_bytes());
  times.solver_bytes = static_cast<std::int64_t>(world.solver().memory_bytes());
  times.heat_bytes = operation.heat_bytes();
  times.surface_bytes = operation.surface_bytes();
  times.heap_bytes = heap_bytes() - heap;
  times.resident_bytes = resident_bytes() - resident;
}

// A device's heat has bits of its own, so that its solver is compared with heat of the host.
std::uint64_t strict_hash(const TetMesh& liver, const Executor& executor) {
  CauteryOptions cautery;
  cautery.heat.executor = cautery.potential.executor =
      executor.kind() == ExecutorKind::device ? executor::serial() : executor;
  Operation operation(liver,
                      testing::small_steps({.executor = executor,
                                            .math = MathMode::strict,
                                            .composition = PlanComposition::separate}),
                      cautery);
  constexpr int kFrames = 4;
  for (int i = 0; i < kFrames; ++i) {
    operation.quiet_frame();
  }
  for (int i = 0; i < kFrames; ++i) {
    operation.burn_frame();
  }
  return operation.world().solver().state_hash();
}

}  // namespace

SizeTimes measure_size(const TetMesh& liver, const Executor& executor, const SizeEffort& effort) {
  SizeTimes times{};
  times.vertices = liver.vertex_count();
  times.tets = liver.tet_count();
  times.strict_hash = strict_hash(liver, executor);
  if (times.strict_hash != strict_hash(liver, executor::serial())) {
    throw Error("strict frames by " + executor.name() + " end otherwise than serial ones");
  }
  // after all that this process loads once, which no growth is to hold
  measure_frames(times, liver, executor, effort.frames);
  time_constructions(times, liver, executor, effort.constructions);
  return times;
}

}  // namespace pbdsurg::bench
