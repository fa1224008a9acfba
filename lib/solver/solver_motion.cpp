// SPDX-License-Identifier: Apache-2.0
// Positions and velocities of a solver: read, watched, written, kept and restored.
#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"

#include "lib/base/check.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/remembered_contacts.h"
#include "lib/solver/state/remembered_touches.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

void check_size(const char* what, std::size_t size, std::size_t expected) {
  if (size != expected) {
    throw InvalidArgument(std::string(what) + " has " + std::to_string(size) +
                          " entries; it needs " + std::to_string(expected));
  }
}

// Of what snapshots may leave out.
void check_size_if_any(const char* what, std::size_t size, std::size_t expected) {
  if (size != 0) {
    check_size(what, size, expected);
  }
}

void check_finite(const char* what, std::span<const Eigen::Vector3f> values) {
  for (std::size_t v = 0; v < values.size(); ++v) {
    if (!values[v].allFinite()) {
      throw InvalidArgument(std::string("the ") + what + " of vertex " + std::to_string(v) +
                            " is not finite");
    }
  }
}

// No step leaves larger ones, and these would move what is fixed.
void check_roundings(const Snapshot& snapshot) {
  check_finite("rounding", snapshot.roundings);
  float largest = 0;
  for (const Eigen::Vector3f& x : snapshot.positions) {
    largest = std::max(largest, x.lpNorm<Eigen::Infinity>());
  }
  for (std::size_t v = 0; v < snapshot.roundings.size(); ++v) {
    const float rounding = snapshot.roundings[v].lpNorm<Eigen::Infinity>();
    if (rounding > 0x1p-22F * largest) {
      throw InvalidArgument("the rounding of vertex " + std::to_string(v) + " is " +
                            std::to_string(rounding) + " m; it must be <= 2^-22 of " +
                            std::to_string(largest) + " m, the largest coordinate");
    }
  }
}

void check_displacement(const Eigen::Vector3f& displacement) {
  if (!displacement.allFinite()) {
    throw InvalidArgument("a displacement of a tool in the snapshot is not finite");
  }
}

std::vector<std::vector<float>> angles_of(std::span<const ToolState> tools) {
  std::vector<std::vector<float>> angles(tools.size());
  for (std::size_t t = 0; t < tools.size(); ++t) {
    for (const JointState& joint : tools[t].joints) {
      angles[t].push_back(joint.angle);
    }
  }
  return angles;
}

void check_angles(std::span<const std::vector<float>> angles, std::span<const ToolState> tools) {
  check_size_if_any("the snapshot's list of joints", angles.size(), tools.size());
  for (std::size_t t = 0; t < angles.size(); ++t) {
    if (tools[t].is_removed) {
      continue;
    }
    const std::string what = "the snapshot's joints of tool " + std::to_string(t);
    check_size(what.c_str(), angles[t].size(), tools[t].joints.size());
    std::ranges::for_each(angles[t], check_angle);
  }
}

}  // namespace

std::vector<Eigen::Vector3f> Solver::positions(Index copy) const {
  std::vector<Eigen::Vector3f> out(data_->particles.size());
  read_positions(out, copy);
  return out;
}

void Solver::read_positions(std::span<Eigen::Vector3f> out, Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  check_size("the buffer for positions", out.size(), state.particles.size());
  data_->fetch_state(copy);
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < out.size(); ++v) {
    const Particle& p = state.particles[places[v]];
    out[v] = {p.x, p.y, p.z};
  }
}

void Solver::read_positions(std::span<const Index> vertices, std::span<Eigen::Vector3f> out,
                            Index copy) const {
  checked_copy(*data_, copy);
  check_size("the buffer for positions", out.size(), vertices.size());
  const std::size_t vertex_count = data_->particles.size();
  for (const Index v : vertices) {
    check_id("vertex", v, vertex_count);
  }
  data_->read_positions(copy, vertices, out);
}

void Solver::watch(std::span<const Index> vertices) {
  const std::size_t vertex_count = data_->particles.size();
  for (const Index v : vertices) {
    check_id("vertex", v, vertex_count);
  }
  data_->finish_running_step();
  std::vector<Index> places;
  for (const Index v : vertices) {
    places.push_back(data_->place_of_vertex[v]);
  }
  std::vector<std::vector<Eigen::Vector3f>> watched(static_cast<std::size_t>(data_->copy_count()),
                                                    std::vector<Eigen::Vector3f>(vertices.size()));
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->read_positions(copy, vertices, watched[copy]);
  }
  data_->changes.watched = true;  // nothing fails from here on
  data_->watched_places = std::move(places);
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->copy(copy).watched_positions = std::move(watched[copy]);
  }
}

std::span<const Eigen::Vector3f> Solver::watched_positions(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->finish_running_step();
  return state.watched_positions;
}

void Solver::write_positions(std::span<const Eigen::Vector3f> positions, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the array of positions", positions.size(), state.particles.size());
  check_finite("position", positions);
  data_->finish_running_step();
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < positions.size(); ++v) {
    const Index place = places[v];
    Particle& p = state.particles[place];
    p = {positions[v].x(), positions[v].y(), positions[v].z(), p.w};
    state.velocities[place] = {};
  }
  std::ranges::fill(state.carries, Carry{});
  state.forget_past();
  state.is_state_current = true;  // whatever the backend has
  data_->changes.state[copy] = true;
}

std::vector<Eigen::Vector3f> Solver::velocities(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  std::vector<Eigen::Vector3f> out;
  out.reserve(state.velocities.size());
  for (const Index place : data_->place_of_vertex) {
    const Velocity& velocity = state.velocities[place];
    out.emplace_back(velocity.x, velocity.y, velocity.z);
  }
  return out;
}

void Solver::write_velocities(std::span<const Eigen::Vector3f> velocities, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the array of velocities", velocities.size(), state.velocities.size());
  check_finite("velocity", velocities);
  data_->fetch_state(copy);  // positions stay
  const std::vector<Index>& places = data_->place_of_vertex;
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    state.velocities[places[v]] = {velocities[v].x(), velocities[v].y(), velocities[v].z()};
  }
  state.forget_past();
  data_->changes.state[copy] = true;
}

Snapshot Solver::snapshot(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  Snapshot snapshot{positions(copy), velocities(copy), {}, tissue().identified_version()};
  for (const ToolState& tool : state.tools) {
    snapshot.tool_poses.push_back(tool.pose);
    snapshot.tool_displacements.push_back(vector_of(tool.spring.displacement));
  }
  for (std::size_t v = 0; v < state.carries.size(); ++v) {
    const Carry& carry = state.carries[data_->place_of_vertex[v]];
    snapshot.roundings.emplace_back(carry.x, carry.y, carry.z);
    snapshot.falling.push_back(carry.falling);
  }
  snapshot.past_substep = state.past_substep;
  for (std::size_t v = 0; v < state.ways.size(); ++v) {
    const Index place = data_->place_of_vertex[v];
    const Way& way = state.ways[place];
    const Velocity& before = state.velocities_before[place];
    snapshot.ways.emplace_back(way.x, way.y, way.z);
    snapshot.velocities_before.emplace_back(before.x, before.y, before.z);
  }
  snapshot.forces = forces(copy);
  snapshot.contacts = contacts_of(*data_, state);
  snapshot.body_contacts = touches_of(*data_, state);
  snapshot.joint_angles = angles_of(state.tools);
  return snapshot;
}

void Solver::restore(const Snapshot& snapshot, Index copy) {
  CopyState& state = checked_copy(*data_, copy);
  check_size("the snapshot's positions", snapshot.positions.size(), state.particles.size());
  check_size("the snapshot's velocities", snapshot.velocities.size(), state.particles.size());
  check_size("the snapshot's tool poses", snapshot.tool_poses.size(), state.tools.size());
  check_size_if_any("the snapshot's roundings", snapshot.roundings.size(), state.carries.size());
  check_size_if_any("the snapshot's shares of gravity", snapshot.falling.size(),
                    state.carries.size());
  check_size_if_any("the snapshot's ways", snapshot.ways.size(), state.ways.size());
  check_size("the snapshot's velocities before", snapshot.velocities_before.size(),
             snapshot.ways.size());
  check_size_if_any("the snapshot's forces", snapshot.forces.size(), state.particles.size());
  const TissueVersion now = tissue().identified_version();
  if (snapshot.tissue.tissue != now.tissue) {
    throw InvalidArgument("the snapshot is of another tissue");
  }
  if (snapshot.tissue.number != now.number) {
    throw InvalidArgument("the snapshot is of topology version " +
                          std::to_string(snapshot.tissue.number) + ", the solver is at " +
                          std::to_string(now.number));
  }
  check_finite("position", snapshot.positions);
  check_finite("velocity", snapshot.velocities);
  check_roundings(snapshot);
  check_finite("way", snapshot.ways);
  check_finite("velocity before", snapshot.velocities_before);
  check_finite("force", snapshot.forces);
  if (!(snapshot.past_substep >= 0) || !std::isfinite(snapshot.past_substep)) {
    throw InvalidArgument("the past substep of the snapshot is " +
                          std::to_string(snapshot.past_substep) + " s; it must be >= 0 and finite");
  }
  for (const ToolPose& pose : snapshot.tool_poses) {
    check_pose(pose);
  }
  check_contacts(snapshot.contacts, state.tools, state.particles.size());
  check_angles(snapshot.joint_angles, state.tools);
  check_size_if_any("the snapshot's tool displacements", snapshot.tool_displacements.size(),
                    state.tools.size());
  for (const Eigen::Vector3f& displacement : snapshot.tool_displacements) {
    check_displacement(displacement);
  }
  check_touches(snapshot.body_contacts, state.particles.size(), tissue().bodies().size());
  for (const float share : snapshot.falling) {
    if (!(share >= 0) || !(share <= 1)) {
      throw InvalidArgument("a share of gravity in the snapshot is " + std::to_string(share) +
                            "; it must be in [0, 1]");
    }
  }
  write_positions(snapshot.positions, copy);
  for (std::size_t v = 0; v < snapshot.roundings.size(); ++v) {
    const Eigen::Vector3f& rounding = snapshot.roundings[v];
    Carry& carry = state.carries[data_->place_of_vertex[v]];
    carry = {rounding.x(), rounding.y(), rounding.z(), carry.falling};
  }
  for (std::size_t v = 0; v < snapshot.falling.size(); ++v) {
    state.carries[data_->place_of_vertex[v]].falling = snapshot.falling[v];
  }
  write_velocities(snapshot.velocities, copy);
  for (std::size_t v = 0; v < snapshot.ways.size(); ++v) {
    const Index place = data_->place_of_vertex[v];
    const Eigen::Vector3f& way = snapshot.ways[v];
    const Eigen::Vector3f& before = snapshot.velocities_before[v];
    state.ways[place] = {way.x(), way.y(), way.z()};
    state.velocities_before[place] = {before.x(), before.y(), before.z()};
  }
  const bool has_past = is_explicit(data_->options) || !snapshot.ways.empty();
  state.past_substep = has_past ? snapshot.past_substep : 0;
  for (std::size_t t = 0; t < state.tools.size(); ++t) {
    ToolState& tool = state.tools[t];
    tool.target = snapshot.tool_poses[t];
    for (std::size_t j = 0; j < tool.joints.size(); ++j) {
      JointState& joint = tool.joints[j];
      joint.target = snapshot.joint_angles.empty() ? joint.angle : snapshot.joint_angles[t][j];
    }
    tool.arrive();
    tool.spring.displacement = {};
    if (tool.is_coupled() && !snapshot.tool_displacements.empty()) {
      tool.spring.displacement = load(snapshot.tool_displacements[t]);
    }
    tool.attachments.clear();
    tool.grip = {};
    data_->forget_releases(copy, static_cast<Index>(t));
    tool.contacts.clear();
    tool.surface_contacts.clear();
    tool.remembered.clear();
    tool.told.clear();
    tool.force.setZero();
    tool.torque.setZero();
  }
  set_contacts(snapshot.contacts, *data_, state);
  set_touches(snapshot.body_contacts, *data_, state);
  state.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
  clear_forces(copy);
  if (!snapshot.forces.empty()) {
    std::vector<Index> vertices(snapshot.forces.size());
    std::iota(vertices.begin(), vertices.end(), 0);
    set_forces(vertices, snapshot.forces, copy);
  }
}

std::uint64_t Solver::state_hash(Index copy) const {
  const CopyState& state = checked_copy(*data_, copy);
  data_->fetch_state(copy);
  std::uint64_t hash = state.particles.size();
  const auto mix = [&hash](float value) {
    hash = detail::mix_bits(hash, std::bit_cast<std::uint32_t>(value));
  };
  for (const Index place : data_->place_of_vertex) {
    const Particle& p = state.particles[place];
    const Velocity& velocity = state.velocities[place];
    for (const float value : {p.x, p.y, p.z, velocity.x, velocity.y, velocity.z}) {
      mix(value);
    }
    if (!state.carries.empty()) {
      const Carry& carry = state.carries[place];
      for (const float value : {carry.x, carry.y, carry.z, carry.falling}) {
        mix(value);
      }
    }
    if (!state.ways.empty()) {
      const Way& way = state.ways[place];
      const Velocity& before = state.velocities_before[place];
      for (const float value : {way.x, way.y, way.z, before.x, before.y, before.z}) {
        mix(value);
      }
    }
  }
  if (has_past_lengths(data_->options)) {
    mix(state.past_substep);
  }
  for (const Eigen::Vector3f& force : forces(copy)) {
    for (const float value : {force.x(), force.y(), force.z()}) {
      mix(value);
    }
  }
  return hash;
}

}  // namespace pbdsurg
