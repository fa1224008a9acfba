// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step as data: what happens in each of its substeps. A method writes it, an executor runs it.

#include <algorithm>
#include <cstdint>
#include <span>

#include "pbdsurg/base/export.h"
#include "pbdsurg/solver/solver_options.h"

#include "lib/solver/substep_rule.h"

namespace pbdsurg {

/// A part of a substep. The serial backend defines what each does; an executor may join neighbours,
/// and leave out what changes nothing.
enum class StepOperation : std::uint8_t {
  take_lengths,           ///< where the substep before counts: see substep_numbers()
  recall_past,            ///< of BDF2: takes that substep into account, see displacement.h
  predict_positions,      ///< keeps where vertices are; they go on under gravity and drag
  predict_displacements,  ///< the same without moving them: see displacement.h
  clear_multipliers,      ///< of constraints with compliances
  find_contacts,          ///< moves the tools, and finds the vertices that they touch; and which
                          ///< bodies touch each other
  gather_holds,           ///< finds what tools do to each vertex
  damp_rows,              ///< gives the rows of vertices this substep's damping
  meet_surfaces,          ///< finds how stiffly vertices meet the surfaces of tools and bodies
  begin_joints,           ///< finds the forces of stiff links and of custom constraints
  sweep,                  ///< all sweeps of all phases; a coarse correction after the first
  push,               ///< of explicit steps: vertices follow the forces of the start, all at once
  settle_holds,       ///< what tools touch or hold answers what stiff links did last, and leaves
                      ///< their surfaces; bodies leave each other
  keep_momentum,      ///< of pieces that nothing holds: see momentum.h
  stop_passing,       ///< what has come through a tool goes along with it instead
  collect_forces,     ///< adds what pushed back to the forces of tools
  update_velocities,  ///< from the way of the substep
  settle,             ///< vertices go where displacements lead; velocities from these
  keep_past,          ///< of BDF2: for the next recall_past
  ease_contacts,      ///< of BDF2: what tools and bodies push does not spring back
};

struct StepProgram {
  std::span<const StepOperation> operations;  ///< of one substep, in order; lives for ever
  StepDivision division;

  bool operator==(const StepProgram& other) const noexcept {
    return division == other.division && std::ranges::equal(operations, other.operations);
  }
};

/// What the method of the options does in a step, or a part of one, that is so divided.
[[nodiscard]] PBDSURG_API StepProgram step_program(const SolverOptions& options,
                                                   const StepDivision& division) noexcept;

/// The loop over substeps of a part of a step, of every executor.
/// @param run  called with an operation and its substep, 0 to substeps - 1
template <class Run>
void run_step(const StepProgram& program, Run run) {
  for (int substep = 0; substep < program.division.substeps; ++substep) {
    for (const StepOperation operation : program.operations) {
      run(operation, substep);
    }
  }
}

}  // namespace pbdsurg
