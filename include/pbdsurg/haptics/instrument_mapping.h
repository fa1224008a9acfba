// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where in the scene the instrument is that a haptic arm moves.

#include <Eigen/Geometry>
#include <cstdint>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg {

/// What of the instrument goes along with the arm's tip.
enum class HeldPart : std::uint8_t {
  tip,     ///< the instrument's tip: the hand goes where the tip goes
  handle,  ///< the handle outside of the body: the tip goes the other way, about the port
};

/// How an arm stands to the scene.
struct InstrumentMappingOptions {
  HeldPart held = HeldPart::tip;  ///< by the arm
  /// From the axes of the arm to those of the scene: the arm's origin goes to its translation, m.
  Eigen::Isometry3f to_scene = Eigen::Isometry3f::Identity();
  float motion_scale = 1;        ///< m of the scene a metre of the arm, above 0
  Eigen::Vector3f port{0, 0, 0}; /**< m, in the scene: where the shaft passes through the wall */
  float shaft_length = 0.33F;    ///< m, from handle to tip, above 0; usual instruments have 0.33
};

/// An instrument where an arm has it.
struct MappedInstrument {
  Eigen::Isometry3f pose;  ///< in the scene, m: the tip at the origin, the shaft along +z
  Eigen::Matrix3f lever;   ///< see lever_about_port() of haptics/servo.h; without the motion scale
};

/// Instruments pass through ports, so that an arm of three coordinates is enough: the shaft points
/// from the tip to the port. How the stylus is turned about its own axis turns the instrument about
/// its shaft.
class PBDSURG_API InstrumentMapping {
 public:
  /// m. A handle that is nearer to its port is taken to be so far away, and its tip goes out to the
  /// port and no farther. A tip that is held can be moved past the port: there the shaft turns
  /// over.
  static constexpr float kLeastDistance = 0.02F;

  /// @throws InvalidArgument  naming the option that is not finite, not rigid, or not above 0
  explicit InstrumentMapping(const InstrumentMappingOptions& options = {});

  /// @param arm  pose in the axes of the arm, m: +z from the stylus' tip to the hand
  /// Cost: about 50 ns; no allocation. Not finite where the pose is not.
  [[nodiscard]] MappedInstrument map(const Eigen::Isometry3f& arm) const noexcept;

  /// Where the arm's tip is for an instrument's tip, m, in the axes of the arm: map() backwards.
  /// @param tip  m, in the scene; of a handle's, within the shaft's length of the port
  [[nodiscard]] Eigen::Vector3f arm_at(const Eigen::Vector3f& tip) const noexcept;

  /// N, in the axes of the arm, of a force in those of the scene.
  [[nodiscard]] Eigen::Vector3f force_at_arm(const Eigen::Vector3f& force) const noexcept {
    return options_.to_scene.linear().transpose() * force;
  }

  /// As given.
  [[nodiscard]] const InstrumentMappingOptions& options() const noexcept { return options_; }

 private:
  InstrumentMappingOptions options_;
};

}  // namespace pbdsurg
