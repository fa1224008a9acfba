// SPDX-License-Identifier: Apache-2.0
#include "lib/device/stage_records.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace pbdsurg::cuda {

OwnedEdge owned_edge(const SolverData& data, Index tet, Index edge) {
  const Index distance = data.sets.distance_ids.of_edge(edge);
  const auto& distances = data.sets.of<DistanceConstraint>();
  if (!distances.is_alive(distance) || data.sets.edge_owners[edge] != tet) {
    return {};
  }
  const auto parameters = distances.record(distance).parameters;
  return {parameters[DistanceConstraint::kRest], parameters[DistanceConstraint::kStiffness]};
}

JointRecord to_joint_record(const SolverData& data, Index tet) {
  const auto [places, parameters] = data.sets.of<VolumeConstraint>().record(tet);
  JointRecord record{{places[0], places[1], places[2], places[3]},
                     parameters[VolumeConstraint::kRest],
                     parameters[VolumeConstraint::kStiffness],
                     parameters[VolumeConstraint::kDamping],
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
