// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/program/step_program.h"

#include <algorithm>
#include <array>

namespace pbdsurg {
namespace {

using enum StepOperation;

// Position-based dynamics (Mueller et al. 2007, algorithm 1): factors have no memory.
constexpr std::array kFractionProjections{predict_positions, find_contacts,  sweep,
                                          stop_passing,      collect_forces, update_velocities};

// With compliances (Macklin et al. 2016, algorithm 1).
constexpr std::array kComplianceProjections{
    predict_displacements, clear_multipliers, find_contacts, sweep,
    stop_passing,          collect_forces,    settle};

// Vertex block descent (Chen et al. 2024, algorithm 1).
constexpr std::array kVertexBlocks{
    predict_displacements, find_contacts, gather_holds,   damp_rows,
    meet_surfaces,         begin_joints,  sweep,          settle_holds,
    keep_momentum,         stop_passing,  collect_forces, settle};

// Leapfrog (Verlet 1967).
constexpr std::array kExplicit{take_lengths, predict_displacements, find_contacts,  gather_holds,
                               push,         stop_passing,          collect_forces, settle};

// Vertex blocks or projections by BDF2: an implicit Euler substep of what velocities and positions
// are once the substep before is taken into account.
template <std::size_t kCount>
constexpr std::array<StepOperation, kCount + 4> with_past(
    const std::array<StepOperation, kCount>& operations) {
  std::array<StepOperation, kCount + 4> all{take_lengths, recall_past};
  std::ranges::copy(operations, all.begin() + 2);
  all[kCount + 2] = keep_past;
  all[kCount + 3] = ease_contacts;
  return all;
}

constexpr auto kComplianceProjectionsWithPast = with_past(kComplianceProjections);
constexpr auto kVertexBlocksWithPast = with_past(kVertexBlocks);

}  // namespace

StepProgram step_program(const SolverOptions& options, const StepDivision& division) noexcept {
  const bool has_past = options.integration == TimeIntegration::bdf2;
  if (options.method == SolverMethod::explicit_steps) {
    return {kExplicit, division};
  }
  if (options.method == SolverMethod::vertex_block) {
    return has_past ? StepProgram{kVertexBlocksWithPast, division}
                    : StepProgram{kVertexBlocks, division};
  }
  if (has_past) {
    return {kComplianceProjectionsWithPast, division};
  }
  return options.mode == ProjectionMode::fraction ? StepProgram{kFractionProjections, division}
                                                  : StepProgram{kComplianceProjections, division};
}

}  // namespace pbdsurg
