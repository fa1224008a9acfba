// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/solver_checks.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/base/check.h"
#include "lib/base/describe.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg {

CopyState& checked_copy(SolverData& data, Index copy) {
  if (copy < 0 || copy >= data.copy_count()) {
    throw InvalidArgument("there is no copy " + std::to_string(copy) + "; the solver has " +
                          std::to_string(data.copy_count()));
  }
  return data.copy(copy);
}

ToolState& checked_tool(CopyState& copy, ToolId tool) {
  if (tool < 0 || tool >= static_cast<Index>(copy.tools.size())) {
    throw InvalidArgument("there is no tool " + std::to_string(tool.value) + "; the solver has " +
                          std::to_string(copy.tools.size()));
  }
  if (copy.tools[tool].is_removed) {
    throw InvalidArgument("tool " + std::to_string(tool.value) + " was removed");
  }
  return copy.tools[tool];
}

void check_pose(const ToolPose& pose) {
  constexpr float kRounding = 1e-3F;  // of a product of unit vectors
  const Eigen::Matrix3f rotation = pose.linear();
  if (!pose.matrix().allFinite() ||
      !(rotation.transpose() * rotation).isApprox(Eigen::Matrix3f::Identity(), kRounding) ||
      !(rotation.determinant() > 0)) {
    throw InvalidArgument("a tool's pose must be a finite translation and a rotation");
  }
}

namespace {

void check_plate(const Capsule& capsule, std::size_t index) {
  constexpr float kRounding = 1e-3F;
  const float width = capsule.across.norm();
  if (width == 0) {
    return;
  }
  const float length = (capsule.end - capsule.start).norm();
  const float slant = std::abs(capsule.across.dot(capsule.end - capsule.start));
  if (!std::isfinite(width) || !(length > 0) || !(slant <= kRounding * width * length)) {
    throw InvalidArgument("plate " + std::to_string(index) + " is " + describe(length) + " by " +
                          describe(width) +
                          " m; both must be positive and finite, at right angles to each other");
  }
}

}  // namespace

void check_capsules(std::span<const Capsule> capsules) {
  for (std::size_t c = 0; c < capsules.size(); ++c) {
    const Capsule& capsule = capsules[c];
    if (!capsule.start.allFinite() || !capsule.end.allFinite() || !(capsule.radius > 0) ||
        !std::isfinite(capsule.radius)) {
      throw InvalidArgument("capsule " + std::to_string(c) + " has radius " +
                            std::to_string(capsule.radius) +
                            " m; ends must be finite and the radius positive");
    }
    check_plate(capsule, c);
  }
}

void check_joints(std::span<const ToolJoint> joints, std::size_t capsule_count) {
  constexpr float kRounding = 1e-3F;
  const auto refuse = [](std::size_t joint, const std::string& why) {
    throw InvalidArgument("joint " + std::to_string(joint) + " " + why);
  };
  const auto end_of = [](const ToolJoint& joint) {
    return std::int64_t{joint.first_capsule} + joint.capsule_count;
  };
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const ToolJoint& joint = joints[j];
    if (!joint.point.allFinite() || !(std::abs(joint.axis.norm() - 1) < kRounding)) {
      refuse(j, "has an axis of length " + describe(joint.axis.norm()) +
                    "; it must be a unit, and the point finite");
    }
    if (joint.first_capsule < 0 || joint.capsule_count <= 0 ||
        end_of(joint) > static_cast<std::int64_t>(capsule_count)) {
      refuse(j, "turns " + std::to_string(joint.capsule_count) + " capsules from " +
                    std::to_string(joint.first_capsule) + " on; it must turn some of the tool's " +
                    std::to_string(capsule_count));
    }
    for (std::size_t carrier = 0; carrier < j; ++carrier) {
      const ToolJoint& other = joints[carrier];
      const bool is_apart =
          end_of(joint) <= other.first_capsule || end_of(other) <= joint.first_capsule;
      const bool is_within =
          joint.first_capsule >= other.first_capsule && end_of(joint) <= end_of(other);
      if (!is_apart && !is_within) {
        refuse(j, "turns some capsules of joint " + std::to_string(carrier) +
                      " and others; it must turn none of them, or those alone");
      }
    }
  }
}

void check_coupling(const ToolCoupling& coupling) {
  if (!(coupling.stiffness > 0)) {
    throw InvalidArgument("the stiffness of a tool's coupling is " + describe(coupling.stiffness) +
                          " N/m; it must be positive");
  }
}

void check_takes_coupling(const SolverData& data, const ToolState& tool, ToolId id) {
  const std::string own = "tool " + std::to_string(id.value);
  if (is_explicit(data.options)) {
    throw InvalidArgument("in explicit steps no spring holds tools: " + own + " is to be rigid");
  }
  if (!tool.has_surface()) {
    throw InvalidArgument(own + " has no surface, so a spring cannot hold it: see ToolSurface");
  }
  if (tool.holds()) {
    throw InvalidArgument(own + " holds something, so a spring cannot hold it");
  }
}

void check_is_rigid(const ToolState& tool, ToolId id) {
  if (tool.is_coupled()) {
    throw InvalidArgument("tool " + std::to_string(id.value) +
                          " is coupled by a spring, so it cannot hold anything");
  }
}

void check_angle(float angle) {
  if (!std::isfinite(angle)) {
    throw InvalidArgument("the angle of a joint is " + describe(angle) + " rad; it must be finite");
  }
}

void check_half_space(const HalfSpace& half_space) {
  constexpr float kRounding = 1e-3F;
  if (!half_space.point.allFinite() || !(std::abs(half_space.normal.norm() - 1) < kRounding)) {
    throw InvalidArgument("the half space has a normal of length " +
                          std::to_string(half_space.normal.norm()) +
                          "; it must be a unit, and the point finite");
  }
}

void check_surface(const ToolSurface& surface) {
  if (surface.features > ContactFeatures::all) {
    throw InvalidArgument("features are " + std::to_string(static_cast<int>(surface.features)) +
                          "; they must be vertices or all");
  }
  if (!(surface.friction >= 0) || !std::isfinite(surface.friction)) {
    throw InvalidArgument("friction is " + std::to_string(surface.friction) +
                          "; it must be >= 0 and finite");
  }
}

void check_contact_pair(const ContactPair& pair, const SolverData& data) {
  for (const Index body : {pair.first, pair.second}) {
    check_id("body", body, data.tissue->bodies().size());
  }
  const auto& [thickness, friction] = pair.contact;
  if (!(thickness > 0) || !std::isfinite(thickness)) {
    throw InvalidArgument("the thickness of contact between bodies " + std::to_string(pair.first) +
                          " and " + std::to_string(pair.second) + " is " + describe(thickness) +
                          " m; it must be positive and finite");
  }
  check_surface({ContactFeatures::all, friction});
}

void check_grasp_compliance(float compliance) {
  if (!(compliance >= 0) || !(compliance <= kLargestCompliance)) {
    throw InvalidArgument("grasp compliance is " + std::to_string(compliance) +
                          " m/N; it must be in [0, 1e12]");
  }
}

void check_gravity(const Eigen::Vector3f& gravity) {
  if (!gravity.allFinite()) {
    throw InvalidArgument("gravity is " + describe(Eigen::Vector3d(gravity.cast<double>())) +
                          " m/s^2; it must be finite");
  }
}

void check_forces(std::span<const Index> vertices, std::span<const Eigen::Vector3f> forces,
                  std::size_t vertex_count) {
  if (vertices.size() != forces.size()) {
    throw InvalidArgument("there are " + std::to_string(forces.size()) + " forces for " +
                          std::to_string(vertices.size()) + " vertices; one each");
  }
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    check_id("vertex", vertices[i], vertex_count);
    if (!forces[i].allFinite()) {
      throw InvalidArgument("the force at vertex " + std::to_string(vertices[i]) + " is " +
                            describe(Eigen::Vector3d(forces[i].cast<double>())) +
                            " N; it must be finite");
    }
  }
  std::vector<Index> sorted(vertices.begin(), vertices.end());
  std::ranges::sort(sorted);
  if (const auto twice = std::ranges::adjacent_find(sorted); twice != sorted.end()) {
    throw InvalidArgument("vertex " + std::to_string(*twice) +
                          " is named twice; a vertex has one force");
  }
}

void check_grasped(const Tissue& tissue, ToolId tool, Index vertex, std::vector<bool>& is_held) {
  if (!tissue.has_tissue(vertex)) {
    throw InvalidArgument("vertex " + std::to_string(vertex) + " has no tissue left to hold");
  }
  if (is_held[vertex]) {
    throw InvalidArgument("tool " + std::to_string(tool.value) + " holds vertex " +
                          std::to_string(vertex) + " already");
  }
  is_held[vertex] = true;
}

}  // namespace pbdsurg
