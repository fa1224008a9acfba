// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The vertex-block method within a step. Nothing here does anything for other methods.

#include <span>
#include <string>
#include <vector>

#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/core/export.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/solver/solver.h"

#include "solver/particle.h"
#include "solver/vertex_blocks.h"

namespace pbdsurg {

class SolverData;

/// A tool's contact or grasp at a vertex.
struct VertexHold {
  Index place;  ///< of the vertex, see SolverData
  Index next;   ///< at the same vertex, or kInvalidIndex
  Index tool;
  Index entry;  ///< of its attachments or contacts
  bool is_contact;
};

/// What the method keeps between phases, for the copy at work; empty for other methods.
struct VertexMethod {
  VertexBlocks blocks;
  std::vector<Particle> flights;   ///< [vertex_count] m, where a vertex would be without its rows
  std::vector<Index> first_holds;  ///< [vertex_count] or kInvalidIndex
  std::vector<VertexHold> holds;   ///< of the current substep
  std::vector<LaneBits> held;      ///< [block_count] lanes of vertices with holds

  /// Bytes in use.
  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return blocks.memory_bytes() + flights.capacity() * sizeof(Particle) +
           first_holds.capacity() * sizeof(Index) + holds.capacity() * sizeof(VertexHold) +
           held.capacity() * sizeof(LaneBits);
  }
};

/// @throws InvalidArgument  if the options ask for this method and it cannot follow them, naming
///                          the option, the body or the link
void check_vertex_method(const Scene& scene, const SolverOptions& options);

/// @param what  the link's name
/// @throws InvalidArgument  as check_vertex_method()
void check_vertex_link(const SolverOptions& options, const std::string& what, const Link& link);

/// How it colours vertices: as asked, but by saturation where the order is the natural one, which
/// would be kept for want of a reason and takes up to twice the colours.
[[nodiscard]] ColoringOptions vertex_coloring(const SolverOptions& options);

/// What a scene's tetrahedra add to the energy; their vertices are left out. [tet_count]
[[nodiscard]] std::vector<VertexTet> vertex_tets_at_rest(const Scene& scene);

/// Colours vertices and lays out their rows.
/// @param data  with all else that a solver has
/// @param tets  [tet_count] their vertices are set here
[[nodiscard]] VertexMethod make_vertex_method(const SolverData& data, std::vector<VertexTet> tets);

/// Makes room for what tools can touch and hold, so that no step allocates.
void reserve_holds(SolverData& data);

// A substep: begin_vertices(), then the search for contacts; hold_vertices() and
// prepare_vertices(); sweeps; end_vertices() before velocities change. Kernels on registers stand
// in for some of these.

/// m, what gravity adds to the way of a substep.
[[nodiscard]] PBDSURG_API Vec3<float> way_of_fall(const SolverData& data,
                                                  const Substep<float>& substep) noexcept;

/// s^2/m, gravity over its square; zero without gravity.
[[nodiscard]] PBDSURG_API Vec3<float> gravity_per_square(const SolverData& data) noexcept;

/// After prediction: lets the sweeps start where vertices would be if they went on as they did.
/// What rests would else fall first, and sweeps that are too few would not bring it back.
void begin_vertices(SolverData& data, const Substep<float>& substep);

/// Finds out which vertices tools touch or hold.
void hold_vertices(SolverData& data);

/// Makes damping felt.
void prepare_vertices(SolverData& data, const Substep<float>& substep);

/// How far vertices go in a sweep, as a share of the way to their least energy.
[[nodiscard]] PBDSURG_API float relaxation_of(const SolverOptions& options, int iteration) noexcept;

[[nodiscard]] VertexState vertex_state(SolverData& data, const Substep<float>& substep,
                                       float relaxation) noexcept;

/// Moves some vertices of a block, one after another.
void solve_lanes(SolverData& data, const VertexState& state, Index block, LaneBits lanes);

/// Moves the vertices of one colour, one after another.
void solve_vertices(SolverData& data, const VertexState& state, Index color);

/// After the sweeps.
void end_vertices(SolverData& data, const Substep<float>& substep);

// What edits change; refresh_vertices() then makes it felt.
void set_vertex_rest_length(SolverData& data, Index distance, float length);
void set_vertex_rest_volume(SolverData& data, Index tet, float volume);
void remove_vertex_tet(SolverData& data, Index tet);
void remove_vertex_spring(SolverData& data, Index distance);
void refresh_vertices(SolverData& data);

/// After an edit that added constraints: lays all rows out anew and colours vertices again; those
/// from before go to the journal. Cost: O(vertex_count log vertex_count).
void regrow_vertices(SolverData& data);

/// Takes back the last edit, once all else is as it was before.
void undo_vertices(SolverData& data);

}  // namespace pbdsurg
