// SPDX-License-Identifier: Apache-2.0
#include "solver/contact_stage.h"

#include <algorithm>
#include <limits>

#include "core/segment.h"

namespace pbdsurg {
namespace {

// Vertices this share of a radius away get a contact too, so that the sweeps cannot push them in.
constexpr float kMargin = 0.25F;

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

struct Box {
  Eigen::Vector3f low = Eigen::Vector3f::Constant(std::numeric_limits<float>::max());
  Eigen::Vector3f high = Eigen::Vector3f::Constant(std::numeric_limits<float>::lowest());

  [[nodiscard]] bool contains(const Particle& p) const {
    return p.x >= low.x() && p.x <= high.x() && p.y >= low.y() && p.y <= high.y() &&
           p.z >= low.z() && p.z <= high.z();
  }
};

Box bounds(const std::vector<Capsule>& capsules) {
  Box box;
  for (const Capsule& capsule : capsules) {
    const Eigen::Vector3f reach = Eigen::Vector3f::Constant((1 + kMargin) * capsule.radius);
    box.low = box.low.cwiseMin(capsule.start.cwiseMin(capsule.end) - reach);
    box.high = box.high.cwiseMax(capsule.start.cwiseMax(capsule.end) + reach);
  }
  return box;
}

void find_contacts_of(const std::vector<Particle>& particles, const std::vector<Capsule>& capsules,
                      std::size_t capacity, std::vector<Contact>& contacts, StepReport& report) {
  const Box box = bounds(capsules);
  for (std::size_t place = 0; place < particles.size(); ++place) {
    const Particle& p = particles[place];
    if (!(p.w > 0) || !box.contains(p)) {
      continue;
    }
    const Eigen::Vector3f x(p.x, p.y, p.z);
    float deepest = std::numeric_limits<float>::max();
    Contact contact{static_cast<Index>(place), Eigen::Vector3f::Zero(), 0, 0};
    for (const Capsule& capsule : capsules) {
      const Eigen::Vector3f axis_point = closest_on_segment(capsule.start, capsule.end, x);
      const Eigen::Vector3f away = x - axis_point;
      const float distance = away.norm();
      // a vertex on the axis has no side to be pushed to
      if (distance > 0 && distance < (1 + kMargin) * capsule.radius &&
          distance - capsule.radius < deepest) {
        deepest = distance - capsule.radius;
        contact.normal = away / distance;
        contact.offset = contact.normal.dot(axis_point) + capsule.radius;
      }
    }
    if (deepest == std::numeric_limits<float>::max()) {
      continue;
    }
    if (contacts.size() < capacity) {
      contacts.push_back(contact);
    } else {
      ++report.dropped_contacts;
    }
  }
}

}  // namespace

void begin_tools(SolverData& data) {
  for (ToolState& tool : data.tools) {
    tool.force.setZero();
  }
}

void place_tools(SolverData& data, float fraction) {
  for (ToolState& tool : data.tools) {
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

void find_contacts(SolverData& data, StepReport& report) {
  report.contacts = 0;
  for (ToolState& tool : data.tools) {
    tool.contacts.clear();
    if (tool.capsules.empty() || !tool.attachments.empty()) {
      continue;
    }
    find_contacts_of(data.particles, tool.placed_capsules,
                     static_cast<std::size_t>(data.options.contact_capacity), tool.contacts,
                     report);
    report.contacts += static_cast<Index>(tool.contacts.size());
  }
}

void collect_tool_forces(SolverData& data, float force_per_multiplier) {
  const auto add = [](ToolState& tool, const Eigen::Vector3f& force) {
    if (force.allFinite()) {  // a vertex that is lost has none
      tool.force -= force;
    }
  };
  for (ToolState& tool : data.tools) {
    for (const Contact& contact : tool.contacts) {
      add(tool, (force_per_multiplier * contact.multiplier) * contact.normal);
    }
    for (const Attachment& attachment : tool.attachments) {
      add(tool, force_per_multiplier * attachment.multiplier);
    }
  }
}

void end_tools(SolverData& data) {
  for (ToolState& tool : data.tools) {
    tool.pose = tool.target;
  }
}

}  // namespace pbdsurg
