// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/contact_packet.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace pbdsurg {
namespace {

constexpr float kUnit = 1e-3F;        // how far from 1 a unit length may be
constexpr float kTouching = 1e-3F;    // m: a plane this near may bear force, as meshes are coarse
constexpr float kFarther = 2e-3F;     // m beyond the nearest plane: a plane has the least share
constexpr float kLeastShare = 0.05F;  // of the nearest plane's
constexpr float kLeastForce = 1e-4F;  // N: what planes may fail to bear
constexpr int kSweeps = 20;

template <std::size_t n>
bool is_finite(const std::array<float, n>& numbers) {
  return std::all_of(numbers.begin(), numbers.end(), [](float x) { return std::isfinite(x); });
}

bool is_positive(float x) {
  return x > 0 && std::isfinite(x);
}

bool is_not_negative(float x) {
  return x >= 0 && std::isfinite(x);
}

bool is_valid(const ContactPlane& plane) {
  return is_finite(plane.point) && is_finite(plane.normal) && std::isfinite(plane.offset) &&
         is_not_negative(plane.stiffness) && std::abs(vector_of(plane.normal).norm() - 1) < kUnit;
}

bool is_valid(const ContactGrasp& grasp) {
  return grasp.state != GraspState::held ||
         (is_finite(grasp.point) && is_finite(grasp.anchor) && is_not_negative(grasp.stiffness) &&
          is_positive(grasp.largest_force));
}

// m, of the plane's point above the plane
float gap_of(const ContactPlane& plane, const Eigen::Isometry3f& pose) {
  return vector_of(plane.normal).dot(pose * vector_of(plane.point)) - plane.offset;
}

}  // namespace

Eigen::Isometry3f pose_of(const ContactPacket& packet) noexcept {
  const auto& q = packet.rotation;
  Eigen::Isometry3f pose = Eigen::Isometry3f::Identity();
  pose.linear() = Eigen::Quaternionf(q[3], q[0], q[1], q[2]).toRotationMatrix();
  pose.translation() = vector_of(packet.position);
  return pose;
}

void set_pose(ContactPacket& packet, const Eigen::Isometry3f& pose) noexcept {
  const Eigen::Quaternionf q = Eigen::Quaternionf(pose.linear()).normalized();
  packet.rotation = {q.x(), q.y(), q.z(), q.w()};
  packet.position = packet_vector(pose.translation());
}

bool is_valid(const ContactPacket& packet) noexcept {
  const auto& q = packet.rotation;
  return std::isfinite(packet.time) && is_finite(packet.position) && is_finite(q) &&
         std::abs(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] - 1) < 2 * kUnit &&
         is_finite(packet.force) && is_finite(packet.torque) && is_not_negative(packet.drag) &&
         packet.plane_count <= ContactPacket::kLargestPlaneCount &&
         std::all_of(packet.planes.begin(), packet.planes.begin() + packet.plane_count,
                     [](const ContactPlane& plane) { return is_valid(plane); }) &&
         is_valid(packet.grasp);
}

Eigen::Vector3f plane_force(const ContactPacket& packet, const Eigen::Isometry3f& pose) noexcept {
  Eigen::Vector3f force = Eigen::Vector3f::Zero();
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    const ContactPlane& plane = packet.planes[i];
    force += plane.stiffness * std::max(0.0F, -gap_of(plane, pose)) * vector_of(plane.normal);
  }
  return force;
}

Eigen::Vector3f grasp_force(const ContactGrasp& grasp, const Eigen::Isometry3f& pose) noexcept {
  const Eigen::Vector3f force =
      grasp.stiffness * (vector_of(grasp.anchor) - pose * vector_of(grasp.point));
  const float size = force.norm();
  return size > grasp.largest_force ? Eigen::Vector3f(force * (grasp.largest_force / size)) : force;
}

Eigen::Matrix3f summed_stiffness(const ContactPacket& packet) noexcept {
  Eigen::Matrix3f sum = Eigen::Matrix3f::Zero();
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    const Eigen::Vector3f normal = vector_of(packet.planes[i].normal);
    sum += packet.planes[i].stiffness * normal * normal.transpose();
  }
  if (packet.grasp.state == GraspState::held) {
    sum += packet.grasp.stiffness * Eigen::Matrix3f::Identity();
  }
  return sum;
}

float largest_eigenvalue(const Eigen::Matrix3f& matrix) noexcept {
  // in double precision: the closed form loses half of the digits
  const Eigen::Matrix3d m = matrix.cast<double>();
  const double mean = m.trace() / 3;
  const Eigen::Matrix3d rest = m - mean * Eigen::Matrix3d::Identity();
  const double spread = std::sqrt(rest.squaredNorm() / 6);
  if (!(spread > 1e-9 * std::abs(mean))) {
    return static_cast<float>(mean);
  }
  const double cosine = std::clamp((rest / spread).determinant() / 2, -1.0, 1.0);
  return static_cast<float>(mean + 2 * spread * std::cos(std::acos(cosine) / 3));
}

namespace {

// The spring alone bears what it can: the solver's tools that hold do not push.
void fit_grasp(ContactPacket& packet, float stiffness) {
  ContactGrasp& grasp = packet.grasp;
  const Eigen::Vector3f force = vector_of(packet.force);
  const float size = force.norm();
  const float borne = std::min(size, grasp.largest_force);
  const Eigen::Vector3f stretch =
      size > 0 ? Eigen::Vector3f(force * (borne / size / stiffness)) : Eigen::Vector3f::Zero();
  grasp.stiffness = stiffness;
  grasp.anchor = packet_vector(pose_of(packet) * vector_of(grasp.point) + stretch);
  packet.plane_count = 0;
}

using Shares = std::array<float, ContactPacket::kLargestPlaneCount>;

// Of each plane, of the stiffness of the nearest.
void find_shares(const ContactPacket& packet, const Shares& gaps, Shares& shares) {
  float nearest = std::numeric_limits<float>::max();
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    nearest = std::min(nearest, std::max(0.0F, gaps[i]));
  }
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    shares[i] = std::max(kLeastShare, 1 - (std::max(0.0F, gaps[i]) - nearest) / kFarther);
  }
}

// N: of those planes that touch, pushes only, towards least squares; returns what they do not bear.
// By projected gradients, each by its stiffness: planes that are alike push alike, and lose touch
// together, else the tissue would seem as soft as one of them to a tool that goes back. So do
// planes that are nearly alike, as a few sweeps do not tell them apart: else the one that leans
// most to a side would bear all, for a little force that drags to that side.
Eigen::Vector3f solve_pushes(const ContactPacket& packet, const Shares& gaps, const Shares& shares,
                             Shares& pushes) {
  const auto for_each_touching = [&](const auto& visit) {
    for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
      if (gaps[i] < kTouching) {
        visit(i, vector_of(packet.planes[i].normal));
      }
    }
  };
  Eigen::Matrix3f sum = Eigen::Matrix3f::Zero();
  for_each_touching([&](std::uint32_t i, const Eigen::Vector3f& normal) {
    sum += shares[i] * normal * normal.transpose();
  });
  const float stiffest = largest_eigenvalue(sum);
  Eigen::Vector3f rest = vector_of(packet.force);
  for (int sweep = 0; sweep < kSweeps && stiffest > 0 && rest.norm() > kLeastForce / 10; ++sweep) {
    Eigen::Vector3f borne = Eigen::Vector3f::Zero();
    for_each_touching([&](std::uint32_t i, const Eigen::Vector3f& normal) {
      pushes[i] = std::max(0.0F, pushes[i] + shares[i] / stiffest * normal.dot(rest));
      borne += pushes[i] * normal;
    });
    rest = vector_of(packet.force) - borne;
  }
  return rest;
}

}  // namespace

void fit_to_force(ContactPacket& packet, float stiffness) noexcept {
  if (packet.grasp.state == GraspState::held) {
    fit_grasp(packet, stiffness);
    return;
  }
  const Eigen::Isometry3f pose = pose_of(packet);
  const auto find_gaps = [&](Shares& gaps) {
    for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
      gaps[i] = gap_of(packet.planes[i], pose);
    }
  };
  Shares gaps{}, shares{}, pushes{};
  find_gaps(gaps);
  find_shares(packet, gaps, shares);
  Eigen::Vector3f rest = solve_pushes(packet, gaps, shares, pushes);
  std::uint32_t extra = ContactPacket::kLargestPlaneCount;  // none
  if (rest.norm() > kLeastForce) {
    if (packet.plane_count == ContactPacket::kLargestPlaneCount) {
      const auto farthest = std::max_element(gaps.begin(), gaps.end()) - gaps.begin();
      packet.planes[static_cast<std::size_t>(farthest)] = packet.planes[--packet.plane_count];
      find_gaps(gaps);
      find_shares(packet, gaps, shares);
      pushes = {};
      rest = solve_pushes(packet, gaps, shares, pushes);
    }
    extra = packet.plane_count++;
    packet.planes[extra] = {.normal = packet_vector(rest.normalized())};
    gaps[extra] = 0;
    pushes[extra] = rest.norm();
    packet.planes[extra].offset = vector_of(packet.planes[extra].normal).dot(pose.translation());
  }

  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    // what planes cannot bear is mostly noise: it is as stiff as it is large
    packet.planes[i].stiffness =
        i == extra ? std::max(kLeastShare, pushes[i] / vector_of(packet.force).norm()) : shares[i];
  }
  const float sum = largest_eigenvalue(summed_stiffness(packet));
  for (std::uint32_t i = 0; i < packet.plane_count; ++i) {
    ContactPlane& plane = packet.planes[i];
    plane.stiffness *= stiffness / sum;
    if (gaps[i] <= 0 || pushes[i] > 0) {
      plane.offset =
          vector_of(plane.normal).dot(pose * vector_of(plane.point)) + pushes[i] / plane.stiffness;
    }
  }
}

}  // namespace pbdsurg
