// SPDX-License-Identifier: Apache-2.0
#include "bench/edits/measure.h"

#include <algorithm>
#include <utility>

#include "bench/edits/edited_organ.h"

namespace pbdsurg::bench {
namespace {

struct Frame {
  double edit_ms = 0;
  double ms;  // of all
};

// A step, and an edit before it or, if the backend steps by itself, meanwhile.
Frame remove_and_step(Edited& edited, std::vector<Index> tets, bool overlaps) {
  const TopologyEdit edit{.remove_tets = std::move(tets)};
  Frame frame;
  StepReport report;
  const auto remove = [&] {
    if (!edit.remove_tets.empty()) {
      frame.edit_ms = edited.apply(edit);
    }
  };
  frame.ms = time_of([&] {
    if (!overlaps) {
      remove();
    }
    edited.solver.start_step(kPaperTimeStep);
    if (overlaps) {
      remove();
    }
    report = edited.solver.finish_step();
  });
  check_finite(report, edited.solver);
  return frame;
}

EditTimes measure_rate(Edited& edited, Moving& plain, Deletions& deletions, Pattern pattern,
                       int rate, int frames, bool overlaps) {
  std::vector<double> plain_steps, steps, edits, per_deletion, added;
  EditTimes times{};
  times.pattern = pattern;
  times.deletions_per_s = rate;
  times.frames = frames;
  for (int frame = 0; frame < frames; ++frame) {
    const Index count = deletions_in_frame(rate, frame);
    plain_steps.push_back(plain.step());
    const Frame both = remove_and_step(edited, deletions.next(count), overlaps);
    edits.push_back(both.edit_ms);
    per_deletion.push_back(count > 0 ? 1e3 * both.edit_ms / count : 0);
    times.deleted += count;
    steps.push_back(overlaps ? both.ms : both.ms - both.edit_ms);
    added.push_back(both.ms - plain_steps.back());
  }
  times.plain_step_ms = median(plain_steps);
  times.step_ms = median(steps);
  times.edit_ms = median(edits);
  times.us_per_deletion = median(per_deletion);
  times.added_ms = median(added);
  return times;
}

}  // namespace

EditRun measure_edits(const TetMesh& mesh, const Material& material, const SolverOptions& options,
                      const EditEffort& effort) {
  const Scene scene = make_organ_scene(mesh, material);
  Moving plain(scene, options);
  EditRun run{plain.solver.plan().name, plain.solver.backend_name(), false, {}, {}};
  run.overlaps = run.backend.starts_with("cuda");
  for (const Pattern pattern : {Pattern::regional, Pattern::scattered}) {
    Edited edited(scene, options);
    Deletions deletions(mesh, pattern);
    for (const int rate : effort.rates) {
      const double most = effort.most_deleted * mesh.tet_count() * kFramesPerSecond;
      const int frames =
          rate > 0 ? std::min(effort.frames, static_cast<int>(most / rate)) : effort.frames;
      run.times.push_back(
          measure_rate(edited, plain, deletions, pattern, rate, frames, run.overlaps));
    }
  }
  if (effort.cut_frames > 0) {
    run.cut = measure_cuts(mesh, material, options, effort.cut_frames);
  }
  return run;
}

}  // namespace pbdsurg::bench
