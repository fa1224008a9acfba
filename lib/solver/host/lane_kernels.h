// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The loops of a step over vector registers, compiled for several instruction sets from one source
/// (lane_kernels.cpp): plain functions over plain arrays. Each works on a part of its array, cut at
/// multiples of kBlockLanes, and gives every element the same bits wherever the cuts are.

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/energy_block.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/sets/constraint_block.h"
#include "lib/solver/sets/constraint_kinds.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg {

/// A part of one group of constraints: blocks [first, last) of those that hold `size` constraints.
template <class Constraint>
struct BlockRange {
  const ConstraintBlock<Constraint>* blocks;
  MultiplierBlock<Constraint>* multipliers;
  Index size;
  Index first;
  Index last;
};

/// What projections read and write beside their constraints.
struct ProjectionState {
  Particle* moving;       ///< positions in fraction mode, else displacements
  const Particle* bases;  ///< from where these count; read in compliance mode only
  const Carry* carries;   ///< read with damping only
  Substep<float> substep;
  FixedPoint* fixed_points;  ///< of the vertex-block method, else null
  Particle* flights;         ///< likewise
  float unit;                ///< m, of fixed points
};

/// What has been seen of the values of constraints.
struct Residual {
  float largest = 0;   ///< |C| / rest; infinite when one is not a number
  Index inverted = 0;  ///< constraints whose measure is negative
};

/// Loops over one type of constraint; null where it has no such mode or nothing to report.
template <class Constraint>
struct ConstraintKernels {
  using Project = void(const BlockRange<Constraint>&, const ProjectionState&);
  using Measure = Residual(const BlockRange<Constraint>&, const Particle*);

  Project* project_fraction;
  Project* project_compliance;
  Project* project_damped;
  Measure* measure;
};

/// Vertices [first, last) of all.
struct VertexRange {
  Particle* particles;
  Particle* previous;        ///< in fraction mode
  Particle* displacements;   ///< in compliance mode
  Particle* flights;         ///< of the vertex-block method, else null
  FixedPoint* fixed_points;  ///< likewise
  bool starts;               ///< whether these are where vertices start, else where they fly
  float unit;                ///< m, of these
  Velocity* velocities;
  Carry* carries;   ///< in compliance mode
  Load* forces;     ///< null: none
  Load* gravities;  ///< null: that of all
  Index first;
  Index last;
};

/// Those of all kinds.
template <class... Constraints>
struct AllConstraintKernels : ConstraintKernels<Constraints>... {};

/// All loops for one instruction set and one MathMode.
struct LaneKernels : ForAllConstraints<AllConstraintKernels> {
  const char* name;

  // StepOperation
  void (*predict_positions)(const VertexRange&, const FreeMotion<float>&);
  void (*update_velocities)(const VertexRange&, const FreeMotion<float>&);
  void (*predict_displacements)(const VertexRange&, const FreeMotion<float>&);
  void (*settle)(const VertexRange&, const FreeMotion<float>&);

  /// Moves the vertices of a block. Returns the lanes that it has left alone: those that it was
  /// told to, and those at which something is not finite; their energies it stores.
  LaneBits (*solve_vertices)(const VertexRows&, const VertexState&, Index block,
                             EnergyBlock& energies);

  /// Likewise of explicit steps, by the forces where the substep starts.
  LaneBits (*push_vertices)(const VertexRows&, const VertexState&, Index block);

  /// As find_residuals() of the vertices of a block.
  void (*find_residuals)(const VertexRows&, const VertexState&, Index block, Particle* residuals);

  /// As displace(), of a range.
  void (*displace)(const VertexRange&, Particle* moves);

  /// As stiffest_vertex(), of blocks [first, last). How a step is divided is to be the same for all
  /// executors, so the strict one of these serves both modes.
  float (*stiffest)(const VertexRows&, const Particle* bases, const Velocity*, float heading,
                    const float* shares, Index first, Index last);

  /// Finds how vertices of a block give way to their stiff links, or to contacts. Returns those of
  /// the lanes at which something is not finite. It writes those that nobody asked for, too.
  LaneBits (*find_loose_ends)(const VertexRows&, const VertexState&, const LinkEnds&, Index block,
                              LaneBits lanes);

  /// From these, finds the forces of stiff links, and makes them loads of their ends.
  void (*begin_joints)(const BlockRange<StiffLinkConstraint>&, const ProjectionState&,
                       const LinkEnds&);

  /// As damp_rows(), of blocks [first, last); of those with strips, these in place of volumes.
  void (*damp_rows)(const DampedRows&, const Particle* bases, const Carry*, float inverse_dt,
                    Index first, Index last);

  /// The volumes that damp_rows() leaves out, of a block whose lanes others move; null if it leaves
  /// none.
  void (*damp_volumes)(const DampedRows&, const Particle* bases, const Carry*, float inverse_dt,
                       Index block);
};

/// Those of the best instruction set that this processor has, of those that were compiled; null if
/// it has none of them.
const LaneKernels* choose_lane_kernels(bool fast);

}  // namespace pbdsurg
