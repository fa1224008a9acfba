// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The loops of a step over vector registers, compiled for several instruction sets from one source
/// (lane_kernels.cpp): plain functions over plain arrays. Each works on a part of its array, cut at
/// multiples of kBlockLanes, and gives every element the same bits wherever the cuts are.

#include "pbdsurg/base/types.h"
#include "pbdsurg/constraints/projection.h"

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
  Particle* particles;
  const Particle* previous;  ///< at the start of the substep; read with damping only
  Substep<float> substep;
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

/// Prediction, as the serial backend's. Vertices [first, last) of all.
struct VertexRange {
  Particle* particles;
  Particle* previous;
  Velocity* velocities;
  Index first;
  Index last;
};
/// What the vertex-block method keeps of them.
struct FallingRange {
  VertexRange vertices;
  Particle* flights;
  float* falling;
};
struct Prediction {
  float h;           ///< s
  float keep;        ///< share of the velocity that drag leaves
  Vec3<float> kick;  ///< m/s, of the external force
};

/// Those of all kinds.
template <class... Constraints>
struct AllConstraintKernels : ConstraintKernels<Constraints>... {};

/// All loops for one instruction set and one MathMode.
struct LaneKernels : ForAllConstraints<AllConstraintKernels> {
  const char* name;
  void (*predict)(const VertexRange&, const Prediction&);
  void (*update_velocities)(const VertexRange&, float inverse_h);

  /// Moves the vertices of a block. Returns the lanes that it has left alone: those that it was
  /// told to, and those at which something is not finite.
  LaneBits (*solve_vertices)(const VertexRows&, const VertexState&, Index block);

  /// As add_damping() of vertex_blocks.h, of blocks [first, last).
  void (*add_damping)(const DampedRows&, const Particle* start, float inverse_dt, Index first,
                      Index last);

  // StepOperation, of the vertex-block method
  void (*extrapolate)(const FallingRange&, const Vec3<float>& fall);
  void (*measure_fall)(const FallingRange&, const Vec3<float>& gravity_per_square,
                       float inverse_dt);
};

/// Those of the best instruction set that this processor has, of those that were compiled; null if
/// it has none of them.
const LaneKernels* choose_lane_kernels(bool fast);

}  // namespace pbdsurg
