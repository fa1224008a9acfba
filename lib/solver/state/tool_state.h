// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the solver knows of a tool.

#include <Eigen/Core>
#include <algorithm>
#include <utility>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/solver/tool.h"

#include "lib/solver/state/grip_state.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/surface_contact.h"
#include "lib/solver/state/tool_spring.h"

namespace pbdsurg {

/// A vertex held by a tool.
struct Attachment {
  Index vertex;
  Eigen::Vector3f anchor;      ///< m, in the tool's frame
  float compliance;            ///< m/N
  Eigen::Vector3f target;      ///< m, of the current substep
  Eigen::Vector3f multiplier;  ///< kg m
  Index color;                 ///< how many tools before this one hold the same vertex
};

/// A vertex near a capsule, which stands as a plane for the rest of the substep.
struct Contact {
  Index place;
  Eigen::Vector3f normal;  ///< out of the tool
  float offset;            ///< m
  float multiplier;        ///< kg m
  Eigen::Vector3f point;   ///< m, in the scene, of the tool's surface
};

/// A joint, and where it is.
struct JointState {
  ToolJoint joint;
  float angle = 0;   ///< rad, at the end of the last step
  float target = 0;  ///< rad, at the end of the next step
};

struct ToolState {
  std::vector<Capsule> capsules{};
  std::vector<HalfSpace> half_spaces{};
  ToolPose pose;    ///< at the end of the last step
  ToolPose target;  ///< at the end of the next step
  std::vector<Attachment> attachments{};
  // the next four without the displacement of its spring
  ToolPose placed_before = ToolPose::Identity();  ///< at the start of the current substep
  ToolPose placed = ToolPose::Identity();         ///< at its end
  std::vector<Capsule> placed_capsules{};         ///< in the world, likewise
  std::vector<Capsule> capsules_before{};         ///< at its start, of tools that meet surfaces
  std::vector<Contact> contacts{};                ///< of the current substep, ascending by place
  ToolSurface surface{};
  std::vector<SurfaceContact> surface_contacts{};  ///< likewise, in the order of features
  std::vector<RememberedContact> remembered{};     ///< in the order of features
  std::vector<ToolContact> told{};                 ///< of a solver before this one: told_contacts.h
  Eigen::Vector3f force{0, 0, 0};                  ///< N, on the tool
  Eigen::Vector3f torque{0, 0, 0};                 ///< N m, around its origin
  ToolGrip grip{};                                 ///< what its jaws hold with a limit
  std::vector<JointState> joints{};                ///< from the shaft outwards
  bool is_removed = false;                         ///< then it has nothing of these, but its pose
  ToolCoupling coupling{};
  ToolSpring spring{};  ///< of a coupled tool

  /// A spring holds it from here on, or none does.
  void couple(const ToolCoupling& by) noexcept {
    coupling = by;
    if (!is_coupled()) {
      pose.translation() += vector_of(spring.displacement);  // from where it goes on
      spring = {};
    }
  }
  [[nodiscard]] bool is_coupled() const noexcept { return coupling.stiffness < kInfinity; }

  /// m, by how much its spring may take it back in a substep: see end_spring().
  [[nodiscard]] float stride() const noexcept {
    float least = kInfinity;
    for (const Capsule& capsule : capsules) {
      least = std::min(least, capsule.radius);
    }
    return least / 2;
  }

  /// Makes the end of this step the start of the next.
  void arrive() noexcept {
    pose = target;
    for (JointState& joint : joints) {
      joint.angle = joint.target;
    }
  }
  /// Stays where it is.
  void stay() noexcept {
    target = pose;
    for (JointState& joint : joints) {
      joint.target = joint.angle;
    }
  }

  /// Nothing is left of it but its place among the others.
  void remove() {
    ToolState gone{.pose = pose, .target = pose};
    gone.is_removed = true;
    *this = std::move(gone);
  }

  /// Whether it holds anything.
  [[nodiscard]] bool holds() const noexcept { return !attachments.empty() || grip.is_shut(); }

  /// Whether it meets surfaces, else vertices alone, without friction.
  [[nodiscard]] bool has_surface() const noexcept {
    return !half_spaces.empty() ||
           (!capsules.empty() && (meets_triangles() || surface.friction > 0));
  }
  /// Whether it meets edges and triangles.
  [[nodiscard]] bool meets_triangles() const noexcept {
    return !capsules.empty() && surface.features == ContactFeatures::all;
  }
};

}  // namespace pbdsurg
