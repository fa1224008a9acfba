// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/sets/constraint_sets.h"

#include <algorithm>
#include <array>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/solver/sets/constraint_groups.h"
#include "lib/solver/state/room_to_grow.h"
#include "lib/tissue/hinges.h"

namespace pbdsurg {
namespace {

// Room for so many constraints in each group that they may join, and some groups more: edits that
// find no free one are rare. A type that the scene has none of needs none, but for links.
template <class Constraint>
void reserve_groups(ConstraintData& data, std::size_t count) {
  constexpr PhaseKind kKind = KindOf<Constraint>::kPhase;
  const auto is_of_kind = [&](const Phase& phase) { return takes(phase, kKind); };
  if (count == 0 ||
      (kKind != PhaseKind::distance && std::ranges::none_of(data.phases, is_of_kind))) {
    return;
  }
  auto& set = data.of<Constraint>();
  set.reserve(count, joinable_groups(data, kKind));
  constexpr std::size_t kFewest = 64;
  for (Index i = 0; i < kWaitingGroups; ++i) {  // each for half as many as the one before
    const std::array group{open_group<Constraint>(data)};
    set.reserve(std::max(count >> i, kFewest), group);
  }
}

}  // namespace

Index ConstraintData::joint_group_of(
    Index edge, std::span<const std::array<Index, 6>> tet_edges) const noexcept {
  const Index owner = edge_owners[edge];
  const auto& edges_of_owner = tet_edges[owner];
  const auto place = std::find(edges_of_owner.begin(), edges_of_owner.end(), edge);
  return joint_group(of<VolumeConstraint>().group_of(owner),
                     static_cast<Index>(place - edges_of_owner.begin()));
}

Index ConstraintData::constraint_count(const Phase& phase) const noexcept {
  Index count = 0;
  visit_set(phase.kind, [&](const auto& set) { count = set.size(phase.color); });
  return count;
}

EdgeNumbers ConstraintData::numbers_of_edge(Index edge) const {
  EdgeNumbers numbers;
  const auto& distances = of<DistanceConstraint>();
  const Index distance = distance_ids.of_edge(edge);
  if (distances.is_alive(distance)) {
    numbers.distance = distances.record(distance).parameters;
  }
  if (of<StrainLimitConstraint>().is_alive(edge)) {
    numbers.limit = of<StrainLimitConstraint>().record(edge).parameters;
  }
  return numbers;
}

TetNumbers ConstraintData::numbers_of_tet(Index tet) const {
  TetNumbers numbers;
  if (of<VolumeConstraint>().is_alive(tet)) {
    numbers.volume = of<VolumeConstraint>().record(tet).parameters;
  }
  if (of<NeoHookeanConstraint>().is_alive(tet)) {
    numbers.neo_hookean = of<NeoHookeanConstraint>().record(tet).parameters;
  }
  if (of<FibreConstraint>().is_alive(tet)) {
    numbers.fibre = of<FibreConstraint>().record(tet).parameters;
  }
  return numbers;
}

TriangleNumbers ConstraintData::numbers_of_triangle(Index triangle) const {
  const auto& membranes = of<MembraneConstraint>();
  return membranes.is_alive(triangle) ? TriangleNumbers(membranes.record(triangle).parameters)
                                      : std::nullopt;
}

HingeNumbers ConstraintData::numbers_of_hinge(Index hinge) const {
  const auto& bendings = of<BendingConstraint>();
  return bendings.is_alive(hinge) ? HingeNumbers(bendings.record(hinge).parameters) : std::nullopt;
}

StiffLinkNumbers ConstraintData::numbers_of_link(Index link) const {
  const auto& links = of<StiffLinkConstraint>();
  return links.is_alive(link) ? StiffLinkNumbers(links.record(link).parameters) : std::nullopt;
}

void ConstraintSets::reserve(const SpareRoom& spare) {
  const auto tets = static_cast<std::size_t>(spare.tets);
  const auto edges = static_cast<std::size_t>(spare.edges);
  const auto links = static_cast<std::size_t>(spare.links);
  distance_ids.reserve(edges, links);
  for_each_set([&]<class Constraint>(ConstraintSlots<Constraint>& set) {
    switch (KindOf<Constraint>::kElement) {
      case Element::edge_or_link:
        reserve_groups<Constraint>(*this, edges + links);
        break;
      case Element::edge:
        reserve_groups<Constraint>(*this, edges);
        break;
      case Element::link:
        reserve_groups<Constraint>(*this, links);
        break;
      case Element::tet:
        reserve_groups<Constraint>(*this, tets);
        break;
      case Element::triangle:  // come with bodies alone, as the next
        if (set.group_count() > 0) {
          set.reserve(tets, {});
        }
        break;
      case Element::hinge:
        if (set.group_count() > 0) {
          set.reserve(kHingesOfTet * tets, {});
        }
        break;
    }
  });
}

std::size_t ConstraintSets::memory_bytes() const noexcept {
  std::size_t bytes = distance_ids.memory_bytes() + edge_owners.memory_bytes() +
                      phases.capacity() * sizeof(Phase) + is_taken_.capacity() / 8;
  for_each_set([&](const auto& set) { bytes += set.memory_bytes(); });
  return bytes;
}

void ConstraintSets::validate(const Tissue& tissue, const TopologyEdit& edit) const {
  for (const RestLengthChange& rest : edit.rest_lengths) {
    if (!of<DistanceConstraint>().is_alive(distance_ids.of_edge(rest.edge))) {
      throw InvalidArgument("edge " + std::to_string(rest.edge) +
                            " belongs to a Neo-Hookean body, whose edges have no rest length");
    }
  }
  edge_tets_before_.clear();
  for (const RestVolumeChange& rest : edit.rest_volumes) {
    if (!of<VolumeConstraint>().is_alive(rest.tet) &&
        !of<NeoHookeanConstraint>().is_alive(rest.tet)) {
      throw InvalidArgument("tet " + std::to_string(rest.tet) +
                            " belongs to a body without volume constraints");
    }
    std::array<Index, 6>& counts = edge_tets_before_.emplace_back();
    std::ranges::transform(tissue.tet_edges()[rest.tet], counts.begin(),
                           [&](Index edge) { return tissue.edge_tets()[edge]; });
  }
  check_materials(edit.new_bodies.bodies(), state_.options.mode);
  check_hinges(edit.new_bodies.hinges().size(), state_.options.mode);
}

}  // namespace pbdsurg
