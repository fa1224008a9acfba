// SPDX-License-Identifier: Apache-2.0
#include "solver/growth.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "solver/backend.h"
#include "solver/build_constraints.h"

namespace pbdsurg {
namespace {

Index last_level(const SolverData& data) {
  return static_cast<Index>(data.domain_counts.size()) - 1;
}

// Calls visit(slots) with the constraints of a kind.
template <class Visit>
auto visit_slots(SolverData& data, PhaseKind kind, Visit visit) {
  switch (kind) {
    case PhaseKind::distance:
      return visit(data.distances);
    case PhaseKind::neo_hookean:
      return visit(data.neo_hookeans);
    case PhaseKind::strain_limit:
      return visit(data.strain_limits);
    default:
      return visit(data.volumes);
  }
}

// Calls visit(edge) for live edges at a vertex, some more than once.
template <class Visit>
void for_each_edge_at(const SolverData& data, Index vertex, Visit visit) {
  for (const Index tet : data.vertex_tets[vertex]) {
    for (const Index edge : data.tet_edges[tet]) {
      if (data.edges[edge][0] == vertex || data.edges[edge][1] == vertex) {
        visit(edge);
      }
    }
  }
}

// Calls visit(group) for those of the constraints of a kind at a vertex; some are kInvalidIndex.
template <class Visit>
void for_each_group_at(const SolverData& data, PhaseKind kind, Index vertex, Visit visit) {
  switch (kind) {
    case PhaseKind::distance:
      for_each_edge_at(data, vertex, [&](Index edge) {
        visit(data.distances.group_of(data.distance_ids.of_edge(edge)));
      });
      for (const Index link : data.vertex_links[vertex]) {
        visit(data.distances.group_of(data.distance_ids.of_link(link)));
      }
      break;
    case PhaseKind::strain_limit:
      for_each_edge_at(data, vertex, [&](Index edge) { visit(data.strain_limits.group_of(edge)); });
      break;
    case PhaseKind::neo_hookean:
      for (const Index tet : data.vertex_tets[vertex]) {
        visit(data.neo_hookeans.group_of(tet));
      }
      break;
    default:
      for (const Index tet : data.vertex_tets[vertex]) {
        visit(data.volumes.group_of(tet));
      }
      break;
  }
}

// Joint phases project volumes, too: where an edge is owned, its tetrahedron has both vertices.
bool takes(const Phase& phase, PhaseKind kind) {
  return !phase.serial &&
         (phase.kind == kind || (phase.kind == PhaseKind::joint && kind == PhaseKind::volume));
}

Index open_group(SolverData& data, PhaseKind kind) {
  const Index group = visit_slots(data, kind, [](auto& slots) {
    slots.open_group();
    return slots.group_count() - 1;
  });
  const Phase phase{kind, group, false, last_level(data), 0};
  const auto place =
      std::ranges::upper_bound(data.constraint_phases, phase, [](const Phase& a, const Phase& b) {
        return std::tie(a.level, a.domain, a.kind) < std::tie(b.level, b.domain, b.kind);
      });
  data.constraint_phases.insert(place, phase);
  return group;
}

void close_group(SolverData& data, PhaseKind kind) {
  const Index group = visit_slots(data, kind, [](auto& slots) { return slots.group_count() - 1; });
  std::erase_if(data.constraint_phases,
                [&](const Phase& phase) { return phase.kind == kind && phase.color == group; });
  visit_slots(data, kind, [](auto& slots) { slots.close_group(); });
}

}  // namespace

Index find_free_group(SolverData& data, PhaseKind kind, std::span<const Index> vertices) {
  std::vector<Index>& taken = data.edit_buffer;
  taken.clear();
  for (const Index v : vertices) {
    for_each_group_at(data, kind, v, [&](Index group) { taken.push_back(group); });
  }
  std::ranges::sort(taken);
  const std::vector<Phase>& phases = data.constraint_phases;
  auto phase = std::ranges::partition_point(
      phases, [&](const Phase& each) { return each.level < last_level(data); });
  for (; phase != phases.end(); ++phase) {
    if (takes(*phase, kind) && !std::ranges::binary_search(taken, phase->color)) {
      return phase->color;
    }
  }
  data.journal.opened_groups.push_back(kind);
  return open_group(data, kind);
}

void add_link(SolverData& data, const Link& link) {
  const Edge ends{link.first, link.second};
  const Index id = static_cast<Index>(data.links.size());
  const Index distance = data.distance_ids.add_link();
  data.links.push_back(link);
  data.distances.set_id_count(static_cast<std::size_t>(data.distance_ids.count()));
  const Index group = find_free_group(data, PhaseKind::distance, ends);
  data.distances.add(distance, group,
                     {data.places_of(ends),
                      {link.rest_length, stiffness_in(data.options.mode, link.stiffness), 0}});
  for (const Index v : ends) {
    data.vertex_links.insert(v, id);
  }
}

void finish_growth(SolverData& data) {
  data.changes.grown = data.backend->keeps_state();
  regrow_vertices(data);
}

void undo_growth(SolverData& data) {
  EditJournal& journal = data.journal;
  for (std::size_t l = data.links.size(); l-- > journal.link_count;) {
    for (const Index v : {data.links[l].first, data.links[l].second}) {
      data.vertex_links.erase(v, static_cast<Index>(l));
    }
  }
  data.links.resize(journal.link_count);
  data.distance_ids.shrink(data.edges.size(), data.links.size());
  data.distances.set_id_count(static_cast<std::size_t>(data.distance_ids.count()));
  for (; !journal.opened_groups.empty(); journal.opened_groups.pop_back()) {
    close_group(data, journal.opened_groups.back());
  }
  data.changes.grown = data.backend->keeps_state();
}

void reserve_spare_room(SolverData& data) {
  const SpareRoom& spare = data.options.spare;
  if (spare.links == 0) {
    return;
  }
  constexpr int kSpareGroups = 8;  // of each type; edits that find no free one are rare
  constexpr std::size_t kToolPhases = 64;
  constexpr std::size_t kLinksAtVertex = 8;  // room for a list that moves
  const auto links = static_cast<std::size_t>(spare.links);
  data.links.reserve(data.links.size() + links);
  data.distance_ids.reserve(0, links);
  data.vertex_links.reserve(0, 2 * kLinksAtVertex * links);
  for (int i = 0; i < kSpareGroups; ++i) {
    open_group(data, PhaseKind::distance);
  }
  std::vector<Index> groups;
  for (const Phase& phase : data.constraint_phases) {
    if (phase.level == last_level(data) && takes(phase, PhaseKind::distance)) {
      groups.push_back(phase.color);
    }
  }
  data.distances.reserve(links, groups);
  data.plan.phases.reserve(data.constraint_phases.size() + kToolPhases);
}

}  // namespace pbdsurg
