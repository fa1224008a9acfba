// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/contact_stage.h"

#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/coupled_tool.h"
#include "lib/solver/methods/feature_search.h"
#include "lib/solver/methods/grip.h"
#include "lib/solver/methods/near_search.h"
#include "lib/solver/methods/touch_search.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

ToolPose interpolate(const ToolPose& from, const ToolPose& to, float fraction) {
  if (fraction >= 1) {
    return to;
  }
  if (!(fraction > 0)) {
    return from;
  }
  ToolPose pose = ToolPose::Identity();
  pose.translation() = from.translation() + fraction * (to.translation() - from.translation());
  pose.linear() = Eigen::Quaternionf(from.linear())
                      .slerp(fraction, Eigen::Quaternionf(to.linear()))
                      .toRotationMatrix();
  return pose;
}

// In the tool's frame, at a fraction of the step.
Eigen::Isometry3f turn_of(const JointState& state, float fraction) {
  const auto& [joint, from, to] = state;
  const float angle = fraction < 1 ? from + fraction * (to - from) : to;
  return Eigen::Translation3f(joint.point) * Eigen::AngleAxisf(angle, joint.axis) *
         Eigen::Translation3f(-joint.point);
}

void move(Capsule& capsule, const Eigen::Isometry3f& way) {
  capsule.start = way * capsule.start;
  capsule.end = way * capsule.end;
  capsule.across = way.linear() * capsule.across;
}

void find_contacts_of(const MovingVertices& vertices, Index count,
                      const std::vector<Capsule>& capsules, std::size_t capacity,
                      std::vector<Contact>& contacts, StepReport& report) {
  const ContactBox box = contact_box(capsules);
  for (Index place = 0; place < count; ++place) {
    const Vec3<float> x = vertices.position(place);
    if (!(vertices.moving[place].w > 0) || !box.contains(x)) {
      continue;
    }
    ContactSearch search;
    for (const Capsule& capsule : capsules) {
      search.add(placed(capsule), x);
    }
    if (!search.has_contact()) {
      continue;
    }
    if (contacts.size() < capacity) {
      const auto& [normal, offset] = search.plane;
      const Vec3<float> point = x + (offset - dot(normal, x)) * normal;
      contacts.push_back({place, vector_of(normal), offset, 0, vector_of(point)});
    } else {
      ++report.dropped_contacts.at_vertices;
    }
  }
}

}  // namespace

ContactBox contact_box(const std::vector<Capsule>& placed_capsules) {
  ContactBox box;
  for (const Capsule& capsule : placed_capsules) {
    box.add(placed(capsule));
  }
  return box;
}

void begin_tools(CopyState& copy) {
  for (ToolState& tool : copy.tools) {
    tool.force.setZero();
    tool.torque.setZero();
    begin_grip(tool.grip);
  }
}

// What a joint carries turns before it.
void place_capsules(const ToolState& tool, const ToolPose& pose, float fraction,
                    std::vector<Capsule>& placed) {
  placed.assign(tool.capsules.begin(), tool.capsules.end());
  for (auto state = tool.joints.rbegin(); state != tool.joints.rend(); ++state) {
    const Eigen::Isometry3f turn = turn_of(*state, fraction);
    for (Index c = 0; c < state->joint.capsule_count; ++c) {
      move(placed[state->joint.first_capsule + c], turn);
    }
  }
  for (Capsule& capsule : placed) {
    move(capsule, pose);
  }
}

void place_tools(CopyState& copy, float fraction, float before) {
  for (ToolState& tool : copy.tools) {
    if (tool.has_surface()) {
      tool.placed_before = interpolate(tool.pose, tool.target, before);
      place_capsules(tool, tool.placed_before, before, tool.capsules_before);
    }
    const ToolPose pose = interpolate(tool.pose, tool.target, fraction);
    for (Attachment& attachment : tool.attachments) {
      attachment.target = pose * attachment.anchor;
      attachment.multiplier.setZero();
    }
    place_grip(tool.grip, pose);
    tool.placed = pose;
    place_capsules(tool, pose, fraction, tool.placed_capsules);
  }
}

void find_contacts(const StepContext& step, const Substep<float>& lengths, StepReport& report) {
  const MovingVertices vertices = moving_vertices(step);
  report.contacts = 0;
  step.scratch.stopped.clear();
  refresh_near_lists(step);
  for (Index t = 0; t < static_cast<Index>(step.copy.tools.size()); ++t) {
    ToolState& tool = step.copy.tools[t];
    tool.contacts.clear();
    tool.surface_contacts.clear();
    begin_coupling(step, lengths, tool);
    if (!step.copy.pushes(t)) {
      continue;
    }
    if (tool.has_surface()) {
      find_surface_contacts(step, tool, near_features(step, t), lengths, report);
      report.contacts += static_cast<Index>(tool.surface_contacts.size());
      continue;
    }
    find_contacts_of(vertices, static_cast<Index>(step.copy.particles.size()), tool.placed_capsules,
                     static_cast<std::size_t>(step.data.options.contact_capacity), tool.contacts,
                     report);
    report.contacts += static_cast<Index>(tool.contacts.size());
  }
  find_touches(step, lengths, report);
}

// Reads no vertex: other threads move theirs already.
void collect_tool_forces(const StepContext& step, float force_per_multiplier) {
  // see substep_numbers()
  const float scale = force_per_multiplier * step.copy.factors.stiffness;
  for (const StoppedVertex& stopped : step.scratch.stopped) {
    feel(scale * vector_of(stopped.push), vector_of(stopped.point), step.copy.tools[stopped.tool]);
  }
  for (ToolState& tool : step.copy.tools) {
    for (const Contact& contact : tool.contacts) {
      feel((scale * contact.multiplier) * contact.normal, contact.point, tool);
    }
    for (const SurfaceContact& contact : tool.surface_contacts) {
      feel_contact(contact, contact.multiplier * contact.normal + contact.friction, scale, tool);
    }
    for (const Attachment& attachment : tool.attachments) {
      feel(scale * attachment.multiplier, attachment.target, tool);
    }
    collect_grip(tool, scale);
  }
}

void feel(const Eigen::Vector3f& force, const Eigen::Vector3f& point, ToolState& tool) {
  if (force.allFinite() && point.allFinite()) {
    tool.force -= force;
    const Eigen::Vector3f origin = tool.placed.translation() + vector_of(tool.spring.displacement);
    tool.torque -= (point - origin).cross(force);
  }
}

void feel_contact(const SurfaceContact& contact, const Vec3<float>& push, float scale,
                  ToolState& tool) {
  feel(scale * vector_of(push), vector_of(contact.point), tool);
}

void remember_contacts(const StepContext& step, const Substep<float>& lengths) {
  for (ToolState& tool : step.copy.tools) {
    remember_contacts(tool, lengths.inverse_dt_squared);
    end_coupling(step, tool);
  }
  remember_touches(step, lengths);
}

void end_tools(CopyState& copy) {
  for (ToolState& tool : copy.tools) {
    tool.arrive();
  }
}

}  // namespace pbdsurg
