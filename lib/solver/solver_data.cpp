// SPDX-License-Identifier: Apache-2.0
#include "solver/solver_data.h"

#include <algorithm>
#include <unordered_map>

#include "solver/backend.h"
#include "solver/growth.h"

namespace pbdsurg {

void CopyState::color_attachments() {
  attachment_colors = 0;
  std::unordered_map<Index, Index> holders;
  for (ToolState& tool : tools) {
    for (Attachment& attachment : tool.attachments) {
      attachment.color = holders[attachment.vertex]++;
      attachment_colors = std::max(attachment_colors, attachment.color + 1);
    }
  }
}

void SolverData::start_step(float dt) {
  if (!backend->keeps_state()) {
    report = step_copies(*this, *backend, dt);
    for (Index i = 0; i < copy_count(); ++i) {
      backend->read_positions(*this, i, watched_places, copy(i).watched_positions);
    }
  } else {
    try {
      backend->start_step(*this, dt);
    } catch (...) {  // part of it may be done: what the host has is the state
      for (Index i = 0; i < copy_count(); ++i) {
        changes.state[i] = changes.state[i] || copy(i).is_state_current;
      }
      throw;
    }
    for (Index i = 0; i < copy_count(); ++i) {
      copy(i).is_state_current = false;
    }
  }
  step_in_flight = Step::running;
  changes.clear();
}

void SolverData::finish_running_step() {
  if (step_in_flight != Step::running) {
    return;
  }
  if (backend->keeps_state()) {
    step_in_flight = Step::none;  // also if the backend fails
    report = backend->finish_step(*this);
  }
  step_in_flight = Step::finished;
}

void SolverData::fetch_state(Index index) {
  finish_running_step();
  CopyState& state = copy(index);
  if (state.is_state_current) {
    return;
  }
  std::pmr::vector<VertexMotion> moved(scratch.get());  // of these the backend has not heard yet
  for (const Index v : changes.moved) {
    moved.push_back(state.motion_of(place_of_vertex[v]));
  }
  backend->fetch_state(*this, index);
  for (const Index place : changes.vertices) {
    if (state.particles[place].w == 0) {
      state.velocities[place] = {};
    }
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    state.set_motion(place_of_vertex[changes.moved[i]], moved[i]);
  }
  state.is_state_current = true;
}

void SolverData::fetch_motion(std::span<const Index> vertices) {
  finish_running_step();
  read_places.clear();
  for (const Index v : vertices) {
    if (!changes.has_moved(v)) {
      read_places.push_back(place_of_vertex[v]);
    }
  }
  bool is_current = true;
  for (Index i = 0; i < copy_count(); ++i) {
    is_current = is_current && copy(i).is_state_current;
  }
  if (read_places.empty() || is_current) {
    return;
  }
  backend->ask_for_motion(read_places);
  std::pmr::vector<VertexMotion> motions(read_places.size(), scratch.get());
  for (Index i = 0; i < copy_count(); ++i) {
    CopyState& state = copy(i);
    if (state.is_state_current) {
      continue;
    }
    backend->collect_motion(i, motions);
    for (std::size_t k = 0; k < motions.size(); ++k) {
      state.set_motion(read_places[k], motions[k]);
    }
  }
}

void SolverData::read_positions(Index index, std::span<const Index> vertices,
                                std::span<Eigen::Vector3f> out) {
  finish_running_step();
  const CopyState& state = copy(index);
  const auto is_here = [&](Index v) { return state.is_state_current || changes.has_moved(v); };
  read_places.clear();
  for (const Index v : vertices) {
    if (!is_here(v)) {
      read_places.push_back(place_of_vertex[v]);
    }
  }
  std::size_t unread = read_places.size();
  if (unread > 0) {
    backend->read_positions(*this, index, read_places, out.first(unread));
  }
  for (std::size_t i = vertices.size(); i-- > 0;) {  // what was read moves back to make room
    const Particle& p = state.particles[place_of_vertex[vertices[i]]];
    out[i] = is_here(vertices[i]) ? Eigen::Vector3f(p.x, p.y, p.z) : out[--unread];
  }
}

void SolverData::set_inverse_mass(Index vertex, float w) {
  const Index place = place_of_vertex[vertex];
  for (Index i = 0; i < copy_count(); ++i) {
    CopyState& state = copy(i);
    state.particles[place].w = w;
    if (w == 0) {
      state.velocities[place] = {};
    }
  }
  log_vertex(vertex);
}

void SolverData::set_mass(Index vertex, double mass) {
  const float w = particle(vertex).w;
  journal.masses.push_back({vertex, vertex_masses[vertex], w});
  count_mass(vertex, mass);
  if (mass == 0) {
    set_inverse_mass(vertex, 0);
  } else if (w > 0) {
    set_inverse_mass(vertex, static_cast<float>(1 / mass));
  }
}

void SolverData::count_mass(Index vertex, double mass) {
  const int change = (mass > 0 ? 1 : 0) - (vertex_masses[vertex] > 0 ? 1 : 0);
  if (change != 0) {
    tissue_counts[body_of_vertex(vertex)] += change;
  }
  vertex_masses[vertex] = mass;
}

void SolverData::log_constraint(PhaseKind kind, Index id) {
  if (backend->keeps_state()) {
    changes.constraints.push_back({kind, id});
  }
}

void SolverData::log_tet(Index tet) {
  if (backend->keeps_state()) {
    changes.tets.push_back(tet);
  }
}

void SolverData::log_vertex(Index vertex) {
  if (backend->keeps_state()) {
    changes.vertices.push_back(place_of_vertex[vertex]);
  }
}

void SolverData::log_moved(Index vertex) {
  if (backend->keeps_state()) {
    changes.add_moved(vertex);
  }
}

Index SolverData::joint_group_of(Index edge) const noexcept {
  const Index owner = edge_owners[edge];
  const auto& edges_of_owner = tet_edges[owner];
  const auto place = std::find(edges_of_owner.begin(), edges_of_owner.end(), edge);
  return joint_group(volumes.group_of(owner), static_cast<Index>(place - edges_of_owner.begin()));
}

void SolverData::set_tet(Index tet, const Tet& vertices, const std::array<Index, 6>& edges_of_tet) {
  journal.shapes.push_back({tet, tets[tet], tet_edges[tet]});
  tets[tet] = vertices;
  tet_edges[tet] = edges_of_tet;
}

void SolverData::set_edge_tets(Index edge, Index count) {
  journal.edge_tets.push_back({edge, edge_tets[edge]});
  edge_tets[edge] = count;
}

void SolverData::set_edge(Index edge, const Edge& ends) {
  journal.edges.push_back({edge, edges[edge][0], edges[edge][1]});
  edges[edge] = ends;
}

void SolverData::set_link(Index link, Index first, Index second) {
  journal.links.push_back({link, links[link].first, links[link].second});
  links[link].first = first;
  links[link].second = second;
}

void SolverData::add_tet_at(Index vertex, Index tet) {
  journal.tet_entries.push_back({vertex, tet, true});
  vertex_tets.insert(vertex, tet);
}

void SolverData::remove_tet_at(Index vertex, Index tet) {
  journal.tet_entries.push_back({vertex, tet, false});
  vertex_tets.erase(vertex, tet);
}

void SolverData::add_link_at(Index vertex, Index link) {
  journal.link_entries.push_back({vertex, link, true});
  vertex_links.insert(vertex, link);
}

void SolverData::remove_link_at(Index vertex, Index link) {
  journal.link_entries.push_back({vertex, link, false});
  vertex_links.erase(vertex, link);
}

Index SolverData::body_of_vertex(Index vertex) const noexcept {
  const Index later =
      vertex - static_cast<Index>(place_of_vertex.size() - later_vertex_bodies.size());
  if (later >= 0) {
    return later_vertex_bodies[later];
  }
  const auto after = std::ranges::upper_bound(bodies, vertex, {}, &Body::first_vertex);
  return static_cast<Index>(after - bodies.begin()) - 1;
}

Index SolverData::body_of_tet(Index tet) const noexcept {
  const Index later = tet - static_cast<Index>(tets.size() - later_tet_bodies.size());
  if (later >= 0) {
    return later_tet_bodies[later];
  }
  const auto after = std::ranges::upper_bound(bodies, tet, {}, &Body::first_tet);
  return static_cast<Index>(after - bodies.begin()) - 1;
}

Index SolverData::first_later_vertex(Index body) const noexcept {
  const Body& own = bodies[body];
  return std::max(own.first_vertex + own.vertex_count,
                  static_cast<Index>(place_of_vertex.size() - later_vertex_bodies.size()));
}

Index SolverData::first_later_tet(Index body) const noexcept {
  const Body& own = bodies[body];
  return std::max(own.first_tet + own.tet_count,
                  static_cast<Index>(tets.size() - later_tet_bodies.size()));
}

void SolverData::remove_edge(Index edge) {
  const Index distance = distance_ids.of_edge(edge);
  if (distances.is_alive(distance)) {
    distances.remove(distance);
    log_constraint(PhaseKind::distance, distance);
  }
  if (strain_limits.is_alive(edge)) {
    strain_limits.remove(edge);
    log_constraint(PhaseKind::strain_limit, edge);
  }
  remove_vertex_spring(*this, distance);
}

void SolverData::hand_over(Index edge) {
  const Index distance = distance_ids.of_edge(edge);
  edge_owners.hand_over(edge, tet_edges, volumes);
  const bool is_alone = edge_owners[edge] == kInvalidIndex;
  if (is_alone) {
    log_growth();
  }
  distances.move(distance, is_alone ? find_free_group(*this, PhaseKind::distance, edges[edge])
                                    : joint_group_of(edge));
  log_constraint(PhaseKind::distance, distance);
}

void SolverData::remove_volume(Index tet) {
  volumes.remove(tet);
  log_constraint(PhaseKind::volume, tet);
  for (const Index edge : tet_edges[tet]) {
    if (edge_owners[edge] == tet && distances.is_alive(distance_ids.of_edge(edge))) {
      hand_over(edge);
    }
  }
}

void SolverData::release_dead_vertices() {
  const auto is_dead = [&](const Attachment& attachment) {
    return vertex_tets[attachment.vertex].empty() && vertex_masses[attachment.vertex] == 0;
  };
  for (Index i = 0; i < copy_count(); ++i) {
    bool releases = false;
    for (std::size_t t = 0; t < copy(i).tools.size(); ++t) {
      std::vector<Attachment>& attachments = copy(i).tools[t].attachments;
      auto held = std::ranges::find_if(attachments, is_dead);
      for (; held != attachments.end(); held = std::find_if(held, attachments.end(), is_dead)) {
        journal.releases.push_back({i, static_cast<Index>(t),
                                    static_cast<std::size_t>(held - attachments.begin()), *held});
        held = attachments.erase(held);
        releases = true;
      }
    }
    if (releases) {
      copy(i).color_attachments();
      changes.tools = true;
    }
  }
}

void SolverData::log_growth() {
  journal.is_growth = true;
  changes.grown = changes.grown || backend->keeps_state();
}

void SolverData::begin_edit(std::span<const Index> stopping, std::span<const Index> ends) {
  journal.is_open = false;
  journal.is_growth = false;
  journal.body_count = bodies.size();
  journal.vertex_count = particles.size();
  journal.tet_count = tets.size();
  journal.edge_count = edges.size();
  journal.link_count = links.size();
  journal.opened_groups.clear();
  journal.tets.clear();
  journal.shapes.clear();
  journal.edge_tets.clear();
  journal.edges.clear();
  journal.links.clear();
  journal.tet_entries.clear();
  journal.link_entries.clear();
  journal.before_growth.reset();
  journal.masses.clear();
  journal.releases.clear();
  journal.stopped.assign(stopping.begin(), stopping.end());
  if (!ends.empty()) {
    fetch_motion(ends);
  }
  keep_motion();
  distances.begin_edit();
  volumes.begin_edit();
  neo_hookeans.begin_edit();
  strain_limits.begin_edit();
  edge_owners.begin_edit();
  vertex_method.blocks.begin_edit();
}

void SolverData::keep_motion() {
  const std::size_t count = journal.stopped.size();
  journal.motions.resize(static_cast<std::size_t>(copy_count()) * count);
  journal.is_motion_asked.assign(static_cast<std::size_t>(copy_count()), false);
  journal.asked.clear();
  bool asks = false;
  auto motion = journal.motions.begin();
  for (Index i = 0; i < copy_count() && count > 0; ++i) {
    const CopyState& state = copy(i);
    motion = std::ranges::transform(journal.stopped, motion, [&](Index v) {
               return state.motion_of(place_of_vertex[v]);
             }).out;
    journal.is_motion_asked[i] = !state.is_state_current;
    asks = asks || !state.is_state_current;
  }
  if (!asks) {
    return;
  }
  read_places.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (!changes.has_moved(journal.stopped[k])) {
      journal.asked.push_back(static_cast<Index>(k));
      read_places.push_back(place_of_vertex[journal.stopped[k]]);
    }
  }
  backend->ask_for_motion(read_places);
}

void SolverData::collect_motion() {
  std::pmr::vector<VertexMotion> motions(journal.asked.size(), scratch.get());
  for (Index i = 0; i < copy_count() && !motions.empty(); ++i) {
    if (!journal.is_motion_asked[i]) {
      continue;
    }
    backend->collect_motion(i, motions);
    const std::size_t first = static_cast<std::size_t>(i) * journal.stopped.size();
    for (std::size_t k = 0; k < motions.size(); ++k) {
      journal.motions[first + static_cast<std::size_t>(journal.asked[k])] = motions[k];
    }
  }
}

void SolverData::end_edit(std::uint64_t fingerprint) {
  journal.is_open = true;
  journal.fingerprint = fingerprint;
  journal.version_before = topology_version;
  topology_version = ++last_topology_version;
}

void SolverData::undo_edit() {
  collect_motion();
  journal.is_open = false;  // nothing fails from here on
  const auto log_as = [&](PhaseKind kind) {
    return [this, kind](Index id) { log_constraint(kind, id); };
  };
  distances.undo(log_as(PhaseKind::distance));
  volumes.undo(log_as(PhaseKind::volume));
  neo_hookeans.undo(log_as(PhaseKind::neo_hookean));
  strain_limits.undo(log_as(PhaseKind::strain_limit));
  edge_owners.undo();
  for (const Index t : journal.tets) {
    tet_alive[t] = true;
    log_tet(t);
  }
  for (; !journal.shapes.empty(); journal.shapes.pop_back()) {
    const EditJournal::Shape& before = journal.shapes.back();
    tets[before.tet] = before.vertices;
    tet_edges[before.tet] = before.edges;
    log_tet(before.tet);
  }
  for (; !journal.edge_tets.empty(); journal.edge_tets.pop_back()) {
    edge_tets[journal.edge_tets.back().edge] = journal.edge_tets.back().count;
  }
  for (; !journal.edges.empty(); journal.edges.pop_back()) {
    const EditJournal::Ends& before = journal.edges.back();
    edges[before.id] = {before.first, before.second};
  }
  for (; !journal.links.empty(); journal.links.pop_back()) {
    const EditJournal::Ends& before = journal.links.back();
    links[before.id].first = before.first;
    links[before.id].second = before.second;
  }
  const auto undo_entries = [](std::vector<EditJournal::Entry>& entries, VertexLists& lists) {
    for (; !entries.empty(); entries.pop_back()) {
      const EditJournal::Entry& entry = entries.back();
      if (entry.was_added) {
        lists.erase(entry.vertex, entry.id);
      } else {
        lists.insert(entry.vertex, entry.id);
      }
    }
  };
  undo_entries(journal.tet_entries, vertex_tets);
  undo_entries(journal.link_entries, vertex_links);
  for (; !journal.masses.empty(); journal.masses.pop_back()) {
    const EditJournal::Mass& before = journal.masses.back();
    count_mass(before.vertex, before.mass);
    for (Index i = 0; i < copy_count(); ++i) {  // those that had stopped move on, see below
      copy(i).particles[place_of_vertex[before.vertex]].w = before.w;
    }
    log_vertex(before.vertex);
  }
  const bool lets_go = release_vertices_from(static_cast<Index>(journal.vertex_count));
  if (journal.is_growth) {
    undo_growth(*this);
  }
  undo_vertices(*this);
  auto motion = journal.motions.begin();
  for (Index i = 0; i < copy_count(); ++i) {
    CopyState& state = copy(i);
    for (const Index v : journal.stopped) {
      state.set_motion(place_of_vertex[v], *motion++);
    }
  }
  for (const Index v : journal.stopped) {
    log_moved(v);
  }
  const bool releases = !journal.releases.empty();
  for (; !journal.releases.empty(); journal.releases.pop_back()) {
    const EditJournal::Release& release = journal.releases.back();
    std::vector<Attachment>& attachments = copy(release.copy).tools[release.tool].attachments;
    attachments.insert(attachments.begin() + static_cast<std::ptrdiff_t>(release.entry),
                       release.attachment);
  }
  for (Index i = 0; i < copy_count() && releases; ++i) {
    copy(i).color_attachments();
    changes.tools = true;
  }
  update_plan(releases || lets_go);
  topology_version = journal.version_before;
}

bool SolverData::release_vertices_from(Index end) {
  bool lets_go = false;
  for (Index i = 0; i < copy_count(); ++i) {
    std::size_t released = 0;
    for (ToolState& tool : copy(i).tools) {
      released += std::erase_if(tool.attachments,
                                [&](const Attachment& held) { return held.vertex >= end; });
    }
    if (released > 0) {
      copy(i).color_attachments();
      changes.tools = true;
      lets_go = true;
    }
  }
  return lets_go;
}

void SolverData::forget_releases(Index index, Index tool) {
  std::erase_if(journal.releases, [&](const EditJournal::Release& release) {
    return release.copy == index && release.tool == tool;
  });
}

Index SolverData::constraint_count(const Phase& phase) const noexcept {
  switch (phase.kind) {
    case PhaseKind::distance:
      return distances.size(phase.color);
    case PhaseKind::volume:
    case PhaseKind::joint:
      return volumes.size(phase.color);
    case PhaseKind::neo_hookean:
      return neo_hookeans.size(phase.color);
    case PhaseKind::strain_limit:
      return strain_limits.size(phase.color);
    case PhaseKind::vertex:
    case PhaseKind::attachment:
    case PhaseKind::contact:
      break;
  }
  return 0;
}

void SolverData::update_plan(bool releases) {
  bool changes_phases = distances.take_change_of_groups();
  changes_phases |= volumes.take_change_of_groups();
  changes_phases |= neo_hookeans.take_change_of_groups();
  changes_phases |= strain_limits.take_change_of_groups();
  if (changes_phases || releases || journal.is_growth) {
    rebuild_plan();
  }
}

void SolverData::rebuild_plan() {
  plan.phases.clear();
  const bool by_vertices = options.method == SolverMethod::vertex_block;
  if (by_vertices) {
    reserve_holds(*this);
    for (Index color = 0; color < vertex_method.blocks.color_count(); ++color) {
      if (vertex_method.blocks.blocks(color).count > 0) {
        plan.phases.push_back({PhaseKind::vertex, color});
      }
    }
  }
  for (const Phase& phase : constraint_phases) {
    if (constraint_count(phase) > 0 && (!by_vertices || phase.kind == PhaseKind::strain_limit)) {
      plan.phases.push_back(phase);
    }
  }
  if (by_vertices) {  // tools act within it
    return;
  }
  // what a copy does not need does nothing there
  Index colors = 0;
  for (Index i = 0; i < copy_count(); ++i) {
    colors = std::max(colors, copy(i).attachment_colors);
  }
  for (Index color = 0; color < colors; ++color) {
    plan.phases.push_back({PhaseKind::attachment, color});
  }
  for (std::size_t tool = 0; tool < tools.size(); ++tool) {
    bool pushes = false;
    for (Index i = 0; i < copy_count() && !pushes; ++i) {
      const ToolState& state = copy(i).tools[tool];
      pushes = !state.capsules.empty() && state.attachments.empty();
    }
    if (pushes) {
      plan.phases.push_back({PhaseKind::contact, static_cast<Index>(tool)});
    }
  }
}

}  // namespace pbdsurg
