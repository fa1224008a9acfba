// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/state/state_follower.h"

#include <algorithm>
#include <memory_resource>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/undo_array.h"

#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/sets/nested_domains.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {

void StateFollower::reserve(std::size_t vertices) {
  const auto reserve_more = [vertices](auto&... lists) {
    (lists.reserve(lists.size() + vertices), ...);
  };
  for (Index i = 0; i < state_.copy_count(); ++i) {
    CopyState& copy = state_.copy(i);
    reserve_more(copy.particles, copy.velocities);
    if (!copy.carries.empty()) {
      reserve_more(copy.carries);
    }
    if (!copy.ways.empty()) {
      reserve_more(copy.ways, copy.velocities_before);
    }
    if (!copy.forces.empty()) {
      reserve_more(copy.forces);
    }
  }
  reserve_more(state_.place_of_vertex);
  if (!state_.body_gravities.empty()) {
    reserve_more(state_.gravities);
  }
  const std::size_t stopping = std::min(vertices, kEntriesOfEdit);
  stopped_.reserve(stopping);
  motions_.reserve(stopping);
  asked_.reserve(stopping);
}

std::size_t StateFollower::memory_bytes() const noexcept {
  return (stopped_.capacity() + asked_.capacity()) * sizeof(Index) +
         motions_.capacity() * sizeof(VertexMotion) + is_motion_asked_.capacity() / 8;
}

void StateFollower::validate(const Tissue& tissue, const TopologyEdit& edit) const {
  const std::size_t count = static_cast<std::size_t>(tissue.vertex_count()) +
                            edit.new_vertices.size() +
                            static_cast<std::size_t>(edit.new_bodies.vertex_count());
  if (count > static_cast<std::size_t>(kMostParticles)) {
    throw InvalidArgument("with " + std::to_string(edit.new_vertices.size()) +
                          " new vertices and " + std::to_string(edit.new_bodies.vertex_count()) +
                          " of new bodies there would be " + std::to_string(count) +
                          "; a solver takes " + std::to_string(kMostParticles) + " at most");
  }
  if (edit.new_vertices.empty() && edit.new_bodies.bodies().empty() && edit.fix_vertices.empty() &&
      edit.unfix_vertices.empty() && !state_.has_grips()) {
    return;  // all else leaves a step that runs alone
  }
  std::pmr::vector<Index> read(state_.scratch.get());
  for (const NewVertex& vertex : edit.new_vertices) {
    read.insert(read.end(), {vertex.first, vertex.second});
  }
  read.insert(read.end(), edit.fix_vertices.begin(), edit.fix_vertices.end());
  read.insert(read.end(), edit.unfix_vertices.begin(), edit.unfix_vertices.end());
  state_.finish_running_step();
  if (!read.empty()) {
    state_.fetch_motion(read);
  }
}

void StateFollower::follow(const Tissue& tissue, const TissueChange& change) noexcept {
  try {
    lost_motion_ = nullptr;
    keep_motion(change);
  } catch (...) {  // the device failed: the edit stands, and cannot be undone
    lost_motion_ = std::current_exception();
  }
  for (const NewVertex& vertex : change.edit.new_vertices) {
    add_vertex(tissue, vertex);
  }
  add_bodies(change.edit.new_bodies, change.first_vertex_of_bodies());
  set_inverse_masses(tissue, change);
  log_fixing(change.edit);
  log_tets(change, tissue.tets().size());
  state_.releases.clear();
  state_.grip_releases.clear();
  if (!change.emptied_vertices.empty()) {
    release_dead(tissue);
  }
  if (state_.has_grips()) {
    release_dead_points(tissue);
  }
  has_other_holds_ = !state_.releases.empty() || !state_.grip_releases.empty();
  if (change.brings_vertices()) {
    state_.reserve_tools();
  }
}

// Keeps in mind how vertices move that stop, or has the backend do so; waits for no step.
void StateFollower::keep_motion(const TissueChange& change) {
  stopped_ = change.emptied_vertices;
  stopped_.insert(stopped_.end(), change.edit.fix_vertices.begin(), change.edit.fix_vertices.end());
  std::ranges::sort(stopped_);
  const std::size_t count = stopped_.size();
  motions_.resize(static_cast<std::size_t>(state_.copy_count()) * count);
  is_motion_asked_.assign(static_cast<std::size_t>(state_.copy_count()), false);
  asked_.clear();
  bool asks = false;
  auto motion = motions_.begin();
  for (Index i = 0; i < state_.copy_count() && count > 0; ++i) {
    const CopyState& copy = state_.copy(i);
    motion = std::ranges::transform(stopped_, motion, [&](Index v) {
               return copy.motion_of(state_.place_of_vertex[v]);
             }).out;
    is_motion_asked_[i] = !copy.is_state_current;
    asks = asks || !copy.is_state_current;
  }
  if (!asks) {
    return;
  }
  state_.read_places.clear();
  for (std::size_t k = 0; k < count; ++k) {
    if (!state_.changes.has_moved(stopped_[k])) {
      asked_.push_back(static_cast<Index>(k));
      state_.read_places.push_back(state_.place_of_vertex[stopped_[k]]);
    }
  }
  state_.backend->ask_for_motion(state_.read_places);
}

// Brings what the backend keeps in mind of that into motions_; waits.
void StateFollower::collect_motion() const {
  std::pmr::vector<VertexMotion> motions(asked_.size(), state_.scratch.get());
  for (Index i = 0; i < state_.copy_count() && !motions.empty(); ++i) {
    if (!is_motion_asked_[i]) {
      continue;
    }
    state_.backend->collect_motion(i, motions);
    const std::size_t first = static_cast<std::size_t>(i) * stopped_.size();
    for (std::size_t k = 0; k < motions.size(); ++k) {
      motions_[first + static_cast<std::size_t>(asked_[k])] = motions[k];
    }
  }
}

void StateFollower::add_vertex(const Tissue& tissue, const NewVertex& vertex) {
  const Index a = state_.place_of_vertex[vertex.first];
  const Index b = state_.place_of_vertex[vertex.second];
  const auto place = static_cast<Index>(state_.particles.size());
  const float share = vertex.share;
  const auto between = [&](float from, float to) { return from + share * (to - from); };
  const float w = tissue.is_fixed(place) ? 0.0F : 1.0F;  // until its mass is known
  for (Index i = 0; i < state_.copy_count(); ++i) {
    CopyState& copy = state_.copy(i);
    const Particle p = copy.particles[a], q = copy.particles[b];
    const Velocity u = copy.velocities[a], v = copy.velocities[b];
    copy.particles.push_back({between(p.x, q.x), between(p.y, q.y), between(p.z, q.z), w});
    copy.velocities.push_back({between(u.x, v.x), between(u.y, v.y), between(u.z, v.z)});
    if (!copy.carries.empty()) {
      const Carry c = copy.carries[a], d = copy.carries[b];
      copy.carries.push_back(
          {between(c.x, d.x), between(c.y, d.y), between(c.z, d.z), between(c.falling, d.falling)});
    }
    if (!copy.ways.empty()) {
      const Way e = copy.ways[a], f = copy.ways[b];
      copy.ways.push_back({between(e.x, f.x), between(e.y, f.y), between(e.z, f.z)});
      const Velocity s = copy.velocities_before[a], t = copy.velocities_before[b];
      copy.velocities_before.push_back({between(s.x, t.x), between(s.y, t.y), between(s.z, t.z)});
    }
    if (!copy.forces.empty()) {
      copy.forces.push_back({});
    }
  }
  if (!state_.gravities.empty()) {
    state_.gravities.push_back(state_.gravities[a]);
  }
  state_.place_of_vertex.push_back(place);  // new vertices have the places of their ids
  state_.log_moved(place);
}

void StateFollower::add_bodies(const Scene& scene, Index first_vertex) {
  if (scene.bodies().empty()) {
    return;
  }
  const std::vector<Index> places = order_vertices(scene.positions());
  const std::size_t count = state_.particles.size() + places.size();
  for (Index i = 0; i < state_.copy_count(); ++i) {
    CopyState& copy = state_.copy(i);
    copy.particles.resize(count);
    copy.velocities.resize(count);
    copy.carries.resize(has_displacements(state_.options) ? count : 0);
    copy.forces.resize(copy.forces.empty() ? 0 : count);
    for (std::size_t v = 0; v < places.size(); ++v) {
      const Eigen::Vector3f x = scene.positions()[v].cast<float>();
      copy.particles[first_vertex + places[v]] = {x.x(), x.y(), x.z(), 0};
    }
    if (has_past(state_.options)) {  // as if they had risen, and were now at the top
      const float h = copy.past_substep;
      const Eigen::Vector3f speed = h * state_.gravity;
      const Eigen::Vector3f way = (-h / 2) * speed;
      copy.ways.resize(count, {way.x(), way.y(), way.z()});
      copy.velocities_before.resize(count, {-speed.x(), -speed.y(), -speed.z()});
    }
    if (is_explicit(state_.options)) {  // likewise: velocities are those half a substep before
      const Eigen::Vector3f speed = (-copy.past_substep / 2) * state_.gravity;
      for (Index v = 0; v < scene.vertex_count(); ++v) {
        if (!scene.is_fixed(v)) {
          copy.velocities[first_vertex + places[v]] = {speed.x(), speed.y(), speed.z()};
        }
      }
    }
  }
  if (!state_.body_gravities.empty()) {
    state_.gravities.resize(count, gravity_load(state_.gravity));
    state_.body_gravities.resize(state_.body_gravities.size() + scene.bodies().size(),
                                 state_.gravity);
  }
  for (const Index place : places) {
    state_.log_moved(static_cast<Index>(state_.place_of_vertex.size()));
    state_.place_of_vertex.push_back(first_vertex + place);
  }
}

// Of vertices that are there before and after an edit.
void StateFollower::set_inverse_masses(const Tissue& tissue, const TissueChange& change) {
  const auto set = [&](Index v) {
    if (v < tissue.vertex_count()) {
      const bool moves = tissue.masses()[v] > 0 && !tissue.is_fixed(v);
      state_.set_inverse_mass(v, moves ? static_cast<float>(1 / tissue.masses()[v]) : 0.0F);
    }
  };
  std::ranges::for_each(change.weighed_vertices, set);
  std::ranges::for_each(change.edit.fix_vertices, set);
  std::ranges::for_each(change.edit.unfix_vertices, set);
}

// Those that stop or move again do so from where they are here, whatever came before and after it
// in one step.
void StateFollower::log_fixing(const TopologyEdit& edit) {
  std::ranges::for_each(edit.fix_vertices, [&](Index v) { state_.log_moved(v); });
  std::ranges::for_each(edit.unfix_vertices, [&](Index v) { state_.log_moved(v); });
}

// Those that an edit, or its undo, added, removed or gave other vertices.
void StateFollower::log_tets(const TissueChange& change, std::size_t tet_count) {
  std::ranges::for_each(change.removed_tets, [&](Index tet) { state_.log_tet(tet); });
  for (const ReshapedTet& reshaped : change.reshaped_tets) {
    state_.log_tet(reshaped.tet);
  }
  for (auto tet = static_cast<std::size_t>(change.first_new_tet); tet < tet_count; ++tet) {
    state_.log_tet(static_cast<Index>(tet));
  }
}

void StateFollower::release_dead(const Tissue& tissue) {
  const auto is_dead = [&](const Attachment& held) {
    return tissue.tets_at(held.vertex).empty() && !tissue.has_tissue(held.vertex);
  };
  for (Index i = 0; i < state_.copy_count(); ++i) {
    bool releases = false;
    std::vector<ToolState>& tools = state_.copy(i).tools;
    for (std::size_t t = 0; t < tools.size(); ++t) {
      std::vector<Attachment>& attachments = tools[t].attachments;
      auto held = std::ranges::find_if(attachments, is_dead);
      for (; held != attachments.end(); held = std::find_if(held, attachments.end(), is_dead)) {
        state_.releases.push_back({i, static_cast<Index>(t),
                                   static_cast<std::size_t>(held - attachments.begin()), *held});
        held = attachments.erase(held);
        releases = true;
      }
    }
    if (releases) {
      state_.copy(i).color_attachments();
      state_.changes.tools = true;
    }
  }
}

void StateFollower::release_dead_points(const Tissue& tissue) {
  const auto is_dead = [&](const GripPoint& held) { return !is_on_tissue(tissue, held.at); };
  for (Index i = 0; i < state_.copy_count(); ++i) {
    std::vector<ToolState>& tools = state_.copy(i).tools;
    for (std::size_t t = 0; t < tools.size(); ++t) {
      std::vector<GripPoint>& points = tools[t].grip.points;
      const std::size_t before = points.size();
      for (auto held = std::ranges::find_if(points, is_dead); held != points.end();
           held = std::find_if(held, points.end(), is_dead)) {
        state_.grip_releases.push_back(
            {i, static_cast<Index>(t), static_cast<std::size_t>(held - points.begin()), *held});
        held = points.erase(held);
      }
      if (points.size() != before) {
        tools[t].grip.find_corners();
        state_.changes.tools = true;
      }
    }
  }
}

void StateFollower::hold_again() {
  for (; !state_.grip_releases.empty(); state_.grip_releases.pop_back()) {
    const SolverState::GripRelease& release = state_.grip_releases.back();
    ToolGrip& grip = state_.copy(release.copy).tools[release.tool].grip;
    // others may have left the pad since
    const std::size_t entry = std::min(release.entry, grip.points.size());
    grip.points.insert(grip.points.begin() + static_cast<std::ptrdiff_t>(entry), release.point);
    grip.find_corners();
    state_.changes.tools = true;
  }
}

void StateFollower::validate_undo(const Tissue&, const TissueChange& change) const {
  state_.finish_running_step();
  const auto is_of_edit = [&](Index place) {  // new vertices have the places that follow
    return place >= change.first_new_vertex;
  };
  if (std::ranges::any_of(state_.watched_places, is_of_edit)) {
    throw InvalidArgument("a vertex that the edit brought is watched; watch others first");
  }
  if (lost_motion_ != nullptr) {
    std::rethrow_exception(lost_motion_);
  }
  collect_motion();
  if (!change.edit.unfix_vertices.empty()) {
    state_.fetch_motion(change.edit.unfix_vertices);
  }
}

void StateFollower::undo(const Tissue& tissue, const TissueChange& change) noexcept {
  const std::size_t tet_count = static_cast<std::size_t>(change.first_new_tet) +
                                change.edit.new_tets.size() + change.edit.new_bodies.tets().size();
  log_tets(change, tet_count);
  const Index end = change.first_new_vertex;
  bool lets_go = release_from(end);
  if (change.brings_vertices()) {
    for (Index i = 0; i < state_.copy_count(); ++i) {
      CopyState& copy = state_.copy(i);
      copy.particles.resize(static_cast<std::size_t>(end));
      copy.velocities.resize(static_cast<std::size_t>(end));
      copy.carries.resize(copy.carries.empty() ? 0 : static_cast<std::size_t>(end));
      copy.ways.resize(copy.ways.empty() ? 0 : static_cast<std::size_t>(end));
      copy.velocities_before.resize(copy.ways.size());
      copy.forces.resize(copy.forces.empty() ? 0 : static_cast<std::size_t>(end));
    }
    if (!state_.body_gravities.empty()) {
      state_.gravities.resize(static_cast<std::size_t>(end));
      state_.body_gravities.resize(tissue.bodies().size());
    }
    state_.place_of_vertex.resize(static_cast<std::size_t>(end));
    const auto is_gone = [&](Index place) { return place >= end; };
    std::erase_if(state_.changes.vertices, is_gone);
    std::erase_if(state_.changes.moved, is_gone);
    std::erase_if(state_.changes.forces,
                  [&](const Changes::Force& force) { return is_gone(force.place); });
  }
  set_inverse_masses(tissue, change);  // those that had stopped move on
  auto motion = motions_.begin();
  for (Index i = 0; i < state_.copy_count(); ++i) {
    for (const Index v : stopped_) {
      state_.copy(i).set_motion(state_.place_of_vertex[v], *motion++);
    }
  }
  std::ranges::for_each(stopped_, [&](Index v) { state_.log_moved(v); });
  log_fixing(change.edit);
  has_other_holds_ = !state_.releases.empty() || !state_.grip_releases.empty() || lets_go;
  hold_again();
  if (state_.has_grips()) {  // on what the edit had made
    release_dead_points(tissue);
    has_other_holds_ = has_other_holds_ || !state_.grip_releases.empty();
    state_.grip_releases.clear();
  }
  const bool holds_again = !state_.releases.empty();
  for (; !state_.releases.empty(); state_.releases.pop_back()) {
    const SolverState::Release& release = state_.releases.back();
    std::vector<Attachment>& attachments =
        state_.copy(release.copy).tools[release.tool].attachments;
    attachments.insert(attachments.begin() + static_cast<std::ptrdiff_t>(release.entry),
                       release.attachment);
  }
  for (Index i = 0; i < state_.copy_count() && holds_again; ++i) {
    state_.copy(i).color_attachments();
    state_.changes.tools = true;
  }
}

// Lets tools of all copies go of vertices from an id on, which are about to go themselves.
bool StateFollower::release_from(Index vertex) {
  bool lets_go = false;
  for (Index i = 0; i < state_.copy_count(); ++i) {
    std::size_t released = 0;
    for (ToolState& tool : state_.copy(i).tools) {
      released += std::erase_if(tool.attachments,
                                [&](const Attachment& held) { return held.vertex >= vertex; });
    }
    if (released > 0) {
      state_.copy(i).color_attachments();
      state_.changes.tools = true;
      lets_go = true;
    }
    for (ToolState& tool : state_.copy(i).tools) {
      const std::size_t gone = std::erase_if(tool.grip.points, [&](const GripPoint& held) {
        return std::ranges::max(held.at.vertices) >= vertex;
      });
      if (gone > 0) {
        tool.grip.find_corners();
        state_.changes.tools = true;
        lets_go = true;
      }
    }
  }
  return lets_go;
}

}  // namespace pbdsurg
