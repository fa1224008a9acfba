// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/servo.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kOnSurface = 1e-6F;  // m: nearer, the direction to the surface is noise

// Ericson, "Real-Time Collision Detection", 2005, section 5.1.5
Vector3f closest_on_triangle(const Vector3f& p, const Vector3f& a, const Vector3f& b,
                             const Vector3f& c) {
  const Vector3f ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) {
    return a;
  }
  const float d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) {
    return b;
  }
  const float vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) {
    return a + d1 / (d1 - d3) * ab;
  }
  const float d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) {
    return c;
  }
  const float vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) {
    return a + d2 / (d2 - d6) * ac;
  }
  const float va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    return b + (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b);
  }
  return a + (vb * ab + vc * ac) / (va + vb + vc);
}

struct Nearest {
  float square = std::numeric_limits<float>::max();  // m^2
  Vector3f on{0, 0, 0};
  Vector3f outwards{0, 0, 0};  // of the triangle, of any length
  Index body = kInvalidIndex;
};

void find_nearest(const LiveSurface& surface, std::span<const Vector3f> positions,
                  const Vector3f& point, Nearest& nearest) {
  for (const Triangle& triangle : surface.triangles()) {
    if (triangle == LiveSurface::kEmptyTriangle) {
      continue;
    }
    const Vector3f &a = positions[triangle[0]], &b = positions[triangle[1]],
                   &c = positions[triangle[2]];
    const Vector3f on = closest_on_triangle(point, a, b, c);
    const float square = (point - on).squaredNorm();
    if (square < nearest.square) {
      nearest = {square, on, (b - a).cross(c - a), surface.body()};
    }
  }
}

float stiffness_of(const Solver& solver, Index body, float radius) {
  const Material& material = solver.tissue().body(body).material;
  return material.model == ElasticModel::neo_hookean
             ? tip_stiffness(radius, material.youngs_modulus, material.poissons_ratio)
             : kLeastStiffness;
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
  return 2 * radius * youngs_modulus / (1 - poissons_ratio * poissons_ratio);
}

ContactProbe::ContactProbe(const Solver& solver, std::span<const Index> bodies,
                           std::span<const ToolPoint> points)
    : points_(points.begin(), points.end()) {
  if (points.size() > ContactPacket::kLargestPlaneCount) {
    throw InvalidArgument("a contact probe has " + std::to_string(points.size()) +
                          " points; a packet has planes for " +
                          std::to_string(ContactPacket::kLargestPlaneCount));
  }
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].center.allFinite() || !(points[i].radius > 0) ||
        !std::isfinite(points[i].radius)) {
      throw InvalidArgument("point " + std::to_string(i) + " of a contact probe has a radius of " +
                            std::to_string(points[i].radius) +
                            " m; center and radius must be finite, the radius positive");
    }
  }
  for (const Index body : bodies) {
    surfaces_.push_back(shared_surface(solver.tissue(), body));
  }
}

ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                  GraspState grasp, std::uint64_t sequence, double time) {
  const ToolPose pose = solver.tool_pose(tool);
  probe.positions_.resize(static_cast<std::size_t>(solver.vertex_count()));
  solver.read_positions(probe.positions_);

  ContactPacket packet;
  packet.sequence = sequence;
  packet.time = time;
  set_pose(packet, pose);
  packet.force = packet_vector(solver.tool_force(tool));
  packet.grasp.state = grasp;
  float stiffness = kLeastStiffness, least_gap = std::numeric_limits<float>::max();
  for (const ToolPoint& point : probe.points_) {
    const Vector3f center = pose * point.center;
    Nearest nearest;
    for (const std::shared_ptr<const LiveSurface>& surface : probe.surfaces_) {
      find_nearest(*surface, probe.positions_, center, nearest);
    }
    if (nearest.body == kInvalidIndex) {
      continue;
    }
    const Vector3f away = center - nearest.on;
    const bool is_outside = away.dot(nearest.outwards) > 0;
    const float distance = is_outside ? away.norm() : -away.norm();
    const Vector3f normal = (distance > kOnSurface ? away : nearest.outwards).normalized();
    const float gap = distance - point.radius;
    if (gap > ContactProbe::kReach || !normal.allFinite() || !(normal.norm() > 0.5F)) {
      continue;
    }
    if (gap < least_gap) {
      least_gap = gap;
      stiffness = stiffness_of(solver, nearest.body, point.radius);
    }
    packet.planes[packet.plane_count++] = {.point = packet_vector(point.center),
                                           .normal = packet_vector(normal),
                                           .offset = normal.dot(nearest.on) + point.radius};
  }
  fit_to_force(packet, stiffness);
  packet.torque = packet_vector(torque_of(packet, pose));
  return packet;
}

}  // namespace pbdsurg
