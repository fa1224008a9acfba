// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Stages of a device, projected by one thread of the host, against the order of their records: a
/// stage whose constraints shared a vertex would show.

#include <algorithm>
#include <cstring>
#include <span>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/device/stage_plan.h"
#include "lib/solver/host/serial_phases.h"
#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/sets/constraint_kinds.h"
#include "tests/support/eventful_program.h"

namespace pbdsurg::cuda::testing {

/// Constraints as a device holds them, with what they remember.
struct HostStages {
  explicit HostStages(const SolverData& data, bool has_grown = false)
      : mode(data.options.mode), is_damped(data.sets.has_damping), plan(data, records, has_grown) {
    forget();
  }

  /// Before a substep.
  void forget() {
    records.for_each_list([&]<class Constraint>(const std::vector<Record<Constraint>>& list) {
      multipliers_of<Constraint>().assign(list.size(), {});
    });
    joints.assign(7 * records.joints.size(), {});
  }

  /// As the device writes words.
  void write(const std::vector<WordChange>& words) {
    const auto start = [&](DeviceArray array) -> void* {
      if (array == DeviceArray::distance_damping) {
        return records.distance_damping.data();
      }
      if (array == DeviceArray::joints) {
        return records.joints.data();
      }
      if (array == DeviceArray::tubes) {
        return records.tubes.data();
      }
      void* found = nullptr;
      records.for_each_list([&]<class Constraint>(const std::vector<Record<Constraint>>&) {
        if (array == array_of(KindOf<Constraint>::kPhase)) {
          found = records.of<Constraint>().data();
        }
      });
      if (found == nullptr) {
        throw Error("a plan of stages writes array " + std::to_string(static_cast<int>(array)));
      }
      return found;
    };
    for (const WordChange& change : words) {
      std::memcpy(static_cast<char*>(start(change.array)) + sizeof change.value * change.word,
                  &change.value, sizeof change.value);
    }
  }

  /// @param carries  [place] in compliance mode
  void project(const Stage& stage, const MovingVertices& vertices, std::span<const Carry> carries,
               const Substep<float>& substep) {
    Index first = stage.first;
    for (Index level = 0; level < std::max<Index>(1, stage.level_count); ++level) {
      const Index end = stage.level_count == 0 ? stage.first + stage.count
                                               : records.level_ends[stage.first_level + level];
      for (Index i = end; i-- > first;) {
        project(stage.kind, i, vertices, carries, substep);
      }
      first = end;
    }
  }

  ProjectionMode mode;
  bool is_damped;
  StageRecords records;
  StagePlan plan;

 private:
  template <class Constraint>
  struct Multipliers {
    float values[Constraint::kMultiplierCount] = {};
  };

  template <class Constraint, std::size_t kVertices>
  void project(const Index (&places)[kVertices],
               const float (&parameters)[Constraint::kParameterCount],
               float (&multipliers)[Constraint::kMultiplierCount], const MovingVertices& vertices,
               std::span<const Carry> carries, const Substep<float>& substep) {
    if (places[0] < 0) {
      return;
    }
    constexpr int kCorners = static_cast<int>(kVertices);
    constexpr auto kCompliance = ProjectionMode::compliance;
    Vec3<float> bases[kVertices], moving[kVertices], roundings[kVertices], seen[kVertices];
    float w[kVertices];
    for (std::size_t k = 0; k < kVertices; ++k) {
      bases[k] = vertices.base(places[k]);
      moving[k] = load(vertices.moving[places[k]]);
      w[k] = vertices.moving[places[k]].w;
      roundings[k] = mode == ProjectionMode::fraction ? Vec3<float>{} : load(carries[places[k]]);
    }
    Moves<float, kCorners> moves;
    if (mode == ProjectionMode::fraction) {
      if constexpr (KindOf<Constraint>::kHasFraction) {
        moves = Constraint::template move<ProjectionMode::fraction>(moving, w, parameters, substep,
                                                                    multipliers);
      }
    } else {
      see_corners(bases, moving, seen);
      if (is_damped) {
        Damped<float, kCorners> damping;
        see_corners(bases, roundings, damping.start);
        moves = Constraint::template move<kCompliance>(seen, w, parameters, substep, multipliers,
                                                       damping);
      } else {
        moves = Constraint::template move<kCompliance>(seen, w, parameters, substep, multipliers);
      }
    }
    for (std::size_t k = 0; k < kVertices; ++k) {
      store(vertices.moving[places[k]], moving[k] + moves.of[k]);
      if (vertices.points != nullptr) {
        FixedPoint& point = vertices.points[places[k]];
        point = moved_point(point, moving[k], moving[k] + moves.of[k]);
      }
    }
  }

  void project(PhaseKind kind, Index i, const MovingVertices& vertices,
               std::span<const Carry> carries, const Substep<float>& substep) {
    if (kind == PhaseKind::joint) {
      project_joint(i, vertices, carries, substep);
    }
    records.for_each_list([&]<class Constraint>(const std::vector<Record<Constraint>>& list) {
      if (kind != KindOf<Constraint>::kPhase) {
        return;
      }
      float parameters[Constraint::kParameterCount];
      std::copy_n(list[i].parameters, kRecordParameters<Constraint>, parameters);
      if constexpr (std::is_same_v<Constraint, DistanceConstraint>) {
        parameters[Constraint::kDamping] = records.distance_damping[i];
      }
      project<Constraint>(list[i].places, parameters, multipliers_of<Constraint>()[i].values,
                          vertices, carries, substep);
    });
  }

  void project_joint(Index i, const MovingVertices& vertices, std::span<const Carry> carries,
                     const Substep<float>& substep) {
    const JointRecord& record = records.joints[i];
    if (record.places[0] < 0) {
      return;
    }
    for (std::size_t e = 0; e < 6; ++e) {
      if (record.edge_rest[e] >= 0) {
        const Index ends[2] = {record.places[kTetEdges[e][0]], record.places[kTetEdges[e][1]]};
        const float parameters[] = {record.edge_rest[e], record.edge_stiffness[e], record.damping};
        project<DistanceConstraint>(ends, parameters, joints[7 * i + e].values, vertices, carries,
                                    substep);
      }
    }
    const float parameters[] = {record.rest, record.stiffness, record.damping};
    project<VolumeConstraint>(record.places, parameters, joints[7 * i + 6].values, vertices,
                              carries, substep);
  }

  template <class... Constraints>
  using Lists = std::tuple<std::vector<Multipliers<Constraints>>...>;

  template <class Constraint>
  std::vector<Multipliers<Constraint>>& multipliers_of() {
    return std::get<std::vector<Multipliers<Constraint>>>(multipliers_);
  }

  ForAllConstraints<Lists> multipliers_;
  std::vector<Multipliers<DistanceConstraint>> joints;  // [7][joint] of edges, then of the volume
};

/// Takes all out of rest.
inline void stretch(Solver& solver) {
  std::vector<Eigen::Vector3f> positions = solver.positions();
  for (std::size_t v = 0; v < positions.size(); ++v) {
    positions[v] *= v % 3 == 0 ? 1.1F : 0.97F;
  }
  solver.write_positions(positions);
}

inline bool same_bits(const std::vector<Particle>& a, const std::vector<Particle>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Particle)) == 0;
}

/// Two sweeps from the state of the data, by the stages and by the serial backend; they move
/// something, if any tetrahedron lives.
inline bool have_serial_bits(HostStages& stages, SolverData& data) {
  constexpr Substep<float> kSubstep{1e3F, 1e6F};
  StepScratch scratch;
  scratch.fit(data);
  stages.forget();
  const bool displaces = has_displacements(data.options);
  for (std::size_t place = 0; place < scratch.displacements.size(); ++place) {
    const Particle& p = data.particles[place];
    scratch.displacements[place] = {0.05F * p.y, 0.04F * p.z, -0.03F * p.x, p.w};
    data.carries[place] = {1e-3F * p.z, -1e-3F * p.x, 2e-3F * p.y, 1};
  }
  std::vector<Particle>& moved = displaces ? scratch.displacements : data.particles;
  const std::vector<Particle> start = moved;
  std::vector<Particle> moving = start;
  for (int sweep = 0; sweep < 2; ++sweep) {
    for (const Phase& phase : data.plan.phases) {
      if (phase.kind != PhaseKind::attachment && phase.kind != PhaseKind::contact) {
        project_serially({data, data, scratch}, phase, kSubstep);
      }
    }
    for (const Stage& stage : stages.plan.open_stages()) {
      stages.project(stage, {moving.data(), displaces ? data.particles.data() : nullptr},
                     data.carries, kSubstep);
    }
  }
  const std::span<const Index> edge_tets = data.tissue->edge_tets();
  const bool has_tissue = std::ranges::any_of(edge_tets, [](Index count) { return count > 0; });
  const bool have = same_bits(moving, moved) && (!has_tissue || !same_bits(moving, start));
  moved = start;
  return have;
}

/// What plans can be made of.
inline std::vector<pbdsurg::testing::Variant> plan_variants() {
  return {{},
          {.damping = 0.01F},
          {.composition = PlanComposition::joint},
          {.composition = PlanComposition::joint, .damping = 0.01F},
          {.composition = PlanComposition::joint, .max_colors = 9, .damping = 0.01F},
          {.max_colors = 5},
          {.mode = ProjectionMode::fraction},
          {.mode = ProjectionMode::fraction, .composition = PlanComposition::joint},
          {.mode = ProjectionMode::fraction, .max_colors = 9}};
}

}  // namespace pbdsurg::cuda::testing
