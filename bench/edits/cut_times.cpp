// SPDX-License-Identifier: Apache-2.0
#include "bench/edits/cut_times.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <vector>

#include "pbdsurg/solver/compaction.h"

#include "bench/edits/blade.h"
#include "bench/edits/edited_organ.h"

namespace pbdsurg::bench {
namespace {

// What some hundred frames bring.
constexpr SpareRoom kSpare{.vertices = 8000, .tets = 24'000, .edges = 40'000, .links = 0};

// Steps after the last cut, and the phases of their sweeps.
std::pair<double, Index> measure_steps(Edited& edited) {
  constexpr int kSteps = 30;
  std::vector<double> steps;
  for (int i = 0; i < kSteps; ++i) {
    steps.push_back(edited.step());
  }
  return {median(steps), static_cast<Index>(edited.solver.plan().phases.size())};
}

}  // namespace

CutTimes measure_cuts(const TetMesh& mesh, const Material& material, SolverOptions options,
                      int frames) {
  const Scene scene = make_organ_scene(mesh, material);
  Moving plain(scene, options);
  options.spare = kSpare;
  Edited edited(scene, options);
  Blade blade(mesh, stretched_positions(scene));
  CutFront front;
  CutTimes times{};
  std::vector<double> plain_steps, plans, edits, per_added, steps, added;
  for (int frame = 0; frame < frames || edits.empty(); ++frame) {
    const double plain_ms = plain.step();
    const Blade::Way way = blade.next();
    CutPlan plan;
    const double plan_ms = time_of([&] {
      const CutOptions cut{.front = way.begins ? CutFront{} : std::move(front)};
      plan = plan_cut(edited.solver, way.surface, cut);
    });
    front = std::move(plan.front);
    const auto count = static_cast<Index>(plan.edit.new_tets.size());
    if (count == 0) {
      edited.step();
      continue;
    }
    plain_steps.push_back(plain_ms);
    plans.push_back(plan_ms);
    edits.push_back(edited.apply(plan.edit));
    steps.push_back(edited.step());
    per_added.push_back(1e3 * edits.back() / count);
    added.push_back(edits.back() + steps.back() - plain_ms);
    times.added += count;
    times.divided += static_cast<Index>(edited.solver.tissue().last_change().removed_tets.size());
  }
  times.frames = static_cast<int>(edits.size());
  times.plain_step_ms = median(plain_steps);
  times.plan_ms = median(plans);
  times.edit_ms = median(edits);
  times.us_per_added = median(per_added);
  times.step_ms = median(steps);
  times.added_ms = median(added);
  times.longest_edit_ms = std::ranges::max(edits);
  times.longest_step_ms = std::ranges::max(steps);
  std::tie(times.last_step_ms, times.phases) = measure_steps(edited);
  Compaction compaction(edited.solver);
  compaction.build();
  static_cast<void>(compaction.finish(edited.solver));
  edited.step();  // takes what is new to a device
  std::tie(times.compacted_step_ms, times.compacted_phases) = measure_steps(edited);
  return times;
}

}  // namespace pbdsurg::bench
