// SPDX-License-Identifier: Apache-2.0
#include "solver/stage_records.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pbdsurg::cuda {

DistanceRecord to_record(const ConstraintRecord<DistanceConstraint>& from) {
  return {{from.places[0], from.places[1]},
          from.parameters[DistanceConstraint::kRest],
          from.parameters[DistanceConstraint::kStiffness]};
}

VolumeRecord to_record(const ConstraintRecord<VolumeConstraint>& from) {
  return {{from.places[0], from.places[1], from.places[2], from.places[3]},
          from.parameters[VolumeConstraint::kRest],
          from.parameters[VolumeConstraint::kStiffness],
          from.parameters[VolumeConstraint::kDamping],
          0};
}

NeoHookeanRecord to_record(const ConstraintRecord<NeoHookeanConstraint>& from) {
  NeoHookeanRecord record{{from.places[0], from.places[1], from.places[2], from.places[3]}, {}};
  std::copy(from.parameters.begin(), from.parameters.end(), record.parameters);
  return record;
}

StrainLimitRecord to_record(const ConstraintRecord<StrainLimitConstraint>& from) {
  return {{from.places[0], from.places[1]}, from.parameters[StrainLimitConstraint::kLimit], 0};
}

BendingRecord to_record(const ConstraintRecord<BendingConstraint>& from) {
  return {{from.places[0], from.places[1], from.places[2], from.places[3]},
          from.parameters[BendingConstraint::kRest],
          from.parameters[BendingConstraint::kStiffness],
          from.parameters[BendingConstraint::kDamping],
          0};
}

OwnedEdge owned_edge(const SolverData& data, Index tet, Index edge) {
  const Index distance = data.sets.distance_ids.of_edge(edge);
  const auto& distances = data.sets.of<DistanceConstraint>();
  if (!distances.is_alive(distance) || data.sets.edge_owners[edge] != tet) {
    return {};
  }
  const DistanceRecord owned = to_record(distances.record(distance));
  return {owned.rest, owned.stiffness};
}

JointRecord to_joint_record(const SolverData& data, Index tet) {
  const VolumeRecord volume = to_record(data.sets.of<VolumeConstraint>().record(tet));
  JointRecord record{{volume.places[0], volume.places[1], volume.places[2], volume.places[3]},
                     volume.rest,
                     volume.stiffness,
                     volume.damping,
                     0,
                     {},
                     {}};
  const std::array<Index, 6>& edges = data.tissue->tet_edges()[tet];
  for (std::size_t place = 0; place < edges.size(); ++place) {
    const OwnedEdge edge = owned_edge(data, tet, edges[place]);
    record.edge_rest[place] = edge.rest;
    record.edge_stiffness[place] = edge.stiffness;
  }
  return record;
}

TubeRecord to_tube_record(const SolverData& data, Index tet) {
  const Tet places = data.places_of(data.tissue->tets()[tet]);
  return {{places[0], places[1], places[2], places[3]}};
}

bool is_tube(const SolverData& data, Index tet) noexcept {
  return tet < static_cast<Index>(data.tissue->tets().size()) && data.tissue->is_tet_alive(tet) &&
         !data.sets.of<VolumeConstraint>().is_alive(tet) &&
         !data.sets.of<NeoHookeanConstraint>().is_alive(tet);
}

}  // namespace pbdsurg::cuda
