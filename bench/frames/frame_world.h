// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Liver and gallbladder in a world, a grasper that presses on the liver and a hook that burns it.
/// Likewise without contact, for what that takes.

#include <array>
#include <cstddef>

#include "pbdsurg/world/world.h"

namespace pbdsurg::bench {

enum class FrameContact {
  all,
  none,  ///< instruments are elsewhere, and organs do not meet
};

class FrameWorld {
 public:
  /// What was made before the first frame, ms.
  struct MakingTimes {
    double solver;  ///< tissue, constraints, colours, plan
    double heat;
    double surfaces;
  };

  /// @param scene    of make_liver_and_gallbladder()
  /// @param options  who steps, and how
  /// @param step     s, of a frame
  FrameWorld(const Scene& scene, const SolverOptions& options, double step,
             FrameContact contact = FrameContact::all);

  /// The instruments move on, the hook with current.
  /// @throws Error  if the world refuses something or a vertex is not finite
  Frame next();

  [[nodiscard]] const MakingTimes& making() const { return making_; }
  [[nodiscard]] double step() const { return step_; }
  [[nodiscard]] const ToolPose& hook_pose() const { return hook_pose_; }
  [[nodiscard]] const ToolPose& grasper_pose() const { return grasper_pose_; }
  [[nodiscard]] World& world() { return world_; }
  /// [body] gallbladder and liver
  [[nodiscard]] const std::array<const Surface*, 2>& surfaces() const { return surfaces_; }

 private:
  void aim();

  MakingTimes making_{};
  World world_;
  double step_;
  FrameContact contact_;
  double time_ = 0;         // s
  Eigen::Vector3f lowest_;  // m, of the liver at rest
  ToolPose hook_pose_ = ToolPose::Identity(), grasper_pose_ = ToolPose::Identity();
  ToolId hook_, grasper_;
  CauteryId burner_;
  std::array<const Surface*, 2> surfaces_{};
};

}  // namespace pbdsurg::bench
