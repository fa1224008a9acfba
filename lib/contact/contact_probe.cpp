// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/contact_probe.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/haptics/servo.h"

#include "lib/mesh/closest_on_triangle.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

constexpr float kOnSurface = 1e-6F;  // m: nearer, the direction to the surface is noise

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
    const Vector3f on = closest_on_triangle(a, b, c, point).point;
    const float square = (point - on).squaredNorm();
    if (square < nearest.square) {
      nearest = {square, on, (b - a).cross(c - a), surface.body()};
    }
  }
}

// rad, of a triangle around a point of it: all that there is within, half on an edge
double angle_at(const std::array<Eigen::Vector3d, 3>& corners, unsigned on_corners) {
  if (std::popcount(on_corners) > 1) {
    return std::popcount(on_corners) == 3 ? 2 * std::numbers::pi : std::numbers::pi;
  }
  const auto corner = static_cast<std::size_t>(std::countr_zero(on_corners));
  const Eigen::Vector3d first = corners[(corner + 1) % 3] - corners[corner];
  const Eigen::Vector3d second = corners[(corner + 2) % 3] - corners[corner];
  return std::atan2(first.cross(second).norm(), first.dot(second));
}

// Of all triangles at the nearest point, as at an acute edge one of two faces away: by the sum of
// their normals, weighted with angles (Baerentzen and Aanaes, "Signed distance computation using
// the angle weighted pseudonormal", IEEE Trans. Visualization and Computer Graphics 11(3), 2005).
bool is_outside(std::span<const std::shared_ptr<const LiveSurface>> surfaces,
                std::span<const Vector3f> positions, const Vector3f& point,
                const Nearest& nearest) {
  constexpr float kTie = 1 + 1e-4F;  // of squares
  Eigen::Vector3d outwards = Eigen::Vector3d::Zero();
  for (const std::shared_ptr<const LiveSurface>& surface : surfaces) {
    for (const Triangle& triangle : surface->triangles()) {
      const Vector3f &a = positions[triangle[0]], &b = positions[triangle[1]],
                     &c = positions[triangle[2]];
      if (triangle == LiveSurface::kEmptyTriangle ||
          !((point - closest_on_triangle(a, b, c, point).point).squaredNorm() <=
            kTie * nearest.square)) {
        continue;
      }
      const std::array<Eigen::Vector3d, 3> corners{a.cast<double>(), b.cast<double>(),
                                                   c.cast<double>()};
      const TrianglePoint on =
          closest_on_triangle<double>(corners[0], corners[1], corners[2], point.cast<double>());
      outwards += angle_at(corners, on.corners) *
                  (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalized();
    }
  }
  return (point - nearest.on).cast<double>().dot(outwards) > 0;
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
    const float distance =
        is_outside(probe.surfaces_, probe.positions_, center, nearest) ? away.norm() : -away.norm();
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
