// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The vertex-block method: its rows, and its operations within a step (step_program.h).

#include <span>
#include <vector>

#include "pbdsurg/base/export.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/solver_options.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/energy_block.h"
#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/program/step_scratch.h"

namespace pbdsurg {

class SolverData;

/// What an automatic method is: this one, if it can follow the options and the materials; else
/// projections. Any other method stays.
[[nodiscard]] SolverMethod method_for(std::span<const Body> bodies, const SolverOptions& options);

/// @throws InvalidArgument  if the options ask for this method and it cannot follow them, naming
///                          the option or the body
void check_vertex_method(std::span<const Body> bodies, const SolverOptions& options);

/// How it colours vertices: as asked, but by saturation where the order is the natural one, which
/// would be kept for want of a reason and takes up to twice the colours. After repair VertexBlocks
/// search for fewer colours.
[[nodiscard]] ColoringOptions vertex_coloring(const SolverOptions& options);

/// Colours vertices and lays out their rows.
/// @param data  with all else that a solver has
/// @param tets  [tet_count] their vertices are set here
/// @return      none for other methods
[[nodiscard]] VertexBlocks make_vertex_blocks(const SolverData& data, std::vector<VertexTet> tets);

// Operations of a substep. Kernels on registers stand in for some of these.

/// The rows that a worker's sweeps read, and those that it damps.
[[nodiscard]] VertexRows vertex_rows(const StepContext& step) noexcept;
[[nodiscard]] DampedRows damped_rows(const StepContext& step) noexcept;

/// Finds out which vertices tools touch or hold; at the end of a step nobody may hold any.
void gather_holds(const StepContext& step);
void drop_holds(const StepContext& step) noexcept;

/// Makes damping felt.
void damp_rows(const StepContext& step, float inverse_dt);

/// How far vertices go in a sweep, as a share of the way to their least energy.
[[nodiscard]] PBDSURG_API float relaxation_of(float over_relaxation, int sweep,
                                              int sweep_count) noexcept;

[[nodiscard]] VertexState vertex_state(const StepContext& step, const Substep<float>& substep,
                                       float relaxation) noexcept;

/// Moves some vertices of a block, one after another.
/// @param energies  of these, but for what holds them; null: found anew
void solve_lanes(const StepContext& step, const VertexState& state, Index block, LaneBits lanes,
                 const EnergyBlock* energies = nullptr);

/// Of explicit steps: moves some vertices of a block, or all of all blocks, by forces of the start.
void push_lanes(const StepContext& step, const VertexState& state, Index block, LaneBits lanes);
void push_vertices(const StepContext& step, const VertexState& state);

/// Finds the forces out of balance at the vertices of a block, N; of a coarse correction.
void find_residuals(const StepContext& step, const VertexState& state, Index block);

/// Whether what tools touch or hold has to move once more after the sweeps: a stiff link at such a
/// vertex pulls it last, and tools have not felt that yet.
[[nodiscard]] bool has_holds_to_settle(const StepContext& step) noexcept;

/// Moves them, colour by colour, and has grips answer that.
void settle_holds(const StepContext& step, const VertexState& state, const Substep<float>& lengths);

/// Moves the vertices of one colour, one after another.
void solve_vertices(const StepContext& step, const VertexState& state, Index color);

}  // namespace pbdsurg
