// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One organ, one hot ball that presses and slides, and all that a step of 1 ms does for a hand.

#include <cstdint>
#include <memory>
#include <vector>

#include "pbdsurg/base/executor.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/haptics/servo.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/views/live_surface.h"

#include "bench/haptic_rate/heat_thread.h"
#include "bench/support/static_energy.h"

namespace pbdsurg::bench {

/// What a step did, and how long its parts took.
struct RateStep {
  double heat_ms = 0;     ///< of the heat whose edit this step takes, beside earlier ones
  double heated_ms = 0;   ///< that it stands for
  double reading_ms = 0;  ///< positions for the next heat
  double solver_ms = 0;   ///< with that edit, which a device hides
  double edit_ms = 0;     ///< of solver_ms
  double contact_ms = 0;  ///< patch and packet
  double servo_ms = 0;
  bool is_heated = false;     ///< energy went into tissue
  bool is_heat_late = false;  ///< it was due, and is not ready
  bool is_touching = false;
  Index removed_tets = 0;
  Eigen::Vector3f force{0, 0, 0};  ///< N, of the packet: the simulation's
  ServoForce felt{};

  [[nodiscard]] double whole_ms() const noexcept {
    return reading_ms + solver_ms + contact_ms + servo_ms;
  }
};

/// The hollow gallbladder of a row of table 2, of 15 kPa, whose lower third lies fixed in its bed.
/// A ball of 4 mm with an electrode at its lowest point follows a hand: it waits above, presses
/// from there, and slides along the top.
class RateLoop {
 public:
  static constexpr double kStep = 1e-3;  ///< s

  /// @param heat  heat's executor
  RateLoop(int row, const Executor& executor, const Executor& heat);

  /// A step of 1 ms as a rig takes it: the tool to the hand, the solver, and beside it the edit
  /// that heat asks for; the tissue around the tool, its packet, the servo. If it burns, heat runs
  /// beside each two steps; the first that finds it ready takes its edit, and starts no other. No
  /// step waits for heat: where it is late, the next one stands for the time that has passed.
  /// @param depth  m, of the ball's lowest point under the surface at rest; negative above
  /// @param way    m, along the top, from its middle
  /// @throws Error  if vertices are not finite
  RateStep step(double depth, double way, bool burns);

  /// N, that holds the ball where it is now in the static solution of the same mesh, with no tissue
  /// removed; and how far tissue is from there.
  [[nodiscard]] HeldRest rest() const;

  [[nodiscard]] const Solver& solver() const { return solver_; }
  [[nodiscard]] Index triangle_count() const { return surface_->triangle_count(); }

 private:
  [[nodiscard]] ToolPose pose_at(double depth, double way) const;

  Scene scene_;
  Solver solver_;
  std::shared_ptr<const LiveSurface> surface_;
  ToolId tool_;
  Cautery cautery_;
  ContactProbe probe_;
  ContactPatch patch_;
  ServoState servo_;
  double owed_ = 0;     // s without heat
  int since_heat_ = 0;  // steps, while it burns
  HeatThread heat_{solver_, cautery_};
  std::vector<float> heights_;  // m, of the top, along the way
  std::uint64_t steps_ = 0;
};

}  // namespace pbdsurg::bench
