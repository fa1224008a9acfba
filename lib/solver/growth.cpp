// SPDX-License-Identifier: Apache-2.0
#include "solver/growth.h"

#include <algorithm>
#include <array>
#include <tuple>
#include <vector>

#include "solver/add_bodies.h"
#include "solver/backend.h"
#include "solver/room_to_grow.h"

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
        return std::tie(a.level, a.domain, a.kind, a.serial) <  // what is serial comes last
               std::tie(b.level, b.domain, b.kind, b.serial);
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

// Those that a new constraint may join, where they are free at its vertices.
std::vector<Index> joinable_groups(const SolverData& data, PhaseKind kind) {
  std::vector<Index> groups;
  for (const Phase& phase : data.constraint_phases) {
    if (phase.level == last_level(data) && takes(phase, kind)) {
      groups.push_back(phase.color);
    }
  }
  return groups;
}

// Room for so many constraints in each group that they may join, and some groups more: edits that
// find no free one are rare. A type that the scene has none of needs none, but for links.
void reserve_groups(SolverData& data, PhaseKind kind, std::size_t count) {
  const auto is_of_kind = [&](const Phase& phase) { return takes(phase, kind); };
  if (count == 0 ||
      (kind != PhaseKind::distance && std::ranges::none_of(data.constraint_phases, is_of_kind))) {
    return;
  }
  visit_slots(data, kind, [&](auto& slots) { slots.reserve(count, joinable_groups(data, kind)); });
  constexpr std::size_t kFewest = 64;
  for (Index i = 0; i < kWaitingGroups; ++i) {  // each for half as many as the one before
    const std::array group{open_group(data, kind)};
    visit_slots(data, kind,
                [&](auto& slots) { slots.reserve(std::max(count >> i, kFewest), group); });
  }
}

}  // namespace

Index find_free_group(SolverData& data, PhaseKind kind, std::span<const Index> vertices) {
  std::vector<bool>& is_taken = data.group_buffer;
  const Index group_count =
      visit_slots(data, kind, [](const auto& slots) { return slots.group_count(); });
  is_taken.assign(static_cast<std::size_t>(group_count), false);
  for (const Index v : vertices) {
    for_each_group_at(data, kind, v, [&](Index group) {
      if (group != kInvalidIndex) {
        is_taken[group] = true;
      }
    });
  }
  const std::vector<Phase>& phases = data.constraint_phases;
  auto phase = std::ranges::partition_point(
      phases, [&](const Phase& each) { return each.level < last_level(data); });
  for (; phase != phases.end(); ++phase) {
    if (takes(*phase, kind) && !is_taken[phase->color]) {
      return phase->color;
    }
  }
  data.journal.opened_groups.push_back(kind);
  return open_group(data, kind);
}

std::vector<Index> groups_to_join(SolverData& data, PhaseKind kind, Index count) {
  std::vector<Index> groups = joinable_groups(data, kind);
  while (groups.size() < static_cast<std::size_t>(count)) {
    data.journal.opened_groups.push_back(kind);
    groups.push_back(open_group(data, kind));
  }
  return groups;
}

void add_vertex(SolverData& data, Index first, Index second, float share) {
  const Index a = data.place_of_vertex[first];
  const Index b = data.place_of_vertex[second];
  const bool is_fixed = data.particles[a].w == 0 && data.particles[b].w == 0;
  const auto between = [&](float from, float to) { return from + share * (to - from); };
  const auto place = static_cast<Index>(data.particles.size());
  for (Index i = 0; i < data.copy_count(); ++i) {
    CopyState& state = data.copy(i);
    const Particle p = state.particles[a], q = state.particles[b];
    const Velocity v = state.velocities[a], w = state.velocities[b];
    // the mass that sets its inverse mass comes with tetrahedra
    state.particles.push_back(
        {between(p.x, q.x), between(p.y, q.y), between(p.z, q.z), is_fixed ? 0.0F : 1.0F});
    state.velocities.push_back({between(v.x, w.x), between(v.y, w.y), between(v.z, w.z)});
    if (!state.falling.empty()) {
      state.falling.push_back(between(state.falling[a], state.falling[b]));
    }
  }
  data.log_moved(place);
  const Index body = data.body_of_vertex(first);  // while both arrays below count alike
  data.previous.push_back(data.particles.back());
  data.place_of_vertex.push_back(place);
  data.vertex_masses.push_back(0);
  data.later_vertex_bodies.push_back(body);
  data.vertex_tets.resize(place + 1);
  data.vertex_links.resize(place + 1);
}

Index add_edge(SolverData& data, const Edge& ends) {
  data.edges.push_back(ends);
  data.edge_tets.push_back(0);
  data.distance_ids.add_edge();
  data.distances.set_id_count(static_cast<std::size_t>(data.distance_ids.count()));
  data.strain_limits.set_id_count(data.edges.size());
  return static_cast<Index>(data.edges.size()) - 1;
}

EdgeNumbers numbers_of(const SolverData& data, Index edge) {
  EdgeNumbers numbers;
  const Index distance = data.distance_ids.of_edge(edge);
  if (data.distances.is_alive(distance)) {
    numbers.distance = data.distances.record(distance).parameters;
  }
  if (data.strain_limits.is_alive(edge)) {
    numbers.limit = data.strain_limits.record(edge).parameters;
  }
  return numbers;
}

TetNumbers tet_numbers_of(const SolverData& data, Index tet) {
  TetNumbers numbers;
  if (data.volumes.is_alive(tet)) {
    numbers.volume = data.volumes.record(tet).parameters;
  }
  if (data.neo_hookeans.is_alive(tet)) {
    numbers.neo_hookean = data.neo_hookeans.record(tet).parameters;
  }
  return numbers;
}

void add_edge_constraints(SolverData& data, Index edge, const EdgeNumbers& numbers) {
  const Edge& ends = data.edges[edge];
  if (numbers.distance) {
    const Index group = find_free_group(data, PhaseKind::distance, ends);
    const Index distance = data.distance_ids.of_edge(edge);
    data.distances.add(distance, group, {data.places_of(ends), *numbers.distance});
    data.log_constraint(PhaseKind::distance, distance);
  }
  if (numbers.limit) {
    const Index group = find_free_group(data, PhaseKind::strain_limit, ends);
    data.strain_limits.add(edge, group, {data.places_of(ends), *numbers.limit});
    data.log_constraint(PhaseKind::strain_limit, edge);
  }
}

Index add_tet(SolverData& data, const Tet& vertices, Index body, double mass) {
  data.tets.push_back(vertices);
  data.tet_edges.emplace_back();
  data.tet_alive.push_back(true);
  data.tet_masses.push_back(mass);
  data.later_tet_bodies.push_back(body);
  data.volumes.set_id_count(data.tets.size());
  data.neo_hookeans.set_id_count(data.tets.size());
  const Index id = static_cast<Index>(data.tets.size()) - 1;
  data.log_tet(id);
  return id;
}

void add_link(SolverData& data, const Link& link) {
  const Edge ends{link.first, link.second};
  const Index id = static_cast<Index>(data.links.size());
  const Index distance = data.distance_ids.add_link();
  data.links.push_back(link);
  data.distances.set_id_count(static_cast<std::size_t>(data.distance_ids.count()));
  const Index group = find_free_group(data, PhaseKind::distance, ends);
  data.distances.add(distance, group,
                     {data.places_of(ends), link_numbers(link, data.options.mode)});
  data.log_constraint(PhaseKind::distance, distance);
  data.add_link_at(link.first, id);
  data.add_link_at(link.second, id);
}

void finish_growth(SolverData& data) {
  data.log_growth();
  if (data.particles.size() > data.journal.vertex_count) {
    reserve_tools(data);
  }
  regrow_vertices(data);
}

void reserve_tool(const SolverData& data, ToolState& tool) {
  tool.placed_capsules.reserve(tool.capsules.size());
  if (!data.backend->keeps_state()) {
    tool.contacts.reserve(
        std::min(data.particles.size(), static_cast<std::size_t>(data.options.contact_capacity)));
  }
}

void reserve_tools(SolverData& data) {
  for (Index i = 0; i < data.copy_count(); ++i) {
    for (ToolState& tool : data.copy(i).tools) {
      reserve_tool(data, tool);
    }
  }
}

void undo_growth(SolverData& data) {
  EditJournal& journal = data.journal;
  data.log_growth();
  if (data.particles.size() > journal.vertex_count) {
    data.later_vertex_bodies.resize(data.later_vertex_bodies.size() -
                                    (data.particles.size() - journal.vertex_count));
    for (Index i = 0; i < data.copy_count(); ++i) {
      CopyState& state = data.copy(i);
      state.particles.resize(journal.vertex_count);
      state.velocities.resize(journal.vertex_count);
      state.falling.resize(state.falling.empty() ? 0 : journal.vertex_count);
    }
    data.previous.resize(journal.vertex_count);
    data.place_of_vertex.resize(journal.vertex_count);
    data.vertex_masses.resize(journal.vertex_count);
    data.vertex_tets.resize(static_cast<Index>(journal.vertex_count));
    data.vertex_links.resize(static_cast<Index>(journal.vertex_count));
    const auto is_gone = [&](Index place) {  // the places and ids of new vertices are last
      return static_cast<std::size_t>(place) >= journal.vertex_count;
    };
    std::erase_if(data.changes.vertices, is_gone);
    std::erase_if(data.changes.moved, is_gone);
  }
  undo_bodies(data);
  for (auto tet = static_cast<Index>(journal.tet_count); tet < static_cast<Index>(data.tets.size());
       ++tet) {
    data.log_tet(tet);
  }
  data.later_tet_bodies.resize(data.later_tet_bodies.size() -
                               (data.tets.size() - journal.tet_count));
  data.tets.resize(journal.tet_count);
  data.tet_edges.resize(journal.tet_count);
  data.tet_alive.resize(journal.tet_count);
  data.tet_masses.resize(journal.tet_count);
  data.volumes.set_id_count(journal.tet_count);
  data.neo_hookeans.set_id_count(journal.tet_count);
  data.edges.resize(journal.edge_count);
  data.edge_tets.resize(journal.edge_count);
  data.links.resize(journal.link_count);
  data.strain_limits.set_id_count(journal.edge_count);
  data.distance_ids.shrink(journal.edge_count, journal.link_count);
  data.distances.set_id_count(static_cast<std::size_t>(data.distance_ids.count()));
  for (; !journal.opened_groups.empty(); journal.opened_groups.pop_back()) {
    close_group(data, journal.opened_groups.back());
  }
}

void reserve_spare_room(SolverData& data) {
  const SpareRoom& spare = data.options.spare;
  for (Index copy = 0; copy < data.copy_count(); ++copy) {
    CopyState& state = data.copy(copy);
    const std::size_t count = state.particles.size() + static_cast<std::size_t>(spare.vertices);
    state.particles.reserve(count);
    state.velocities.reserve(count);
    state.falling.reserve(state.falling.empty() ? 0 : count);
  }
  const auto vertices = static_cast<std::size_t>(spare.vertices);
  const auto tets = static_cast<std::size_t>(spare.tets);
  const auto edges = static_cast<std::size_t>(spare.edges);
  const auto links = static_cast<std::size_t>(spare.links);
  const auto reserve = [](std::size_t count, auto&... lists) {
    (lists.reserve(lists.size() + count), ...);
  };
  reserve(vertices, data.previous, data.place_of_vertex, data.vertex_masses,
          data.later_vertex_bodies);
  reserve(tets, data.tets, data.tet_edges, data.tet_alive, data.tet_masses, data.later_tet_bodies);
  reserve(edges, data.edges, data.edge_tets);
  reserve(links, data.links);
  data.distance_ids.reserve(edges, links);
  constexpr std::size_t kTetsAtVertex = 64, kLinksAtVertex = 8;  // room for a list that moves
  data.vertex_tets.reserve(vertices, 4 * kTetsAtVertex * tets);
  data.vertex_links.reserve(vertices, 2 * kLinksAtVertex * links);
  reserve_groups(data, PhaseKind::distance, edges + links);
  reserve_groups(data, PhaseKind::volume, tets);
  reserve_groups(data, PhaseKind::neo_hookean, tets);
  reserve_groups(data, PhaseKind::strain_limit, edges);
  data.journal.reserve(vertices, tets, edges, links);
  constexpr std::size_t kToolPhases = 64;
  data.plan.phases.reserve(data.constraint_phases.size() + kToolPhases);
}

}  // namespace pbdsurg
