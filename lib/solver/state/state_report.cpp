// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/state_report.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

template <class Constraint, class Visit>
void for_each_value(const CopyState& copy, const ConstraintSlots<Constraint>& slots, Visit visit) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    for (Index slot = 0; slot < slots.size(group); ++slot) {
      const auto& block = slots.blocks(group)[slot / kBlockLanes];
      const Index lane = slot % kBlockLanes;
      Vec3<float> points[Constraint::kVertexCount];
      for (int k = 0; k < Constraint::kVertexCount; ++k) {
        points[k] = load(at(copy.particles.data(), block.corners[k][lane]));
      }
      const float rest = block.parameters[Constraint::kRest][lane];
      visit(Constraint::value(points, rest), rest);
    }
  }
}

// Shares of volume beyond that at rest.
template <class Visit>
void for_each_swelling(const CopyState& copy, const ConstraintSlots<NeoHookeanConstraint>& slots,
                       Visit visit) {
  for (Index group = 0; group < slots.group_count(); ++group) {
    for (Index slot = 0; slot < slots.size(group); ++slot) {
      const auto& block = slots.blocks(group)[slot / kBlockLanes];
      const Index lane = slot % kBlockLanes;
      Vec3<float> points[4];
      for (int k = 0; k < 4; ++k) {
        points[k] = load(at(copy.particles.data(), block.corners[k][lane]));
      }
      float parameters[NeoHookeanConstraint::kParameterCount];
      for (int p = 0; p < NeoHookeanConstraint::kParameterCount; ++p) {
        parameters[p] = block.parameters[p][lane];
      }
      visit(NeoHookeanConstraint::value(points, parameters));
    }
  }
}

// A residual that is not a number counts as infinite: it must not hide behind the finite ones.
void raise(float& largest, float value) {
  largest =
      std::isfinite(value) ? std::max(largest, value) : std::numeric_limits<float>::infinity();
}

}  // namespace

void report_vertices(const SolverData& data, const CopyState& copy, StepReport& report) {
  for (std::size_t v = 0; v < copy.particles.size(); ++v) {
    const Particle& p = copy.particles[data.place_of_vertex[v]];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
      if (report.non_finite_vertices++ == 0) {
        report.first_non_finite = static_cast<Index>(v);
      }
    }
  }
}

void report_constraints(const SolverData& data, const CopyState& copy, StepReport& report) {
  for_each_value(copy, data.sets.of<DistanceConstraint>(), [&](float value, float rest) {
    if (rest > 0) {
      raise(report.distance_residual, std::abs(value) / rest);
    }
  });
  for_each_value(copy, data.sets.of<VolumeConstraint>(), [&](float value, float rest) {
    raise(report.volume_residual, std::abs(value) / rest);
    report.inverted_tets += value + rest < 0;
  });
  for_each_swelling(copy, data.sets.of<NeoHookeanConstraint>(), [&](float value) {
    raise(report.volume_residual, std::abs(value));
    report.inverted_tets += value < -1;
  });
}

void report_tubes(const SolverData& data, const CopyState& copy, StepReport& report) {
  for_each_tube_tet(*data.tissue, [&](Index t) {
    Vec3<float> points[4];
    for (int k = 0; k < 4; ++k) {
      points[k] = load(copy.particles[data.place_of_vertex[data.tissue->tets()[t][k]]]);
    }
    report.inverted_tets +=
        data.tissue->is_tet_alive(t) && VolumeConstraint::value(points, 0.0F) < 0;
  });
}

void report_copy(Index index, const StepReport& of_copy, CopyState& copy, StepReport& report) {
  copy.last_report = of_copy;
  if (of_copy.first_non_finite != kInvalidIndex) {
    copy.last_report.first_non_finite_copy = index;
    if (report.first_non_finite == kInvalidIndex) {
      report.first_non_finite = of_copy.first_non_finite;
      report.first_non_finite_copy = index;
    }
  }
  report.inverted_tets += of_copy.inverted_tets;
  report.non_finite_vertices += of_copy.non_finite_vertices;
  report.contacts += of_copy.contacts;
  report.dropped_contacts += of_copy.dropped_contacts;
  report.distance_residual = std::max(report.distance_residual, of_copy.distance_residual);
  report.volume_residual = std::max(report.volume_residual, of_copy.volume_residual);
  report.stalled = report.stalled || of_copy.stalled;
}

}  // namespace pbdsurg
