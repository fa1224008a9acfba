// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What is measured: an organ in motion, and one that is edited.

#include <array>
#include <memory>

#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "bench/support/paper_step.h"
#include "bench/support/repeated_step.h"
#include "bench/support/timing.h"

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

/// One that is edited, and all that follows its tissue.
struct Edited : Moving {
  Edited(const Scene& scene, const SolverOptions& options)
      : Moving(scene, options),
        cautery(solver.tissue(), std::array{ThermalBody{0, tissues::gallbladder_wall().heat}}),
        surface(shared_surface(solver.tissue(), 0)),
        pieces(solver.tissue()) {}

  /// @return  ms
  double apply(const TopologyEdit& edit) {
    return time_of([&] { solver.tissue().apply(edit); });
  }

  Cautery cautery;
  std::shared_ptr<const LiveSurface> surface;
  LivePieces pieces;
};

}  // namespace pbdsurg::bench
