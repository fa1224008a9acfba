// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a simulation tells a servo loop about the tissue around one tool.

#include <Eigen/Geometry>
#include <array>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// Three numbers that can be copied as bytes, which an Eigen::Vector3f cannot.
using PacketVector = std::array<float, 3>;

/// Likewise.
[[nodiscard]] inline PacketVector packet_vector(const Eigen::Vector3f& v) {
  return {v.x(), v.y(), v.z()};
}
/// And back.
[[nodiscard]] inline Eigen::Vector3f vector_of(const PacketVector& v) {
  return {v[0], v[1], v[2]};
}

/// A half space of tissue that pushes one point of a tool out: with the point at x, by
/// stiffness * max(0, offset - normal . x) along the normal.
struct ContactPlane {
  PacketVector point{};          ///< m, in the tool's frame
  PacketVector normal{0, 0, 1};  ///< unit, in the scene, out of the tissue
  float offset = 0;              ///< m: where the plane is along its normal
  float stiffness = 0;           ///< N/m, not negative
};

/// What a jaw holds.
enum class GraspState : std::uint8_t {
  open,  ///< nothing: what was held has been let go
  held,  ///< tissue
  torn,  ///< nothing: what was held has torn off
};

/// A spring from a point of a tool to where the tissue that it holds would rest.
struct ContactGrasp {
  GraspState state = GraspState::open;  ///< the rest counts while something is held
  PacketVector point{};                 ///< m, in the tool's frame
  PacketVector anchor{};                ///< m, in the scene
  float stiffness = 0;                  ///< N/m, not negative
  float largest_force = 1.5F;           ///< N, positive: the spring saturates there
};

/// A local model of the tissue around one tool, which a servo evaluates at poses of its own between
/// two steps of a simulation. Planes come before the tool touches them: one that is published only
/// once contact is seen is late by a period and by the delay, which costs two thirds of the
/// stiffness that is stable. Linearised contact: Otaduy and Lin, "A modular haptic rendering
/// algorithm for stable and transparent 6-DOF manipulation", IEEE Trans. Robotics 22(4), 2006.
struct ContactPacket {
  static constexpr std::size_t kLargestPlaneCount = 8;  ///< of one packet

  std::uint64_t sequence = 0;  ///< of the simulation's steps, ascending; 0 is no packet
  double time = 0;             ///< s, of the simulation's clock, when it was made
  PacketVector position{};     ///< m, of the tool's tip in the scene, for which it is
  std::array<float, 4> rotation{0, 0, 0, 1};  ///< x, y, z, w, of the tool's frame, likewise
  PacketVector force{};   ///< N, of the simulated tissue on the tool at that pose, unclamped
  PacketVector torque{};  ///< N m, likewise, about the tip
  float drag = 0;         ///< N s/m, not negative: what resists a tip in membrane or fat
  std::uint32_t plane_count = 0;                          ///< of the following
  std::array<ContactPlane, kLargestPlaneCount> planes{};  ///< the first plane_count count
  ContactGrasp grasp{};                                   ///< of the jaw
};
static_assert(std::is_trivially_copyable_v<ContactPacket>, "it is written over wires and records");
static_assert(sizeof(ContactPacket) <= 1024, "a servo copies it within a tick");

/// The pose that it is for.
[[nodiscard]] PBDSURG_API Eigen::Isometry3f pose_of(const ContactPacket& packet) noexcept;
PBDSURG_API void set_pose(ContactPacket& packet,
                          const Eigen::Isometry3f& pose) noexcept;  ///< likewise

/// Whether it can be felt: all numbers that count are finite, normals and the rotation are unit
/// (within 1e-3), counts and signs are as said above. A servo refuses others.
[[nodiscard]] PBDSURG_API bool is_valid(const ContactPacket& packet) noexcept;

/// N, in the scene, of all planes on a tool at a pose. Cost: O(planes), nanoseconds.
[[nodiscard]] PBDSURG_API Eigen::Vector3f plane_force(const ContactPacket& packet,
                                                      const Eigen::Isometry3f& pose) noexcept;

/// N, in the scene, of the grasp's spring on a tool at a pose, whatever the grasp's state.
[[nodiscard]] PBDSURG_API Eigen::Vector3f grasp_force(const ContactGrasp& grasp,
                                                      const Eigen::Isometry3f& pose) noexcept;

/// N/m, the sum of k n n^T of all planes, and of the grasp, if it holds.
[[nodiscard]] PBDSURG_API Eigen::Matrix3f summed_stiffness(const ContactPacket& packet) noexcept;

/// The largest eigenvalue of a symmetric matrix, which is not negative: of stiffness, that of the
/// stiffest direction. Closed form: Smith, "Eigenvalues of a symmetric 3 x 3 matrix", CACM 4(4),
/// 1961.
[[nodiscard]] PBDSURG_API float largest_eigenvalue(const Eigen::Matrix3f& matrix) noexcept;

/// Shares the stiffness of the tissue out among the planes, so that together they are as stiff as
/// the tissue in the stiffest direction, and moves those that touch, so that their forces at the
/// packet's pose add up to packet.force: transparency. Forces are near the least squares solution
/// with pushes only, but alike for planes that are alike, or nearly so: they lose touch together.
/// What planes do not bear is given to one more along it, in place of the farthest if there is no
/// room; while something is held, all to the grasp's spring, up to its largest force, and planes
/// are kept from pushing at that pose.
///
/// Sharing comes first because four points of contact with a plane each would be four times as
/// stiff as the tissue, and buzz. Cost: O(planes^2), microseconds; no allocation.
///
/// @param packet     with its pose, force, points, normals and, as offsets, where the surface is
/// @param stiffness  N/m, positive: of the tissue under the tool; also of the grasp
PBDSURG_API void fit_to_force(ContactPacket& packet, float stiffness) noexcept;

}  // namespace pbdsurg
