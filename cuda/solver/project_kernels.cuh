// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Projection of one stage: a thread a constraint.

#include <type_traits>

#include "cuda/solver/kernel_support.cuh"
#include "lib/solver/sets/constraint_kinds.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

constexpr int kStageThreads = 64;    // a colour is small: many blocks reach many multiprocessors
constexpr int kSerialThreads = 256;  // of the one block of a serial stage

/// What projections read and write beside their records.
struct Surroundings {
  Particle* particles;
  const Particle* previous;
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
  around.particles += first;
  around.previous += first;
  around.multipliers += copy_index() * around.multiplier_count;
  return around;
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
template <int kVertices>
struct Corners {
  Vec3<float> x[kVertices];
  float w[kVertices];

  __device__ void load(const Particle* particles, const Index (&places)[kVertices]) {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      const Particle p = load_particle(particles + places[k]);
      x[k] = position_of(p);
      w[k] = p.w;
    }
  }
  __device__ void store(Particle* particles, const Index (&places)[kVertices]) const {
#pragma unroll
    for (int k = 0; k < kVertices; ++k) {
      store_particle(particles + places[k], x[k], w[k]);
    }
  }
};

template <int kVertices>
__device__ Damped<float, kVertices> load_start(const Particle* previous,
                                               const Index (&places)[kVertices]) {
  Damped<float, kVertices> damping;
#pragma unroll
  for (int k = 0; k < kVertices; ++k) {
    damping.start[k] = position_of(load_particle(previous + places[k]));
  }
  return damping;
}

template <class Records, ProjectionMode kMode, bool kDamped>
__device__ void project(const Records& source, const Record<typename Records::Constraint>& record,
                        Index i, const Surroundings& around) {
  using Constraint = typename Records::Constraint;
  Corners<Constraint::kVertexCount> corners;
  corners.load(around.particles, record.places);
  float parameters[Constraint::kParameterCount];
  source.template parameters<kDamped>(record, i, parameters);
  const Substep<float> substep = around.input->substep;
  float multipliers[Constraint::kMultiplierCount] = {};
  if (kMode == ProjectionMode::compliance && around.takes_multipliers) {
#pragma unroll
    for (int m = 0; m < Constraint::kMultiplierCount; ++m) {
      multipliers[m] = __ldcg(around.multipliers + m * around.multiplier_stride + i);
    }
  }
  if constexpr (kDamped) {
    Constraint::template project<kMode>(corners.x, corners.w, parameters, substep, multipliers,
                                        load_start(around.previous, record.places));
  } else {
    Constraint::template project<kMode>(corners.x, corners.w, parameters, substep, multipliers);
  }
  corners.store(around.particles, record.places);
  if (kMode == ProjectionMode::compliance && around.leaves_multipliers) {
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
                             const Damped<float, 4>& start, Corners<4>& corners,
                             float& multiplier) {
  constexpr int kFirst = kTetEdgeEnds[kEdge][0];
  constexpr int kSecond = kTetEdgeEnds[kEdge][1];
  Vec3<float> x[2] = {corners.x[kFirst], corners.x[kSecond]};
  const float w[2] = {corners.w[kFirst], corners.w[kSecond]};
  float parameters[DistanceConstraint::kParameterCount];
  parameters[DistanceConstraint::kRest] = record.edge_rest[kEdge];
  parameters[DistanceConstraint::kStiffness] = record.edge_stiffness[kEdge];
  parameters[DistanceConstraint::kDamping] = record.damping;
  float multipliers[1] = {multiplier};
  if constexpr (kDamped) {
    const Damped<float, 2> ends{{start.start[kFirst], start.start[kSecond]}};
    DistanceConstraint::project<kMode>(x, w, parameters, substep, multipliers, ends);
  } else {
    DistanceConstraint::project<kMode>(x, w, parameters, substep, multipliers);
  }
  if (record.edge_rest[kEdge] >= 0) {
    corners.x[kFirst] = x[0];
    corners.x[kSecond] = x[1];
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
  Corners<4> corners;
  corners.load(around.particles, record.places);
  const Substep<float> substep = around.input->substep;
  Damped<float, 4> start{};
  if constexpr (kDamped) {
    start = load_start(around.previous, record.places);
  }
  float multipliers[7] = {};
  if (kMode == ProjectionMode::compliance && around.takes_multipliers) {
#pragma unroll
    for (int m = 0; m < 7; ++m) {
      multipliers[m] = __ldcg(around.multipliers + m * around.multiplier_stride + i);
    }
  }
  project_edge<0, kMode, kDamped>(record, substep, start, corners, multipliers[0]);
  project_edge<1, kMode, kDamped>(record, substep, start, corners, multipliers[1]);
  project_edge<2, kMode, kDamped>(record, substep, start, corners, multipliers[2]);
  project_edge<3, kMode, kDamped>(record, substep, start, corners, multipliers[3]);
  project_edge<4, kMode, kDamped>(record, substep, start, corners, multipliers[4]);
  project_edge<5, kMode, kDamped>(record, substep, start, corners, multipliers[5]);
  float parameters[VolumeConstraint::kParameterCount];
  parameters[VolumeConstraint::kRest] = record.rest;
  parameters[VolumeConstraint::kStiffness] = record.stiffness;
  parameters[VolumeConstraint::kDamping] = record.damping;
  float volume_multiplier[1] = {multipliers[6]};
  if constexpr (kDamped) {
    VolumeConstraint::project<kMode>(corners.x, corners.w, parameters, substep, volume_multiplier,
                                     start);
  } else {
    VolumeConstraint::project<kMode>(corners.x, corners.w, parameters, substep, volume_multiplier);
  }
  corners.store(around.particles, record.places);
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

template <class Records>
void launch_compliant_stage(const Records& source, const Stage& stage, const Index* level_ends,
                            const Projection& projection, const Surroundings& around,
                            const Launch& how) {
  if (projection.is_damped) {
    launch_stage<Records, ProjectionMode::compliance, true>(source, stage, level_ends, around, how);
  } else {
    launch_stage<Records, ProjectionMode::compliance, false>(source, stage, level_ends, around,
                                                             how);
  }
}

template <class Records>
void launch_stage(const Records& source, const Stage& stage, const Index* level_ends,
                  const Projection& projection, const Surroundings& around, const Launch& how) {
  if (projection.mode == ProjectionMode::fraction) {
    launch_stage<Records, ProjectionMode::fraction, false>(source, stage, level_ends, around, how);
  } else {
    launch_compliant_stage(source, stage, level_ends, projection, around, how);
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
    return Surroundings{state.particles,
                        state.previous,
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
    const Surroundings there = around(kind.multipliers, kind.count);
    Source<Constraint> source{};
    source.records = kind.records;
    if constexpr (std::is_same_v<Constraint, DistanceConstraint>) {
      source.damping = constraints.distance_damping;
    }
    if constexpr (!KindOf<Constraint>::kHasCompliance) {  // alike in all modes
      launch_stage<Source<Constraint>, ProjectionMode::fraction, false>(
          source, stage, constraints.level_ends, there, how);
    } else if constexpr (!KindOf<Constraint>::kHasFraction) {
      launch_compliant_stage(source, stage, constraints.level_ends, projection, there, how);
    } else {
      launch_stage(source, stage, constraints.level_ends, projection, there, how);
    }
  });
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
