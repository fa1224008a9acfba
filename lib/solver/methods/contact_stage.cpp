// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/contact_stage.h"

#include "lib/solver/methods/contact_geometry.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/state/load_store.h"

namespace pbdsurg {
namespace {

ToolPose interpolate(const ToolPose& from, const ToolPose& to, float fraction) {
  if (fraction >= 1) {
    return to;
  }
  ToolPose pose = ToolPose::Identity();
  pose.translation() = from.translation() + fraction * (to.translation() - from.translation());
  pose.linear() = Eigen::Quaternionf(from.linear())
                      .slerp(fraction, Eigen::Quaternionf(to.linear()))
                      .toRotationMatrix();
  return pose;
}

PlacedCapsule placed(const Capsule& capsule) {
  return {load(capsule.start), capsule.radius, load(capsule.end)};
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
      contacts.push_back({place, {normal.x, normal.y, normal.z}, offset, 0});
    } else {
      ++report.dropped_contacts;
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
  }
}

void place_tools(CopyState& copy, float fraction) {
  for (ToolState& tool : copy.tools) {
    const ToolPose pose = interpolate(tool.pose, tool.target, fraction);
    for (Attachment& attachment : tool.attachments) {
      attachment.target = pose * attachment.anchor;
      attachment.multiplier.setZero();
    }
    tool.placed_capsules.clear();
    for (const Capsule& capsule : tool.capsules) {
      tool.placed_capsules.push_back({pose * capsule.start, pose * capsule.end, capsule.radius});
    }
  }
}

void find_contacts(const StepContext& step, StepReport& report) {
  const MovingVertices vertices = moving_vertices(step);
  report.contacts = 0;
  for (ToolState& tool : step.copy.tools) {
    tool.contacts.clear();
    if (tool.capsules.empty() || !tool.attachments.empty()) {
      continue;
    }
    find_contacts_of(vertices, static_cast<Index>(step.copy.particles.size()), tool.placed_capsules,
                     static_cast<std::size_t>(step.data.options.contact_capacity), tool.contacts,
                     report);
    report.contacts += static_cast<Index>(tool.contacts.size());
  }
}

void collect_tool_forces(CopyState& copy, float force_per_multiplier) {
  force_per_multiplier *= copy.factors.stiffness;  // see substep_numbers()
  const auto add = [](ToolState& tool, const Eigen::Vector3f& force) {
    if (force.allFinite()) {  // a vertex that is lost has none
      tool.force -= force;
    }
  };
  for (ToolState& tool : copy.tools) {
    for (const Contact& contact : tool.contacts) {
      add(tool, (force_per_multiplier * contact.multiplier) * contact.normal);
    }
    for (const Attachment& attachment : tool.attachments) {
      add(tool, force_per_multiplier * attachment.multiplier);
    }
  }
}

void end_tools(CopyState& copy) {
  for (ToolState& tool : copy.tools) {
    tool.pose = tool.target;
  }
}

}  // namespace pbdsurg
