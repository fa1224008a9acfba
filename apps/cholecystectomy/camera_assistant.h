// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Moves the scope while both hands of the surgeon are busy.

#include <Eigen/Core>
#include <span>

#include "pbdsurg/base/error.h"

#include "apps/cholecystectomy/scope.h"

namespace cholecystectomy {

/// Keeps the tips of instruments in view, as a person who holds the camera does. While they are in
/// the inner part of the picture, and not too small, the scope rests. Once one leaves it, the scope
/// moves until their middle is in the middle of the picture: closer where they are close together,
/// back where they are far apart.
///
/// The way goes straight from one pose to the other, in angles and insertion. Along it a critically
/// damped spring pulls, whose speed has a limit; so nothing swings. A level scope stays level, and
/// all keep to the port's limits. Deterministic: the same calls give the same bits.
class CameraAssistant {
 public:
  static constexpr float kInnerPart = 0.65F;     ///< half heights of the picture, a radius
  static constexpr float kMargin = 0.45F;        ///< likewise, of what was arranged, where it can
  static constexpr float kTurningSpeed = 0.3F;   ///< rad/s, at most
  static constexpr float kSlidingSpeed = 0.04F;  ///< m/s, at most
  /// m: the scope comes no nearer to a tip, and slides back from one that comes nearer.
  static constexpr float kNearest = 0.06F;
  static constexpr double kLongestStep = 0.1;  ///< s: longer steps count as this one

  /// An instrument is withdrawn, and ignored, while its tip is outside of a ball: the scene.
  /// @param centre, radius  m
  /// @throws pbdsurg::InvalidArgument  if the centre is not finite or the radius not positive
  CameraAssistant(const Eigen::Vector3f& centre, float radius);

  /// Off from the beginning. Who switches it off stops the scope at once.
  void switch_on(bool is_on);
  [[nodiscard]] bool is_on() const noexcept { return is_on_; }

  /// Moves the scope for a time, if it is on.
  /// @param tips  [instrument_count] m; those that are not finite are ignored
  /// @param dt  s
  /// @throws pbdsurg::InvalidArgument  if the time is negative or not finite
  void follow(Scope& scope, std::span<const Eigen::Vector3f> tips, double dt);

 private:
  Eigen::Vector3f centre_;
  float radius_;
  bool is_on_ = false;
  bool is_moving_ = false;
  Eigen::Vector4f speed_ = Eigen::Vector4f::Zero();  // of angles, insertion, focus
};

}  // namespace cholecystectomy
