// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/solver_state.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/state/load_store.h"

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

bool CopyState::pushes(Index tool) const noexcept {
  const ToolState& state = tools[tool];
  return (!state.capsules.empty() || !state.half_spaces.empty()) && !state.holds() &&
         std::ranges::none_of(tools, [&](const ToolState& other) {
           return other.grip.is_shut() &&
                  (other.grip.jaws[0] == tool || other.grip.jaws[1] == tool);
         });
}

void SolverState::finish_running_step() {
  if (step_in_flight != Step::running) {
    return;
  }
  if (backend->keeps_state()) {
    step_in_flight = Step::none;  // also if the backend fails
    report = backend->finish_step(*this);
  }
  step_in_flight = Step::finished;
  if (backend->keeps_state() && end_step != nullptr) {
    end_step(*this);
  }
}

bool SolverState::has_grips() const noexcept {
  for (Index i = 0; i < copy_count(); ++i) {
    if (std::ranges::any_of(copy(i).tools,
                            [](const ToolState& tool) { return tool.grip.is_shut(); })) {
      return true;
    }
  }
  return false;
}

void SolverState::fetch_state(Index index) {
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
      state.stop(place);
    }
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    state.set_motion(place_of_vertex[changes.moved[i]], moved[i]);
  }
  state.is_state_current = true;
}

void SolverState::fetch_motion(std::span<const Index> vertices) {
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

void SolverState::read_positions(Index index, std::span<const Index> vertices,
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
  if (unread == vertices.size()) {
    return;
  }
  for (std::size_t i = vertices.size(); i-- > 0;) {  // what was read moves back to make room
    const Particle& p = state.particles[place_of_vertex[vertices[i]]];
    out[i] = is_here(vertices[i]) ? Eigen::Vector3f(p.x, p.y, p.z) : out[--unread];
  }
}

SubstepRule SolverState::rule_of_copies() const noexcept {
  double haste = 1;
  for (Index i = 0; i < copy_count(); ++i) {
    const CopyFactors& own = copy(i).factors;
    haste = std::max(haste, double{own.stiffness} / double{own.density});
  }
  return hastened(substep_rule, haste);
}

void SolverState::set_body_gravities(const Tissue& tissue, std::vector<Eigen::Vector3f> own) {
  std::vector<Load> loads;
  if (!own.empty()) {
    loads.reserve(particles.capacity());
    loads.resize(particles.size());
    for (Index v = 0; v < tissue.vertex_count(); ++v) {
      loads[place_of_vertex[v]] = gravity_load(own[tissue.body_of_vertex(v)]);
    }
    own.reserve(own.size() + 1);
  }
  body_gravities = std::move(own);
  gravities = std::move(loads);
  changes.gravities = true;
}

void SolverState::set_inverse_mass(Index vertex, float w) {
  const Index place = place_of_vertex[vertex];
  for (Index i = 0; i < copy_count(); ++i) {
    CopyState& state = copy(i);
    state.particles[place].w = w;
    if (w == 0) {
      state.stop(place);
    }
  }
  log_vertex(vertex);
}

void SolverState::log_constraint(PhaseKind kind, Index id) {
  if (backend->keeps_state()) {
    changes.constraints.push_back({kind, id});
  }
}

void SolverState::log_tet(Index tet) {
  if (backend->keeps_state()) {
    changes.tets.push_back(tet);
  }
}

void SolverState::log_vertex(Index vertex) {
  if (backend->keeps_state()) {
    changes.vertices.push_back(place_of_vertex[vertex]);
  }
}

void SolverState::log_moved(Index vertex) {
  if (backend->keeps_state()) {
    changes.add_moved(vertex);
  }
}

void SolverState::log_force(Index index, Index place) {
  if (backend->keeps_state()) {
    changes.forces.push_back({index, place});
  }
}

void SolverState::log_growth() {
  changes.grown = changes.grown || backend->keeps_state();
}

void SolverState::log_rows(const VertexBlocks& blocks, bool are_anew) {
  if (!backend->keeps_state()) {
    return;
  }
  changes.rows_anew = changes.rows_anew || are_anew;
  if (!are_anew) {
    for (const Index place : blocks.refreshed()) {
      log_constraint(PhaseKind::vertex, place);
    }
    const auto changed = blocks.changed_blocks();
    changes.blocks.insert(changes.blocks.end(), changed.begin(), changed.end());
  }
}

void SolverState::log_shares(std::span<const Index> places) {
  if (backend->keeps_state()) {
    changes.shares.insert(changes.shares.end(), places.begin(), places.end());
  }
}

void SolverState::forget_releases(Index index, Index tool) {
  const auto is_of_tool = [&](const auto& release) {
    return release.copy == index && release.tool == tool;
  };
  std::erase_if(releases, is_of_tool);
  std::erase_if(grip_releases, is_of_tool);
}

void SolverState::reserve_tool(ToolState& tool) const {
  tool.placed_capsules.reserve(tool.capsules.size());
  if (tool.has_surface()) {
    const auto most = static_cast<std::size_t>(options.contact_capacity);
    tool.capsules_before.reserve(tool.capsules.size());
    tool.surface_contacts.reserve(most);
    tool.remembered.reserve(most);
  } else if (!backend->keeps_state()) {
    tool.contacts.reserve(
        std::min(particles.size(), static_cast<std::size_t>(options.contact_capacity)));
  }
}

void SolverState::reserve_tools() {
  for (Index i = 0; i < copy_count(); ++i) {
    for (ToolState& tool : copy(i).tools) {
      reserve_tool(tool);
    }
  }
}

void SolverState::reserve_touches() {
  for (Index i = 0; i < copy_count(); ++i) {
    const auto most = static_cast<std::size_t>(options.contact_capacity);
    copy(i).touches.contacts.reserve(most);
    copy(i).touches.remembered.reserve(most);
  }
}

namespace {

template <class... Arrays>
std::size_t bytes_of(const Arrays&... arrays) noexcept {
  return (... + (arrays.capacity() * sizeof(arrays[0])));
}

}  // namespace

std::size_t CopyState::memory_bytes() const noexcept {
  std::size_t bytes =
      bytes_of(particles, velocities, carries, ways, velocities_before, forces, watched_positions);
  for (const ToolState& tool : tools) {
    bytes +=
        bytes_of(tool.capsules, tool.attachments, tool.placed_capsules, tool.capsules_before,
                 tool.contacts, tool.surface_contacts, tool.remembered, tool.told, tool.joints);
    bytes += tool.grip.memory_bytes();
  }
  bytes += near.memory_bytes() + bytes_of(touches.contacts, touches.remembered, touches.told,
                                          touches.search.seen, touches.search.moved_squares,
                                          touches.search.candidates, touches.search.slots,
                                          touches.search.edges, touches.search.near);
  for (const std::vector<TouchTree>* trees : {&touches.search.trees, &touches.search.edge_trees}) {
    for (const TouchTree& tree : *trees) {
      bytes += sizeof(tree) + bytes_of(tree.order, tree.boxes);
    }
  }
  return bytes;
}

std::vector<Index> SolverState::vertices_at_places() const {
  std::vector<Index> vertices(place_of_vertex.size());
  for (std::size_t v = 0; v < vertices.size(); ++v) {
    vertices[place_of_vertex[v]] = static_cast<Index>(v);
  }
  return vertices;
}

std::size_t SolverState::memory_bytes() const noexcept {
  std::size_t bytes =
      bytes_of(place_of_vertex, watched_places, read_places, releases, grip_releases, changes.moved,
               changes.vertices, changes.constraints, changes.tets, changes.blocks, changes.shares,
               changes.forces, body_gravities, gravities);
  for (Index i = 0; i < copy_count(); ++i) {
    bytes += copy(i).memory_bytes();
  }
  return bytes;
}

}  // namespace pbdsurg
