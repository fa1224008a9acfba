// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a cut costs, beside the step.

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg::bench {

/// Medians over the frames in which tissue parted, if nothing else is said.
struct CutTimes {
  int frames;
  Index divided;         ///< tetrahedra, in all
  Index added;           ///< parts that took their place, in all
  double plain_step_ms;  ///< of a solver that is not edited, which takes turns
  double plan_ms;        ///< plan_cut()
  double edit_ms;        ///< the whole transaction
  double us_per_added;
  double step_ms;   ///< that follows an edit
  double added_ms;  ///< by which the edit and the step exceed the plain one
  double longest_edit_ms;
  double longest_step_ms;    ///< as where buffers are made anew
  double last_step_ms;       ///< of steps after the last frame
  Index phases;              ///< of a sweep, then
  double compacted_step_ms;  ///< of steps after a Compaction: what edited colours and memory cost
  Index compacted_phases;
};

/// Steps the scene of a mesh, and before each step lets a blade on through it, in one edit, in
/// which all that follows topology takes part.
/// @param options  to which spare room is added
/// @throws Error  if a step leaves vertices that are not finite
[[nodiscard]] CutTimes measure_cuts(const TetMesh& mesh, const Material& material,
                                    SolverOptions options, int frames);

}  // namespace pbdsurg::bench
