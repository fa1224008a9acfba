// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What calls of a solver name, once it is known to be there.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/base/ids.h"
#include "pbdsurg/solver/tool.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/state/solver_data.h"

namespace pbdsurg {

/// @throws InvalidArgument  naming the copy that there is not, and how many there are
CopyState& checked_copy(SolverData& data, Index copy);

/// @throws InvalidArgument  naming the tool that there is not, and how many there are, or that was
///                          removed
ToolState& checked_tool(CopyState& copy, ToolId tool);

/// @throws InvalidArgument  unless it is a finite translation and a rotation
void check_pose(const ToolPose& pose);

/// @throws InvalidArgument  naming the capsule that is not finite or whose radius is not positive
void check_capsules(std::span<const Capsule> capsules);

/// @throws InvalidArgument  naming the joint whose axis is no unit or whose capsules there are not,
///                          or are in part those of another
void check_joints(std::span<const ToolJoint> joints, std::size_t capsule_count);

/// @throws InvalidArgument  naming a stiffness that is not positive
void check_coupling(const ToolCoupling& coupling);

/// Of a tool that a spring is to hold, or does.
/// @throws InvalidArgument     if it meets no surfaces or holds something, or in explicit steps
/// @throws BackendUnavailable  if the solver is on a device
void check_takes_coupling(const SolverData& data, const ToolState& tool, ToolId id);

/// Of a tool that is to hold something.
/// @throws InvalidArgument  if a spring holds it
void check_is_rigid(const ToolState& tool, ToolId id);

/// @param angle  rad
/// @throws InvalidArgument  naming an angle that is not finite
void check_angle(float angle);

/// @throws InvalidArgument  unless it has a finite point and a unit normal
void check_half_space(const HalfSpace& half_space);

/// @throws InvalidArgument  unless friction is finite and not negative
void check_surface(const ToolSurface& surface);

/// @throws InvalidArgument     naming the body that there is not, or the thickness or friction out
/// of
///                             range, or if the solver takes explicit steps or BDF2
/// @throws BackendUnavailable  if it is on a device
void check_contact_pair(const ContactPair& pair, const SolverData& data);

/// @throws InvalidArgument  unless it is in [0, kLargestCompliance]
void check_grasp_compliance(float compliance);

/// @param gravity  m/s^2
/// @throws InvalidArgument  naming a gravity that is not finite
void check_gravity(const Eigen::Vector3f& gravity);

/// @param forces  N
/// @throws InvalidArgument  naming the vertex that is out of range or named twice, or the force
/// that
///                          is not finite, or if there is not one for each
void check_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces,
                  std::size_t vertex_count);

/// @param is_held  [vertex_count] by that tool; takes the vertex
/// @throws InvalidArgument  naming the vertex out of range, without tissue, or held already
void check_grasped(const Tissue& tissue, ToolId tool, Index vertex, std::vector<bool>& is_held);

}  // namespace pbdsurg
