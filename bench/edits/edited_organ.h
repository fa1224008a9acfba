// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is measured: an organ in motion, and one that is edited.

#include <array>
#include <vector>

#include "pbdsurg/edit/live_pieces.h"
#include "pbdsurg/edit/live_surface.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"

#include "support/paper_step.h"
#include "support/repeated_step.h"
#include "support/timing.h"

namespace pbdsurg::bench {

/// An organ in motion.
struct Moving {
  Moving(const Scene& scene, const SolverOptions& options) : solver(scene, options) {
    solver.write_positions(stretched_positions(scene));
    step();  // takes the start to a device
  }

  /// @return  ms
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
        cautery(solver, std::array{ThermalBody{0, &mesh, tissues::gallbladder_wall().heat}}),
        surface(solver, 0),
        pieces(solver),
        participants{&cautery, &surface, &pieces} {}

  /// @return  ms
  double apply(const TopologyEdit& edit) {
    return time_of([&] { apply_edit(solver, edit, result, participants); });
  }

  Cautery cautery;
  LiveSurface surface;
  LivePieces pieces;
  std::vector<EditParticipant*> participants;
  EditResult result;
};

}  // namespace pbdsurg::bench
