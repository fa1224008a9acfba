// SPDX-License-Identifier: Apache-2.0
// Tools of a solver: where they are, what they hold, and what pulls at them.
#include <algorithm>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/solver.h"

#include "lib/solver/grip_checks.h"
#include "lib/solver/solver_checks.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"
#include "lib/solver/state/told_contacts.h"

namespace pbdsurg {
namespace {

JointState& checked_joint(ToolState& tool, Index joint) {
  if (joint < 0 || joint >= static_cast<Index>(tool.joints.size())) {
    throw InvalidArgument("there is no joint " + std::to_string(joint) + "; the tool has " +
                          std::to_string(tool.joints.size()));
  }
  return tool.joints[joint];
}

}  // namespace

ToolId Solver::add_tool(std::span<const Capsule> capsules, const ToolPose& pose,
                        const ToolSurface& surface, std::span<const ToolJoint> joints) {
  check_capsules(capsules);
  check_pose(pose);
  check_surface(surface);
  check_joints(joints, capsules.size());
  ToolState tool;
  for (const ToolJoint& joint : joints) {
    tool.joints.push_back({joint});
  }
  tool.surface = surface;
  tool.capsules.assign(capsules.begin(), capsules.end());
  tool.pose = tool.target = pose;
  return add(std::move(tool));
}

ToolId Solver::add_half_space(const HalfSpace& half_space, float friction, const ToolPose& pose) {
  check_half_space(half_space);
  check_pose(pose);
  ToolState tool;
  tool.surface.friction = friction;
  check_surface(tool.surface);
  tool.half_spaces.push_back(half_space);
  tool.pose = tool.target = pose;
  return add(std::move(tool));
}

ToolId Solver::add(ToolState tool) {
  if (tool.meets_triangles()) {
    data_->surface.begin(tissue());
  }
  data_->finish_running_step();
  std::vector<ToolState> added(static_cast<std::size_t>(data_->copy_count()), tool);
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->reserve_tool(added[copy]);
    data_->copy(copy).tools.reserve(data_->copy(copy).tools.size() + 1);
  }
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {  // nothing fails from here on
    data_->copy(copy).tools.push_back(std::move(added[copy]));
  }
  data_->changes.tools = true;
  data_->rebuild_plan();
  return ToolId(static_cast<Index>(data_->tools.size()) - 1);
}

void Solver::remove_tool(ToolId tool) {
  checked_tool(*data_, tool);
  data_->finish_running_step();
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    CopyState& owner = data_->copy(copy);
    owner.tools[tool].remove();
    data_->forget_releases(copy, tool);
    owner.color_attachments();
  }
  data_->changes.tools = true;
  data_->rebuild_plan();
}

bool Solver::has_tool(ToolId tool) const {
  return tool >= 0 && tool < static_cast<Index>(data_->tools.size()) &&
         !data_->tools[tool].is_removed;
}

void Solver::couple_tool(ToolId tool, const ToolCoupling& coupling) {
  checked_tool(*data_, tool);
  check_coupling(coupling);
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    check_takes_coupling(*data_, data_->copy(copy).tools[tool], tool);
  }
  data_->finish_running_step();
  for (Index copy = 0; copy < data_->copy_count(); ++copy) {
    data_->copy(copy).tools[tool].couple(coupling);
  }
  data_->changes.tools = true;
}

void Solver::move_tool(ToolId tool, const ToolPose& pose, Index copy) {
  ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  check_pose(pose);
  data_->finish_running_step();
  state.target = pose;
}

ToolPose Solver::tool_pose(ToolId tool, Index copy) const {
  const Eigen::Vector3f displacement = tool_displacement(tool, copy);
  return Eigen::Translation3f(displacement) * data_->copy(copy).tools[tool].pose;
}

Eigen::Vector3f Solver::tool_displacement(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  return vector_of(state.spring.displacement);
}

ToolPose Solver::tool_target(ToolId tool, Index copy) const {
  return checked_tool(checked_copy(*data_, copy), tool).target;
}

void Solver::set_joint(ToolId tool, Index joint, float angle, Index copy) {
  JointState& state = checked_joint(checked_tool(checked_copy(*data_, copy), tool), joint);
  check_angle(angle);
  data_->finish_running_step();
  state.target = angle;
}

float Solver::joint_angle(ToolId tool, Index joint, Index copy) const {
  const JointState& state = checked_joint(checked_tool(checked_copy(*data_, copy), tool), joint);
  data_->finish_running_step();
  return state.angle;
}

float Solver::joint_target(ToolId tool, Index joint, Index copy) const {
  return checked_joint(checked_tool(checked_copy(*data_, copy), tool), joint).target;
}

void Solver::grasp(ToolId tool, std::span<const Index> vertices, float compliance, Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  check_grasp_compliance(compliance);
  check_is_rigid(state, tool);
  if (state.grip.is_shut()) {
    check_holds_nothing(state, tool);
  }
  std::vector<bool> held(data_->particles.size(), false);
  for (const Attachment& attachment : state.attachments) {
    held[attachment.vertex] = true;
  }
  for (const Index v : vertices) {
    check_grasped(tissue(), tool, v, held);
  }
  std::vector<Eigen::Vector3f> positions(vertices.size());
  data_->read_positions(copy, vertices, positions);
  const ToolPose to_tool = state.pose.inverse();
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f& x = positions[i];
    state.attachments.push_back(
        {vertices[i], to_tool * x, compliance, x, Eigen::Vector3f::Zero(), 0});
  }
  owner.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
}

void Solver::release(ToolId tool, Index copy) {
  CopyState& owner = checked_copy(*data_, copy);
  ToolState& state = checked_tool(owner, tool);
  data_->finish_running_step();
  state.attachments.clear();
  state.grip = {};
  data_->forget_releases(copy, tool);
  owner.color_attachments();
  data_->changes.tools = true;
  data_->rebuild_plan();
}

Eigen::Vector3f Solver::tool_torque(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  return state.torque;
}

std::vector<ToolContact> Solver::tool_contacts(ToolId tool, Index copy) const {
  CopyState& owner = checked_copy(*data_, copy);
  const ToolState& state = checked_tool(owner, tool);
  data_->finish_running_step();
  return contacts_of_tool(*data_, owner, state);
}

Eigen::Vector3f Solver::tool_force(ToolId tool, Index copy) const {
  const ToolState& state = checked_tool(checked_copy(*data_, copy), tool);
  data_->finish_running_step();
  return state.force;
}

}  // namespace pbdsurg
