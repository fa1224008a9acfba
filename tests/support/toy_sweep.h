// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sweeps in the order of a plan, with numbers in place of positions.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "lib/device/cluster_shapes.h"
#include "lib/device/stage_plan.h"

namespace pbdsurg::cuda::testing {

/// In place of a position.
using ToyValue = std::uint64_t;

inline ToyValue mix(ToyValue value) {
  value = (value ^ (value >> 31)) * 0x9e3779b97f4a7c15U;
  return value ^ (value >> 29);
}

/// In place of a projection: another order of constraints, or of corners, gives other values.
inline void project_toy(std::span<ToyValue> corners, std::span<const std::uint32_t> parameters) {
  ToyValue all = corners.size();
  for (const std::uint32_t parameter : parameters) {
    all = mix(all + parameter);
  }
  for (const ToyValue corner : corners) {
    all = mix(all + corner);
  }
  for (ToyValue& corner : corners) {
    corner = mix(all++);
  }
}

/// Calls visit(records) for a kind.
template <class Visit>
auto visit_kind(StageRecords& records, PhaseKind kind, Visit visit) {
  switch (kind) {
    case PhaseKind::distance:
      return visit(records.of<DistanceConstraint>());
    case PhaseKind::volume:
      return visit(records.of<VolumeConstraint>());
    case PhaseKind::neo_hookean:
      return visit(records.of<NeoHookeanConstraint>());
    case PhaseKind::bending:
      return visit(records.of<BendingConstraint>());
    case PhaseKind::membrane:
      return visit(records.of<MembraneConstraint>());
    case PhaseKind::fibre:
      return visit(records.of<FibreConstraint>());
    case PhaseKind::strain_limit:
    case PhaseKind::stiff_link:
    case PhaseKind::joint:  // no cluster projects this and those that follow
    case PhaseKind::vertex:
    case PhaseKind::attachment:
    case PhaseKind::grip:
    case PhaseKind::contact:
    case PhaseKind::body_contact:
    case PhaseKind::custom:
      break;
  }
  return visit(records.of<StrainLimitConstraint>());
}

inline std::span<Index> places_of(StageRecords& records, PhaseKind kind, Index i) {
  return visit_kind(records, kind, [&](auto& all) { return std::span<Index>(all[i].places); });
}

/// A record as a device has it.
inline std::vector<std::uint32_t> numbers_of(StageRecords& records, PhaseKind kind, Index i) {
  return visit_kind(records, kind, [&](auto& all) {
    std::vector<std::uint32_t> numbers(sizeof all[i] / sizeof(std::uint32_t));
    std::memcpy(numbers.data(), &all[i], sizeof all[i]);
    return numbers;
  });
}

/// One sweep over the values of all places.
inline void sweep_toy(std::span<const Stage> stages, StageRecords& records,
                      std::vector<ToyValue>& values, bool is_damped) {
  for (const Stage& stage : stages) {
    const ClusterShape& shape = *shape_of(stage.kind);
    for (Index i = stage.first; i < stage.first + stage.count; ++i) {
      const std::span<const Index> places = places_of(records, stage.kind, i);
      if (places[0] < 0) {
        continue;
      }
      std::vector<std::uint32_t> parameters = numbers_of(records, stage.kind, i);
      parameters.erase(parameters.begin(), parameters.begin() + shape.corner_count);
      parameters.resize(static_cast<std::size_t>(shape.packed_parameters(is_damped)));
      if (stage.kind == PhaseKind::distance) {
        parameters.push_back(std::bit_cast<std::uint32_t>(records.distance_damping[i]));
      }
      std::vector<ToyValue> corners;
      for (const Index place : places) {
        corners.push_back(values[place]);
      }
      project_toy(corners, parameters);
      for (std::size_t k = 0; k < corners.size(); ++k) {
        values[places[k]] = corners[k];
      }
    }
  }
}

}  // namespace pbdsurg::cuda::testing
