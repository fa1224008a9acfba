// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_patch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pbdsurg/haptics/servo.h"

#include "lib/contact/nearest_triangle.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kOnSurface = 1e-6F;   // m: nearer, the direction to the surface is noise
constexpr float kLeastGrasp = 1e-3F;  // N, at which a spring saturates that holds next to nothing

// N/m, see tip_stiffness()
float punch_stiffness(float radius, float youngs_modulus, float poissons_ratio) {
  return 2 * radius * youngs_modulus / (1 - poissons_ratio * poissons_ratio);
}

// Of a sheet the membrane: held all around, it bears 1.1 E h d^3 / R^2 or so at its middle, which
// is no stiffer than E h to a depth d of half its radius R.
float stiffness_of(const PatchTriangle& triangle, float radius) {
  if (!(triangle.youngs_modulus > 0)) {
    return kLeastStiffness;
  }
  const float punch = punch_stiffness(radius, triangle.youngs_modulus, triangle.poissons_ratio);
  return triangle.thickness > 0 ? std::min(punch, triangle.youngs_modulus * triangle.thickness)
                                : punch;
}

bool is_in_margin(const ContactPatch& patch, const ToolPose& where) {
  return std::ranges::all_of(patch.points, [&](const PatchPoint& point) {
    const Vector3f moved = where * point.ball.center - patch.pose * point.ball.center;
    return moved.norm() <= ContactPatch::kMargin;
  });
}

// N m, of planes about the tip
Vector3f torque_of(const ContactPacket& packet, const ToolPose& pose) {
  Vector3f torque = Vector3f::Zero();
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    const ContactPlane& plane = packet.planes[i];
    const Vector3f arm = pose.linear() * vector_of(plane.point), normal = vector_of(plane.normal);
    const float depth = plane.offset - normal.dot(pose.translation() + arm);
    torque += plane.stiffness * std::max(0.0F, depth) * arm.cross(normal);
  }
  return torque;
}

}  // namespace

float tip_stiffness(float radius, float youngs_modulus, float poissons_ratio) {
  const auto is_positive = [](float x) { return x > 0 && std::isfinite(x); };
  if (!is_positive(radius) || !is_positive(youngs_modulus) ||
      !(poissons_ratio >= 0 && poissons_ratio < 0.5F)) {
    throw InvalidArgument("a tip of radius " + std::to_string(radius) + " m is on tissue of " +
                          std::to_string(youngs_modulus) + " Pa and a Poisson's ratio of " +
                          std::to_string(poissons_ratio) +
                          "; the first two must be positive and finite, the last in [0, 0.5)");
  }
  return punch_stiffness(radius, youngs_modulus, poissons_ratio);
}

ContactPacket make_contact_packet(const ContactPatch& patch, const ToolPose& where) {
  if (patch.points.size() > ContactPacket::kLargestPlaneCount) {
    throw InvalidArgument("a contact patch has " + std::to_string(patch.points.size()) +
                          " points; a packet has planes for " +
                          std::to_string(ContactPacket::kLargestPlaneCount));
  }
  const ToolPose& pose = is_in_margin(patch, where) ? where : patch.pose;
  ContactPacket packet;
  packet.sequence = patch.sequence;
  packet.time = patch.time;
  set_pose(packet, patch.pose);
  packet.force = packet_vector(patch.force);
  packet.grasp.state = patch.grasp;
  const float largest = std::max({patch.slip_limit, patch.force.norm(), kLeastGrasp});
  packet.grasp.largest_force = std::min(packet.grasp.largest_force, largest);
  float stiffness = kLeastStiffness, least_gap = std::numeric_limits<float>::max();
  for (const auto& [point, reach] : patch.points) {
    const NearestTriangle nearest = find_nearest_triangle(patch.triangles, pose * point.center);
    if (nearest.triangle == nullptr || !(std::abs(nearest.distance) <= reach)) {
      continue;
    }
    const auto& [a, b, c] = nearest.triangle->corners;
    const Vector3f normal =
        (nearest.distance > kOnSurface ? nearest.away : (b - a).cross(c - a)).normalized();
    const float gap = nearest.distance - point.radius;
    if (gap > ContactPatch::kReach || !normal.allFinite() || !(normal.norm() > 0.5F)) {
      continue;
    }
    if (gap < least_gap) {
      least_gap = gap;
      stiffness = stiffness_of(*nearest.triangle, point.radius);
    }
    packet.planes[packet.plane_count++] = {.point = packet_vector(point.center),
                                           .normal = packet_vector(normal),
                                           .offset = normal.dot(nearest.on) + point.radius};
  }
  fit_to_force(packet, stiffness);
  packet.torque = packet_vector(torque_of(packet, patch.pose));
  return packet;
}

}  // namespace pbdsurg
