// SPDX-License-Identifier: Apache-2.0
#include "measure.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "pbdsurg/edit/live_pieces.h"
#include "pbdsurg/edit/live_surface.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/surgery/cautery.h"

#include "support/paper_step.h"
#include "support/repeated_step.h"
#include "support/timing.h"

namespace pbdsurg::bench {
namespace {

/// An organ in motion.
struct Moving {
  Moving(const Scene& scene, const SolverOptions& options) : solver(scene, options) {
    solver.write_positions(stretched_positions(scene));
    step();  // takes the start to a device
  }

  double step() {
    StepReport report;
    const double ms = time_of([&] { report = solver.step(kPaperTimeStep); });
    check_finite(report, solver);
    return ms;
  }

  Solver solver;
};

/// One that is edited, and all that follows its topology.
struct Edited : Moving {
  Edited(const TetMesh& mesh, const Scene& scene, const SolverOptions& options)
      : Moving(scene, options),
        cautery(solver, std::array{ThermalBody{0, &mesh, kGallbladderWall}}),
        surface(solver, 0),
        pieces(solver),
        participants{&cautery, &surface, &pieces} {}

  double remove(std::vector<Index> tets) {
    const TopologyEdit edit{.remove_tets = std::move(tets)};
    return time_of([&] { apply_edit(solver, edit, participants); });
  }

  Cautery cautery;
  LiveSurface surface;
  LivePieces pieces;
  std::vector<EditParticipant*> participants;
};

EditTimes measure_rate(Edited& edited, Moving& plain, Deletions& deletions, Pattern pattern,
                       int rate, int frames) {
  std::vector<double> plain_steps, steps, edits, per_deletion, added;
  EditTimes times{};
  times.pattern = pattern;
  times.deletions_per_s = rate;
  times.frames = frames;
  for (int frame = 0; frame < frames; ++frame) {
    const Index count = deletions_in_frame(rate, frame);
    plain_steps.push_back(plain.step());
    edits.push_back(count > 0 ? edited.remove(deletions.next(count)) : 0);
    per_deletion.push_back(count > 0 ? 1e3 * edits.back() / count : 0);
    times.deleted += count;
    steps.push_back(edited.step());
    added.push_back(edits.back() + steps.back() - plain_steps.back());
  }
  times.plain_step_ms = median(plain_steps);
  times.step_ms = median(steps);
  times.edit_ms = median(edits);
  times.us_per_deletion = median(per_deletion);
  times.added_ms = median(added);
  return times;
}

}  // namespace

EditRun measure_edits(const TetMesh& mesh, const SolverOptions& options, const EditEffort& effort) {
  const Scene scene = make_organ_scene(mesh);
  Moving plain(scene, options);
  EditRun run{plain.solver.plan().name, plain.solver.backend_name(), {}};
  for (const Pattern pattern : {Pattern::regional, Pattern::scattered}) {
    Edited edited(mesh, scene, options);
    Deletions deletions(mesh, pattern);
    for (const int rate : effort.rates) {
      const double most = effort.most_deleted * mesh.tet_count() * kFramesPerSecond;
      const int frames =
          rate > 0 ? std::min(effort.frames, static_cast<int>(most / rate)) : effort.frames;
      run.times.push_back(measure_rate(edited, plain, deletions, pattern, rate, frames));
    }
  }
  return run;
}

}  // namespace pbdsurg::bench
