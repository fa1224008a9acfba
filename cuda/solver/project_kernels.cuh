// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Projection of one stage: a thread a constraint.

#include <type_traits>

#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/methods/displacement.h"
#include "lib/solver/sets/constraint_kinds.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kStageThreads = 64;    // a colour is small: many blocks reach many multiprocessors
constexpr int kSerialThreads = 256;  // of the one block of a serial stage

/// What projections read and write beside their records.
struct Surroundings {
  Particle* moving;          ///< positions in fraction mode, else displacements
  const Particle* bases;     ///< in compliance mode, from where these count
  const Carry* carries;      ///< likewise
  FixedPoint* fixed_points;  ///< of the vertex-block method, else null
  Particle* flights;         ///< likewise
  const StepInput* input;
  float* multipliers;       ///< [Constraint::kMultiplierCount][multiplier_stride]
  Index multiplier_stride;  ///< how many records of this kind there are
  Index place_count;
  std::size_t multiplier_count;  ///< of a copy
  bool takes_multipliers;
  bool leaves_multipliers;
};

__device__ inline Surroundings of_copy(Surroundings around) {
  const std::size_t first = copy_index() * static_cast<std::size_t>(around.place_count);
  around.moving += first;
  around.bases += first;
  around.carries += first;
  if (around.fixed_points != nullptr) {
    around.fixed_points += first;
    around.flights += first;
  }
  around.input += copy_index();
  around.multipliers += copy_index() * around.multiplier_count;
  return around;
}

/// Makes the force of a stiff link a load of a vertex, as on the host.
__device__ inline void push_flight(Particle* flight, const Vec3<float>& force, float w,
                                   float inverse_dt_squared) {
  store_particle(flight,
                 position_of(load_particle(flight)) + pushed_flight(force, w, inverse_dt_squared),
                 kToLeastEnergy);
}

/// Records of a kind, which have all that it needs.
template <class Kind>
struct Source {
  using Constraint = Kind;
  const Record<Kind>* records;

  template <bool kDamped>
  __device__ void parameters(const Record<Kind>& record, Index,
                             float (&out)[Kind::kParameterCount]) const {
#pragma unroll
    for (int p = 0; p < Kind::kParameterCount; ++p) {
      out[p] = record.parameters[p];
    }
  }
};

template <>
struct Source<DistanceConstraint> {
  using Constraint = DistanceConstraint;
  const Record<Constraint>* records;
  const float* damping;

  template <bool kDamped>
  __device__ void parameters(const Record<Constraint>& record, Index i,
                             float (&out)[Constraint::kParameterCount]) const {
    out[Constraint::kRest] = record.parameters[Constraint::kRest];
    out[Constraint::kStiffness] = record.parameters[Constraint::kStiffness];
    out[Constraint::kDamping] = kDamped ? __ldg(damping + i) : 0.0F;
  }
};

/// The vertices of a constraint on their way through registers.
template <int kVertices, ProjectionMode kMode, bool kDamped>
struct Corners {
  static constexpr bool kDisplaces = kMode == ProjectionMode::compliance;

  Vec3<float> moving[kVertices];
  Vec3<float> bases[kVertices];      ///< in compliance mode
  Vec3<float> roundings[kVertices];  ///< where there is damping
  float w[kVertices];

  __device__ void load(const Surroundings& around, const Index (&places)[kVertices]) {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      const Particle p = load_particle(around.moving + places[k]);
      moving[k] = position_of(p);
      w[k] = p.w;
      if constexpr (kDisplaces) {
        bases[k] = position_of(load_particle(around.bases + places[k]));
      }
      if constexpr (kDamped) {
        const Carry carry = load_carry(around.carries + places[k]);
        roundings[k] = {carry.x, carry.y, carry.z};
      }
    }
  }
  __device__ void store(const Surroundings& around, const Index (&places)[kVertices]) const {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      store_particle(around.moving + places[k], moving[k], w[k]);
    }
  }

  template <class Constraint>
  __device__ void project(const float (&parameters)[Constraint::kParameterCount],
                          const Substep<float>& substep,
                          float (&multipliers)[Constraint::kMultiplierCount]) {
    Vec3<float> seen[kVertices];
    if constexpr (kDisplaces) {
      see_corners(bases, moving, seen);
    } else {
#pragma unroll
      for (int k = 0; k < kVertices; ++k) {
        seen[k] = moving[k];
      }
    }
    Moves<float, kVertices> moves;
    if constexpr (kDamped) {
      Damped<float, kVertices> damping;
      see_corners(bases, roundings, damping.start);
      moves = Constraint::template move<kMode>(seen, w, parameters, substep, multipliers, damping);
    } else {
      moves = Constraint::template move<kMode>(seen, w, parameters, substep, multipliers);
    }
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      moving[k] = moving[k] + moves.of[k];
    }
  }
};

template <class Records, ProjectionMode kMode, bool kDamped>
__device__ void project(const Records& source, const Record<typename Records::Constraint>& record,
                        Index i, const Surroundings& around) {
  using Constraint = typename Records::Constraint;
  Corners<Constraint::kVertexCount, kMode, kDamped> corners;
  corners.load(around, record.places);
  float parameters[Constraint::kParameterCount];
  source.template parameters<kDamped>(record, i, parameters);
  const Substep<float> substep = around.input->substep;
  float multipliers[Constraint::kMultiplierCount] = {};
  constexpr bool kKeeps = kRemembers<Constraint, kMode>;
  if (kKeeps && around.takes_multipliers) {
#pragma unroll
    for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
      multipliers[m] = __ldcg(around.multipliers + m * around.multiplier_stride + i);
    }
  }
  [[maybe_unused]] const Corners<Constraint::kVertexCount, kMode, kDamped> before = corners;
  [[maybe_unused]] Vec3<float> force_before;
  if constexpr (std::is_same_v<Constraint, StiffLinkConstraint>) {
    force_before = Constraint::force_of(multipliers);
  }
  corners.template project<Constraint>(parameters, substep, multipliers);
  corners.store(around, record.places);
  if constexpr (std::is_same_v<Constraint, StiffLinkConstraint>) {
    const Vec3<float> change = Constraint::force_of(multipliers) - force_before;
    push_flight(around.flights + record.places[0], change, before.w[0], substep.inverse_dt_squared);
    push_flight(around.flights + record.places[1], -1.0F * change, before.w[1],
                substep.inverse_dt_squared);
  }
  if constexpr (kMode == ProjectionMode::compliance && KindOf<Constraint>::kIsOfVertexBlocks) {
    if (around.fixed_points != nullptr) {
#pragma unroll
      for (int k = 0; k < Constraint::kVertexCount; ++k) {
        FixedPoint* const point = around.fixed_points + record.places[k];
        store_point(point, moved_point(load_point(point), before.moving[k], corners.moving[k]));
      }
    }
  }
  if (kKeeps && around.leaves_multipliers) {
#pragma unroll
    for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
      around.multipliers[m * around.multiplier_stride + i] = multipliers[m];
    }
  }
}

/// Records [first, first + count).
template <class Records, ProjectionMode kMode, bool kDamped>
__global__ void __launch_bounds__(kStageThreads)
    project_stage(Records source, Index first, Index count, Surroundings around) {
  const Index i = first + thread_index();
  const bool is_used = thread_index() < count;
  Record<typename Records::Constraint> record;
  if (is_used) {  // no kernel of this step writes it
    record = load_constant(source.records + i);
  }
  wait_for_previous();
  if (is_used && record.places[0] >= 0) {
    project<Records, kMode, kDamped>(source, record, i, of_copy(around));
  }
}

/// Level after level, by one block.
template <class Records, ProjectionMode kMode, bool kDamped>
__global__ void __launch_bounds__(kSerialThreads)
    project_levels(Records source, Index first, const Index* level_ends, Index level_count,
                   Surroundings around) {
  wait_for_previous();
  around = of_copy(around);
  for (Index level = 0; level < level_count; ++level) {
    const Index end = __ldg(level_ends + level);
    for (Index i = first + static_cast<Index>(threadIdx.x); i < end; i += kSerialThreads) {
      project<Records, kMode, kDamped>(source, load_constant(source.records + i), i, around);
    }
    first = end;
    __syncthreads();
  }
}

/// One edge of a tetrahedron, if it owns it. What it does not own is computed, too, and thrown
/// away: threads of a warp own different edges.
template <int kEdge, ProjectionMode kMode, bool kDamped>
__device__ void project_edge(const JointRecord& record, const Substep<float>& substep,
                             Corners<4, kMode, kDamped>& corners, float& multiplier) {
  constexpr int kEnds[2] = {kTetEdgeEnds[kEdge][0], kTetEdgeEnds[kEdge][1]};
  Corners<2, kMode, kDamped> ends;
#pragma unroll
  for (int k = 0; k < 2; ++k) {
    ends.moving[k] = corners.moving[kEnds[k]];
    ends.w[k] = corners.w[kEnds[k]];
    if constexpr (kMode == ProjectionMode::compliance) {
      ends.bases[k] = corners.bases[kEnds[k]];
    }
    if constexpr (kDamped) {
      ends.roundings[k] = corners.roundings[kEnds[k]];
    }
  }
  float parameters[DistanceConstraint::kParameterCount];
  parameters[DistanceConstraint::kRest] = record.edge_rest[kEdge];
  parameters[DistanceConstraint::kStiffness] = record.edge_stiffness[kEdge];
  parameters[DistanceConstraint::kDamping] = record.damping;
  float multipliers[1] = {multiplier};
  ends.template project<DistanceConstraint>(parameters, substep, multipliers);
  if (record.edge_rest[kEdge] >= 0) {
    corners.moving[kEnds[0]] = ends.moving[0];
    corners.moving[kEnds[1]] = ends.moving[1];
  }
  multiplier = multipliers[0];
}

template <ProjectionMode kMode, bool kDamped>
__global__ void __launch_bounds__(kStageThreads)
    project_joints(const JointRecord* records, Index first, Index count, Surroundings around) {
  const Index i = first + thread_index();
  const bool is_used = thread_index() < count;
  JointRecord record;
  if (is_used) {  // no kernel of this step writes it
    record = load_constant(records + i);
  }
  wait_for_previous();
  if (!is_used || record.places[0] < 0) {
    return;
  }
  around = of_copy(around);
  Corners<4, kMode, kDamped> corners;
  corners.load(around, record.places);
  const Substep<float> substep = around.input->substep;
  float multipliers[7] = {};
  if (kMode == ProjectionMode::compliance && around.takes_multipliers) {
#pragma unroll
    for (int m = 0; m < 7; ++m) {
      multipliers[m] = __ldcg(around.multipliers + m * around.multiplier_stride + i);
    }
  }
  project_edge<0, kMode, kDamped>(record, substep, corners, multipliers[0]);
  project_edge<1, kMode, kDamped>(record, substep, corners, multipliers[1]);
  project_edge<2, kMode, kDamped>(record, substep, corners, multipliers[2]);
  project_edge<3, kMode, kDamped>(record, substep, corners, multipliers[3]);
  project_edge<4, kMode, kDamped>(record, substep, corners, multipliers[4]);
  project_edge<5, kMode, kDamped>(record, substep, corners, multipliers[5]);
  float parameters[VolumeConstraint::kParameterCount];
  parameters[VolumeConstraint::kRest] = record.rest;
  parameters[VolumeConstraint::kStiffness] = record.stiffness;
  parameters[VolumeConstraint::kDamping] = record.damping;
  float volume_multiplier[1] = {multipliers[6]};
  corners.template project<VolumeConstraint>(parameters, substep, volume_multiplier);
  corners.store(around, record.places);
  if (kMode == ProjectionMode::compliance && around.leaves_multipliers) {
    multipliers[6] = volume_multiplier[0];
#pragma unroll
    for (int m = 0; m < 7; ++m) {
      around.multipliers[m * around.multiplier_stride + i] = multipliers[m];
    }
  }
}

template <class Records, ProjectionMode kMode, bool kDamped>
void launch_stage(const Records& source, const Stage& stage, const Index* level_ends,
                  const Surroundings& around, const Launch& how) {
  if (stage.level_count > 0) {
    launch(how, "launching a serial phase", 1, kSerialThreads,
           project_levels<Records, kMode, kDamped>, source, stage.first,
           level_ends + stage.first_level, stage.level_count, around);
  } else {
    launch(how, "launching a phase", blocks_for(stage.count, kStageThreads), kStageThreads,
           project_stage<Records, kMode, kDamped>, source, stage.first, stage.count, around);
  }
}

template <class Constraint>
void launch_stage(const Source<Constraint>& source, const Stage& stage, const Index* level_ends,
                  const Projection& projection, const Surroundings& around, const Launch& how) {
  using Kind = KindOf<Constraint>;
  using Records = Source<Constraint>;
  if (projection.mode == ProjectionMode::fraction) {
    if constexpr (Kind::kHasFraction) {  // else the scene was refused
      launch_stage<Records, ProjectionMode::fraction, false>(source, stage, level_ends, around,
                                                             how);
    }
  } else if (Kind::kHasCompliance && projection.is_damped) {
    launch_stage<Records, ProjectionMode::compliance, Kind::kHasCompliance>(
        source, stage, level_ends, around, how);
  } else {
    launch_stage<Records, ProjectionMode::compliance, false>(source, stage, level_ends, around,
                                                             how);
  }
}

template <ProjectionMode kMode, bool kDamped>
void launch_joints(const JointRecord* records, const Stage& stage, const Surroundings& around,
                   const Launch& how) {
  launch(how, "launching a joint phase", blocks_for(stage.count, kStageThreads), kStageThreads,
         project_joints<kMode, kDamped>, records, stage.first, stage.count, around);
}

template <class Constraint>
struct TypeOf {};

/// Calls launch(TypeOf<Constraint>()) for the kind that a stage has, if it has one.
template <class... Constraints>
struct Launcher {
  template <class Launch>
  static void launch(PhaseKind kind, Launch launch) {
    (void)((KindOf<Constraints>::kPhase == kind && (launch(TypeOf<Constraints>()), true)) || ...);
  }
};

void project(const Stage& stage, const Projection& projection, const DeviceState& state,
             const ConstraintArrays& constraints, const StepInput* input, const Launch& how) {
  const auto around = [&](float* multipliers, Index stride) {
    return Surroundings{moving_of(state),
                        state.particles,
                        state.carries,
                        state.fixed_points,
                        state.flights,
                        input,
                        multipliers,
                        stride,
                        state.capacity,
                        constraints.multiplier_count,
                        projection.takes_multipliers,
                        projection.leaves_multipliers};
  };
  if (stage.kind == PhaseKind::joint) {
    const Surroundings there = around(constraints.joint_multipliers, constraints.joint_count);
    if (projection.mode == ProjectionMode::fraction) {
      launch_joints<ProjectionMode::fraction, false>(constraints.joints, stage, there, how);
    } else if (projection.is_damped) {
      launch_joints<ProjectionMode::compliance, true>(constraints.joints, stage, there, how);
    } else {
      launch_joints<ProjectionMode::compliance, false>(constraints.joints, stage, there, how);
    }
  }
  ForAllConstraints<Launcher>::launch(stage.kind, [&]<class Constraint>(TypeOf<Constraint>) {
    const KindArrays<Constraint>& kind = constraints.of<Constraint>();
    Surroundings there = around(kind.multipliers, kind.count);
    if constexpr (std::is_same_v<Constraint, StiffLinkConstraint>) {  // see begin_joints()
      there.takes_multipliers = there.leaves_multipliers = true;
    }
    Source<Constraint> source{};
    source.records = kind.records;
    if constexpr (std::is_same_v<Constraint, DistanceConstraint>) {
      source.damping = constraints.distance_damping;
    }
    launch_stage(source, stage, constraints.level_ends, projection, there, how);
  });
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
