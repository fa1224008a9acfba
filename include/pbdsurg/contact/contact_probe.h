// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a servo has to know of a simulation: contact packets of a tool and the tissue around it.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/haptics/contact_packet.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/views/live_surface.h"

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

/// Follows the surfaces that a tool may touch.
class PBDSURG_API ContactProbe {
 public:
  static constexpr float kReach = 5e-3F;  ///< m: tissue this near a point is told before touch

  /// @param bodies  [n] of the solver's tissue
  /// @param points  [n] of the tool, at most as many as a packet has planes
  /// @throws InvalidArgument  naming the body that there is not, the point that is not finite or
  ///                          whose radius is not positive, or the number of points
  ContactProbe(const Solver& solver, std::span<const Index> bodies,
               std::span<const ToolPoint> points);

 private:
  friend ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                           GraspState grasp, std::uint64_t sequence, double time);
  std::vector<std::shared_ptr<const LiveSurface>> surfaces_;
  std::vector<ToolPoint> points_;
  std::vector<Eigen::Vector3f> positions_;  // scratch
};

/// A plane for each point of a tool that has tissue near: the nearest of all live surfaces, as the
/// last step left it. They are as stiff as the nearest body's tip_stiffness() for the point of the
/// least gap, of springs kLeastStiffness of haptics/servo.h; and they push at the tool's pose as
/// the tissue pushes in the simulation, Solver::tool_force(): fit_to_force(). The torque is that of
/// these planes. Drag is zero: who knows that the tool is in fat or membrane sets it.
///
/// Cost: O(vertices + points * triangles): 0.2 ms a point of a surface of 8,000 triangles.
/// @param grasp     what the tool does to tissue now, as the solver does not tell
/// @param sequence  of the packet, above zero
/// @param time      s, of the packet
/// @throws InvalidArgument  if there is no such tool
[[nodiscard]] PBDSURG_API ContactPacket make_contact_packet(ContactProbe& probe,
                                                            const Solver& solver, ToolId tool,
                                                            GraspState grasp,
                                                            std::uint64_t sequence, double time);

}  // namespace pbdsurg
