// SPDX-License-Identifier: Apache-2.0
#include "bench/support/gpu_times.h"

#include <algorithm>
#include <cstdint>
#include <list>
#include <numeric>
#include <set>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/support/executors.h"
#include "bench/support/repeated_step.h"

namespace pbdsurg::bench {
namespace {

constexpr std::size_t kWatched = 200;       // vertices around a tool
constexpr float kRateTimeStep = 1e-3F;      // s
constexpr double kFarFromStrict = 1e-3;     // of an edge
constexpr int kSharesOfRate = 10;           // the first of which is run twice
constexpr double kBytesOfVertex = 16 + 16;  // read and written
constexpr double kBytesOfDistance = 16 + 2 * kBytesOfVertex;
constexpr double kBytesOfVolume = 32 + 4 * kBytesOfVertex;
constexpr double kBytesOfJoint = 80 + 4 * kBytesOfVertex;

SolverOptions on_gpu(SolverOptions plan, DeviceStrategy strategy) {
  plan.executor = programs::device();
  plan.device_strategy = strategy;
  return plan;
}

// The vertices around the end that hangs free.
std::vector<Index> tool_neighborhood(const Scene& scene) {
  const auto positions = scene.positions();
  const Eigen::Vector3d tip = *std::max_element(
      positions.begin(), positions.end(),
      [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a.x() < b.x(); });
  std::vector<Index> vertices(positions.size());
  std::iota(vertices.begin(), vertices.end(), Index{0});
  const std::size_t count = std::min(kWatched, vertices.size());
  std::partial_sort(vertices.begin(), vertices.begin() + static_cast<std::ptrdiff_t>(count),
                    vertices.end(), [&](Index a, Index b) {
                      const double distance_a = (positions[a] - tip).squaredNorm();
                      const double distance_b = (positions[b] - tip).squaredNorm();
                      return std::pair(distance_a, a) < std::pair(distance_b, b);
                    });
  vertices.resize(count);
  return vertices;
}

// Of a name "cuda, DEVICE, STRATEGY, MATH".
std::string strategy_of(const Solver& solver) {
  const std::string name = solver.backend_name();
  const std::size_t end = name.rfind(", ");
  const std::size_t begin = name.rfind(", ", end - 1) + 2;
  return name.substr(begin, end - begin);
}

struct Candidate {
  SolverOptions options;
  RepeatedStep step;
};

// Plans and strategies that differ and can be had here; automatic ones come first.
std::list<Candidate> make_candidates(const Scene& scene, const StepConditions& conditions) {
  std::list<Candidate> candidates;
  std::set<std::pair<std::string, std::string>> seen;  // plan, strategy
  std::string why_not;
  for (const DeviceStrategy strategy :
       {DeviceStrategy::automatic, DeviceStrategy::graph, DeviceStrategy::cluster}) {
    for (const PlanComposition composition : {PlanComposition::separate, PlanComposition::joint}) {
      for (const bool balance : {false, true}) {
        SolverOptions plan = SolverOptions::paper();
        plan.coloring = {.repair = true, .balance = balance};
        plan.composition = composition;
        const SolverOptions options = on_gpu(plan, strategy);
        try {
          RepeatedStep step(scene, options, conditions);
          if (seen.emplace(step.solver().plan().name, strategy_of(step.solver())).second) {
            candidates.push_back({options, std::move(step)});
          }
        } catch (const BackendUnavailable& error) {
          why_not = error.what();
        }
      }
    }
  }
  if (candidates.empty()) {
    throw BackendUnavailable(why_not);
  }
  return candidates;
}

SolverOptions find_fastest(const Scene& scene, const StepConditions& conditions, int rounds) {
  std::list<Candidate> candidates = make_candidates(scene, conditions);
  for (int round = 0; round < rounds; ++round) {
    for (Candidate& candidate : candidates) {
      candidate.step.run();
    }
  }
  return std::min_element(candidates.begin(), candidates.end(),
                          [](const Candidate& a, const Candidate& b) {
                            return median(a.step.times()) < median(b.step.times());
                          })
      ->options;
}

double mean_edge_length(const Scene& scene, const Solver& solver) {
  double sum = 0;
  for (const auto& [a, b] : solver.tissue().edges()) {
    sum += (scene.positions()[a] - scene.positions()[b]).norm();
  }
  for (const Link& link : solver.tissue().links()) {
    sum += link.rest_length;
  }
  return sum / static_cast<double>(solver.tissue().edges().size() + solver.tissue().links().size());
}

// Strict steps must end as on the serial backend, bit by bit; returns how far fast ones end from
// there, in edges.
double check_against_serial(const Scene& scene, const RepeatedStep& fast,
                            const SolverOptions& options, const StepConditions& conditions) {
  SolverOptions strict_options = options;
  strict_options.math = MathMode::strict;
  SolverOptions serial_options = options;
  serial_options.executor = executor::serial();
  serial_options.device_strategy = DeviceStrategy::automatic;
  RepeatedStep strict(scene, strict_options, conditions);
  RepeatedStep serial(scene, serial_options, conditions);
  strict.run();
  strict.run();
  serial.run();
  expect_same_end(strict, std::string("in strict mode on ") + strict.solver().backend_name(),
                  serial, "on the serial backend");

  const std::vector<Eigen::Vector3f> actual = fast.solver().positions();
  const std::vector<Eigen::Vector3f> expected = serial.solver().positions();
  float distance = 0;
  for (std::size_t v = 0; v < actual.size(); ++v) {
    distance = std::max(distance, (actual[v] - expected[v]).norm());
  }
  const double in_edges = distance / mean_edge_length(scene, serial.solver());
  if (in_edges > kFarFromStrict) {
    throw Error("a step of plan " + fast.solver().plan().name + " on backend " +
                fast.solver().backend_name() + " ends " + std::to_string(in_edges) +
                " edges from where strict arithmetic does");
  }
  return in_edges;
}

void check_watched(const Solver& solver, const std::vector<Index>& watched) {
  std::vector<Eigen::Vector3f> expected(watched.size());
  solver.read_positions(watched, expected);
  const auto actual = solver.watched_positions();
  if (!std::equal(actual.begin(), actual.end(), expected.begin(), expected.end())) {
    throw Error(std::string("backend ") + solver.backend_name() +
                ": watched vertices are not where all are read");
  }
}

// The first steps are run twice and must end in the same state.
Rate measure_rate(const Scene& scene, const SolverOptions& options,
                  const std::vector<Index>& watched, int steps) {
  Solver solver(scene, options);
  solver.write_positions(stretched_positions(scene));
  solver.watch(watched);
  const Snapshot start = solver.snapshot();
  const auto step = [&] { check_finite(solver.step(kRateTimeStep), solver); };
  const int repeated = std::max(steps / kSharesOfRate, 1);
  std::uint64_t expected = 0;
  for (int i = 0; i <= repeated; ++i) {
    step();
  }
  expected = solver.state_hash();

  solver.restore(start);
  step();  // takes the start to the device
  std::vector<double> times;
  for (int i = 0; i < steps; ++i) {
    times.push_back(time_of(step));
    if (i + 1 == repeated && solver.state_hash() != expected) {
      throw Error(std::to_string(repeated) + " steps of plan " + solver.plan().name +
                  " on backend " + solver.backend_name() + " end otherwise when they are repeated");
    }
  }
  check_watched(solver, watched);
  return {steps,
          static_cast<int>(std::count_if(times.begin(), times.end(),
                                         [](double ms) { return ms > 1e3 * kRateTimeStep; })),
          statistics(times), *std::max_element(times.begin(), times.end())};
}

}  // namespace

std::optional<std::string> why_no_gpu() {
  const Eigen::Vector3d positions[] = {{0, 0, 0}, {1e-3, 0, 0}};
  Scene scene;
  scene.add_particles("thread", positions, 1e-3);
  scene.add_link({0, 1, 1e-3F, {}});
  try {
    SolverOptions options;
    options.executor = programs::device();
    const Solver solver(scene, options);
    return std::nullopt;
  } catch (const BackendUnavailable& error) {
    return error.what();
  }
}

double swept_bytes(const Solver& solver) {
  const auto edges = static_cast<double>(solver.tissue().edges().size());
  const auto links = static_cast<double>(solver.tissue().links().size());
  const auto tets = static_cast<double>(solver.tissue().tets().size());
  const bool is_joint = solver.options().composition == PlanComposition::joint;
  const double sweep = is_joint ? links * kBytesOfDistance + tets * kBytesOfJoint
                                : (edges + links) * kBytesOfDistance + tets * kBytesOfVolume;
  return solver.options().substeps * solver.options().iterations * sweep;
}

GpuTimes measure_on_gpu(const Scene& scene, const GpuEffort& effort) {
  const StepConditions resident{1, tool_neighborhood(scene)};
  StepConditions copied = resident;
  copied.copies = true;
  const SolverOptions options = find_fastest(scene, resident, effort.pilot_rounds);
  const SolverOptions stream_options = on_gpu(SolverOptions::paper(), DeviceStrategy::stream);
  RepeatedStep fastest(scene, options, resident);
  RepeatedStep with_copies(scene, options, copied);
  RepeatedStep stream(scene, stream_options, resident);
  for (int round = 0; round < effort.rounds; ++round) {
    fastest.run();
    with_copies.run();
    stream.run();
  }
  check_watched(fastest.solver(), resident.watched);
  static_cast<void>(check_against_serial(scene, stream, stream_options, resident));
  const Solver& solver = fastest.solver();
  const std::string strategy = strategy_of(solver);
  return {solver.backend_name(),
          solver.plan().name,
          strategy,
          options.device_strategy == DeviceStrategy::automatic,
          static_cast<Index>(solver.plan().phases.size()),
          static_cast<Index>(stream.solver().plan().phases.size()),
          static_cast<Index>(resident.watched.size()),
          effort.rounds,
          statistics(fastest.times()),
          statistics(with_copies.times()),
          statistics(stream.times()),
          median_ratio(stream.times(), fastest.times()),
          check_against_serial(scene, fastest, options, resident),
          strategy == "cluster" ? std::nullopt : std::optional(swept_bytes(solver)),
          measure_rate(scene, options, resident.watched, effort.rate_steps)};
}

}  // namespace pbdsurg::bench
