// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/solver_copy.h"

#include <algorithm>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"
#include "lib/solver/grip_checks.h"
#include "lib/solver/methods/vertex_method.h"
#include "lib/solver/sets/constraint_groups.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/solver_input.h"
#include "lib/solver/state/told_contacts.h"

namespace pbdsurg {
namespace {

template <class Value>
std::size_t bytes_of(const std::vector<Value>& values) noexcept {
  return values.size() * sizeof(Value);
}

void check_count(const char* what, std::size_t count, std::size_t expected) {
  if (count != expected) {
    throw InvalidArgument("the motion has " + std::to_string(count) + " " + what + "; it needs " +
                          std::to_string(expected));
  }
}

void check_tool(const SolverData& data, ToolId id, const ToolState& tool) {
  const Tissue& tissue = *data.tissue;
  check_capsules(tool.capsules);
  std::ranges::for_each(tool.half_spaces, check_half_space);
  check_surface(tool.surface);
  check_pose(tool.pose);
  check_pose(tool.target);
  std::vector<ToolJoint> joints;
  for (const JointState& state : tool.joints) {
    joints.push_back(state.joint);
    check_angle(state.angle);
    check_angle(state.target);
  }
  check_joints(joints, tool.capsules.size());
  check_coupling(tool.coupling);
  if (tool.is_coupled()) {
    check_takes_coupling(data, tool, id);
  }
  if (!vector_of(tool.spring.displacement).allFinite()) {
    throw InvalidArgument("the displacement of tool " + std::to_string(id.value) +
                          " is not finite");
  }
  std::vector<bool> is_held(static_cast<std::size_t>(tissue.vertex_count()), false);
  for (const Attachment& held : tool.attachments) {
    check_grasped(tissue, id, held.vertex, is_held);
    check_grasp_compliance(held.compliance);
    if (!held.anchor.allFinite()) {
      throw InvalidArgument("vertex " + std::to_string(held.vertex) +
                            " is held at a place that is not finite");
    }
  }
}

// Calls with its id are refused, so nothing could ever take this away.
void check_removed(ToolId id, const ToolState& tool, bool is_removed) {
  if (tool.is_removed != is_removed) {
    throw InvalidArgument("tool " + std::to_string(id.value) +
                          " was removed in some copies; it must be there in all or in none");
  }
  if (tool.is_removed && (!tool.capsules.empty() || !tool.half_spaces.empty() || tool.holds())) {
    throw InvalidArgument("tool " + std::to_string(id.value) +
                          " was removed; it must have no capsules and hold nothing");
  }
}

void check_remembered(const SolverData& data, const ToolState& tool) {
  for (const RememberedContact& contact : tool.remembered) {
    for (int k = 0; k < contact.feature.count(); ++k) {
      check_id("place", contact.feature.places[k], data.particles.size());
    }
  }
  if (!std::ranges::is_sorted(tool.remembered, {}, &RememberedContact::feature)) {
    throw InvalidArgument("contacts of a tool are not in the order of their features");
  }
}

// What Solver::restore() does not check.
void check_motion(const Solver& solver, const SolverMotion& motion) {
  const SolverData& data = solver_data(solver);
  const auto vertex_count = static_cast<std::size_t>(solver.vertex_count());
  check_count("copies", motion.copies.size(), static_cast<std::size_t>(data.copy_count()));
  for (const Index place : motion.watched_places) {
    check_id("place", place, data.particles.size());
  }
  check_gravity(motion.gravity);
  if (!motion.body_gravities.empty()) {
    check_count("gravities of bodies", motion.body_gravities.size(),
                solver.tissue().bodies().size());
    std::ranges::for_each(motion.body_gravities, check_gravity);
  }
  for (const ContactPair& pair : motion.contact_pairs) {
    check_contact_pair(pair, data);
  }
  check_range("steps_since_convergence", motion.steps_since_convergence, 0,
              std::max(0, data.options.convergence_interval - 1));
  for (const SolverMotion::OfCopy& own : motion.copies) {
    const StepReport& report = own.report;
    check_id("vertex that is not finite", std::max(0, report.first_non_finite),
             data.particles.size());
    check_id("replica that is not finite", std::max(0, report.first_non_finite_copy),
             motion.copies.size());
    check_count("tools", own.tools.size(), motion.copies.front().tools.size());
    check_told(own.body_contacts, vertex_count, solver.tissue().bodies().size());
    check_count("watched positions", own.watched_positions.size(), motion.watched_places.size());
    for (std::size_t i = 0; i < own.tools.size(); ++i) {
      const ToolId id(static_cast<Index>(i));
      check_tool(data, id, own.tools[i]);
      check_removed(id, own.tools[i], motion.copies.front().tools[i].is_removed);
      check_remembered(data, own.tools[i]);
      check_told(own.tools[i].told, vertex_count);
      check_grip_state(data, own.tools[i].grip, own.tools.size());
    }
  }
}

// Of one that tools have not touched.
CopyState without_tools(CopyState state) {
  state.tools.clear();
  state.touches = {};
  state.attachment_colors = 0;
  state.watched_positions.clear();
  state.last_report = {};
  state.factors = {};
  return state;
}

}  // namespace

SolverCopy::SolverCopy(const Solver& solver) {
  static_cast<void>(solver.positions());  // brings the state of a device
  const SolverData& data = solver_data(solver);
  make_backend_ = data.backend->maker();
  options_ = data.options;
  substep_rule_ = data.substep_rule;
  gravity_ = data.gravity;
  body_gravities_ = data.body_gravities;
  gravities_ = data.gravities;
  place_of_vertex_ = data.place_of_vertex;
  state_ = without_tools(data.copy(0));
  constraints_ = data.sets;
  close_waiting_groups(constraints_);  // spare room opens them again
  vertex_blocks_ = data.vertex_blocks;
  coarse_space_ = data.coarse_space;
  stable_substep_ = data.stable_substep;
  plan_ = data.plan;
}

Solver SolverCopy::make(Tissue& tissue) const {
  auto made = std::make_unique<SolverData>();
  SolverData& data = *made;
  static_cast<CopyState&>(data) = state_;
  data.tissue = &tissue;
  data.options = options_;
  data.substep_rule = substep_rule_;
  data.gravity = gravity_;
  data.body_gravities = body_gravities_;
  data.gravities = gravities_;
  data.place_of_vertex = place_of_vertex_;
  static_cast<ConstraintData&>(data.sets) = constraints_;
  data.vertex_blocks = vertex_blocks_;
  if (moves_vertices(data.options)) {
    data.vertex_blocks.reserve(data.options.spare);
  }
  data.coarse_space = coarse_space_;
  if (has_coarse_correction(data.options)) {
    data.coarse_space.reserve(static_cast<std::size_t>(data.options.spare.vertices));
  }
  data.stable_substep = stable_substep_;
  data.plan = plan_;
  data.others.assign(static_cast<std::size_t>(data.options.copies) - 1, data);
  data.reserve_spare_room();
  data.changes.state.assign(static_cast<std::size_t>(data.options.copies), true);
  data.rebuild_plan();
  data.set_backend(make_backend_(data));
  return Solver(tissue, std::move(made));
}

std::size_t SolverCopy::memory_bytes() const noexcept {
  std::size_t bytes =
      bytes_of(place_of_vertex_) + bytes_of(state_.particles) + bytes_of(state_.velocities) +
      bytes_of(state_.carries) + bytes_of(state_.ways) + bytes_of(state_.velocities_before) +
      bytes_of(state_.forces) + bytes_of(body_gravities_) + bytes_of(gravities_) +
      constraints_.distance_ids.memory_bytes() + constraints_.edge_owners.memory_bytes() +
      vertex_blocks_.memory_bytes() + coarse_space_.memory_bytes() + stable_substep_.memory_bytes();
  constraints_.for_each_set([&](const auto& set) { bytes += set.memory_bytes(); });
  return bytes;
}

SolverMotion motion_of(const Solver& solver) {
  SolverMotion motion;
  const SolverData& data = solver_data(solver);
  for (Index i = 0; i < data.copy_count(); ++i) {
    motion.copies.push_back(
        {solver.snapshot(i), {}, {}, {}, {}, {}});  // waits for a step that runs
    SolverMotion::OfCopy& own = motion.copies.back();
    const CopyState& state = data.copy(i);
    own.tools = state.tools;
    own.body_contacts = contacts_of_bodies(data, state);
    for (ToolState& tool : own.tools) {
      tool.told = contacts_of_tool(data, state, tool);
      tool.contacts = {};  // of a substep
      tool.surface_contacts = {};
      tool.capsules_before = {};
      tool.placed_capsules = {};
    }
    own.watched_positions = state.watched_positions;
    own.report = state.last_report;
    own.factors = state.factors;
  }
  motion.watched_places = data.watched_places;
  motion.steps_since_convergence = data.steps_since_convergence;
  motion.gravity = data.gravity;
  motion.body_gravities = data.body_gravities;
  motion.contact_pairs.assign(data.contact_bodies.pairs().begin(),
                              data.contact_bodies.pairs().end());
  return motion;
}

void set_motion(Solver& solver, const SolverMotion& motion) {
  SolverData& data = solver_data(solver);
  check_motion(solver, motion);
  data.watched_places = motion.watched_places;
  data.steps_since_convergence = motion.steps_since_convergence;
  data.gravity = motion.gravity;
  data.set_body_gravities(solver.tissue(), motion.body_gravities);
  for (Index i = 0; i < data.copy_count(); ++i) {
    data.copy(i).tools = motion.copies[i].tools;  // a plan asks for those of all copies
  }
  for (Index i = 0; i < data.copy_count(); ++i) {
    const SolverMotion::OfCopy& own = motion.copies[i];
    CopyState& state = data.copy(i);
    Snapshot snapshot = own.snapshot;
    snapshot.tissue = solver.tissue().identified_version();
    solver.restore(snapshot, i);
    state.tools = own.tools;  // with what they hold
    state.touches.told = own.body_contacts;
    state.color_attachments();
    state.watched_positions = own.watched_positions;
    state.last_report = own.report;
    solver.set_factors(own.factors, i);
  }
  data.contact_bodies.replace(motion.contact_pairs);
  if (std::ranges::any_of(data.tools, &ToolState::has_surface) || !data.contact_bodies.empty()) {
    data.surface.begin(solver.tissue());
  }
  if (!data.contact_bodies.empty()) {
    data.reserve_touches();
  }
  data.reserve_tools();
  data.changes.tools = data.changes.watched = true;
  data.rebuild_plan();
}

std::size_t memory_bytes(const SolverMotion& motion) noexcept {
  std::size_t bytes = bytes_of(motion.watched_places) + bytes_of(motion.body_gravities) +
                      bytes_of(motion.contact_pairs);
  for (const SolverMotion::OfCopy& copy : motion.copies) {
    const Snapshot& snapshot = copy.snapshot;
    bytes += bytes_of(snapshot.positions) + bytes_of(snapshot.velocities) +
             bytes_of(snapshot.falling) + bytes_of(snapshot.roundings) + bytes_of(snapshot.ways) +
             bytes_of(snapshot.velocities_before) + bytes_of(snapshot.forces) +
             bytes_of(copy.watched_positions) + bytes_of(copy.body_contacts);
    for (const ToolState& tool : copy.tools) {
      bytes += sizeof(tool) + bytes_of(tool.capsules) + bytes_of(tool.attachments) +
               bytes_of(tool.joints) + bytes_of(tool.told) + tool.grip.memory_bytes();
    }
  }
  return bytes;
}

}  // namespace pbdsurg
