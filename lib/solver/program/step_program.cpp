// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/program/step_program.h"

#include <array>

namespace pbdsurg {
namespace {

using enum StepOperation;

// Position-based dynamics (Mueller et al. 2007, algorithm 1): factors have no memory.
constexpr std::array kFractionProjections{predict_positions, find_contacts, sweep, collect_forces,
                                          update_velocities};

// With compliances (Macklin et al. 2016, algorithm 1).
constexpr std::array kComplianceProjections{
    predict_displacements, clear_multipliers, find_contacts, sweep, collect_forces, settle};

// Vertex block descent (Chen et al. 2024, algorithm 1).
constexpr std::array kVertexBlocks{
    predict_displacements, find_contacts, gather_holds,   damp_rows, begin_joints, sweep,
    settle_holds,          keep_momentum, collect_forces, settle};

}  // namespace

StepProgram step_program(const SolverOptions& options, const StepDivision& division) noexcept {
  if (options.method == SolverMethod::vertex_block) {
    return {kVertexBlocks, division};
  }
  return options.mode == ProjectionMode::fraction ? StepProgram{kFractionProjections, division}
                                                  : StepProgram{kComplianceProjections, division};
}

}  // namespace pbdsurg
