// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The tissue around one tool, by value, and the contact packet that a servo gets of it.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/haptics/contact_packet.h"
#include "pbdsurg/solver/tool.h"

namespace pbdsurg {

/// A ball of a tool that is watched for tissue: a tip, a jaw, places along a shaft.
struct ToolPoint {
  Eigen::Vector3f center{0, 0, 0};  ///< m, in the tool's frame
  float radius = 0;                 ///< m, positive
};

/// N/m, of a blunt tip on soft tissue: that of a flat rigid punch on an elastic half space,
/// 2 a E / (1 - nu^2) (Sneddon, "The relation between load and penetration in the axisymmetric
/// Boussinesq problem", Int. J. Engng Sci. 3, 1965). Moduli of tissues, with sources:
/// tissue/library.h.
/// @param radius          a, m, positive
/// @param youngs_modulus  E, Pa, positive
/// @param poissons_ratio  nu, in [0, 0.5)
/// @throws InvalidArgument  naming the value out of range
[[nodiscard]] PBDSURG_API float tip_stiffness(float radius, float youngs_modulus,
                                              float poissons_ratio);

/// A triangle of a surface near a tool, and what it is made of.
struct PatchTriangle {
  std::array<Eigen::Vector3f, 3> corners;  ///< m, in the scene, wound outwards
  float size;            ///< m, from the first corner to the farther one: no point of it is farther
  float youngs_modulus;  ///< Pa; 0 of springs, for which kLeastStiffness of haptics/servo.h stands
  float poissons_ratio;  ///< in [0, 0.5)
  float thickness = 0;   ///< m, of a sheet, which has no inside; 0 of the surface of a solid
};

/// A point of a tool, and how far the triangles around it are all there.
struct PatchPoint {
  ToolPoint ball;  ///< in the tool's frame
  /// m: the nearest triangle counts up to here, at any pose within ContactPatch::kMargin; what is
  /// farther is outside and of no interest
  float reach;
};

/// What a step leaves for a thread that makes contact packets: a tool, and the triangles that can
/// be nearest to one of its points at any pose within kMargin. ContactProbe fills it.
///
///     Mailbox<ContactPatch> patches;    // from the thread of the simulation to that of contact
///     Mailbox<ContactPacket> packets;   // from there to the servo's
///
///     probe.collect_patch(solver, tool, grasp, step, time, patches.draft());  // simulation
///     patches.publish();
///
///     if (patches.take() > 0) {                                               // contact
///       packets.draft() = make_contact_packet(patches.value(), hand.pose);
///       packets.publish();
///     }
///
/// A tool on a spring is not where the hand is: its patch is moved by what tissue displaces it, so
/// that a hand feels at its own place what the tool feels at its.
///
/// Lists keep their memory, so a mailbox of patches allocates only where more tissue is near than
/// ever before.
struct ContactPatch {
  static constexpr float kReach = 5e-3F;   ///< m: tissue this near a point is told before touch
  static constexpr float kMargin = 2e-3F;  ///< m: how far a point may be from where the step had it

  std::uint64_t sequence = 0;            ///< of the step, above zero; 0 is no patch
  double time = 0;                       ///< s, of the step
  ToolPose pose = ToolPose::Identity();  ///< of the tool after it; on a spring, where it is to be
  Eigen::Vector3f force{0, 0, 0};  ///< N, of the tissue on the tool in it, but of what it lost then
  GraspState grasp = GraspState::open;  ///< what the tool does to tissue
  float slip_limit =
      std::numeric_limits<float>::infinity();  ///< N, >= 0: Solver::slip_limit() of the tool
  std::vector<PatchPoint> points{};            ///< [n] of the tool, at most as many as a packet's
  std::vector<PatchTriangle> triangles{};      ///< by body, in the order of its surface
};

/// A plane for each point of the tool that has tissue within kReach, and for those inside: that at
/// the nearest point of all triangles. They are as stiff as the nearest body's tip_stiffness() for
/// the point of the least gap, of sheets no stiffer than their modulus times their thickness, of
/// springs kLeastStiffness of haptics/servo.h; and they push at the step's pose, which is the
/// packet's, as the tissue pushes in the simulation: fit_to_force(). The spring of what the tool
/// holds saturates where that slips, or at the step's force, if more pulls across the jaws. The
/// torque is that of the planes. Drag is zero: who knows that the tool is in fat or membrane sets
/// it.
///
/// Depends on its arguments alone. Cost: O(points * triangles), no allocation; 0.025 ms of eight
/// points among 650 triangles (contact_probe_bench, as ContactProbe).
/// @param where  where the tool is by now, for which nearest points are looked for; if a point is
///               then farther than kMargin from where the step had it, those of the step are
/// @throws InvalidArgument  if the patch has more points than a packet has planes
[[nodiscard]] PBDSURG_API ContactPacket make_contact_packet(const ContactPatch& patch,
                                                            const ToolPose& where);

/// Likewise, where the step had the tool.
/// @throws InvalidArgument  likewise
[[nodiscard]] inline ContactPacket make_contact_packet(const ContactPatch& patch) {
  return make_contact_packet(patch, patch.pose);
}

}  // namespace pbdsurg
