// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/instrument_mapping.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "lib/haptics/check_device.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

void check_positive(float value, const std::string& what) {
  if (!(value > 0) || !std::isfinite(value)) {
    throw InvalidArgument(what + " of an instrument's mapping is " + std::to_string(value) +
                          "; it must be finite and above 0");
  }
}

// rad, by which a rotation turns about its own third axis, once that points where it does: the
// twist of Diebel, "Representing attitude", 2006, section 5.
float twist_of(const Eigen::Matrix3f& rotation) {
  const Eigen::Quaternionf q(rotation);
  return 2 * std::atan2(q.z(), q.w());
}

// The shortest turn that takes +z to a unit vector; half a turn about x where that is -z.
Eigen::Matrix3f turn_to(const Vector3f& axis) {
  const float cosine = axis.z();
  if (cosine < -0.9999F) {
    return Vector3f(1, -1, -1).asDiagonal();
  }
  const float x = axis.x(), y = axis.y(), share = 1 / (1 + cosine);
  Eigen::Matrix3f turn;
  turn << 1 - share * x * x, -share * x * y, x,  //
      -share * x * y, 1 - share * y * y, y,      //
      -x, -y, cosine;
  return turn;
}

}  // namespace

InstrumentMapping::InstrumentMapping(const InstrumentMappingOptions& options) : options_(options) {
  if (!options.to_scene.matrix().allFinite() || !is_rotation(options.to_scene.linear())) {
    throw InvalidArgument(
        "the transform to the scene of an instrument's mapping must be rigid and finite; its axes "
        "are not those of a rotation, to 1e-3, or it is not finite");
  }
  if (!options.port.allFinite()) {
    throw InvalidArgument("the port of an instrument's mapping is not finite; it must be");
  }
  check_positive(options.motion_scale, "the motion scale");
  check_positive(options.shaft_length, "the shaft's length");
}

MappedInstrument InstrumentMapping::map(const Eigen::Isometry3f& arm) const noexcept {
  const Vector3f held = options_.to_scene.translation() +
                        options_.motion_scale * (options_.to_scene.linear() * arm.translation());
  MappedInstrument mapped;
  const Vector3f way = options_.port - held;
  const float distance = way.norm();
  const Vector3f towards = distance > 0 ? Vector3f(way / distance) : Vector3f::UnitZ();
  Vector3f shaft = towards;  // from the tip to the port
  if (options_.held == HeldPart::tip) {
    mapped.pose.translation() = held;
    mapped.lever.setIdentity();
  } else {
    const float outside = std::max(distance, kLeastDistance);
    const float inside = std::max(options_.shaft_length - outside, 0.0F);
    mapped.pose.translation() = options_.port + inside * towards;
    shaft = -towards;
    const float across = -inside / outside;
    const Eigen::Matrix3f along = towards * towards.transpose();
    mapped.lever = along + across * (Eigen::Matrix3f::Identity() - along);
  }
  const float twist = twist_of(options_.to_scene.linear() * arm.linear());
  mapped.pose.linear() = turn_to(shaft) * Eigen::AngleAxisf(twist, Vector3f::UnitZ());
  mapped.pose.makeAffine();
  return mapped;
}

Vector3f InstrumentMapping::arm_at(const Vector3f& tip) const noexcept {
  Vector3f held = tip;
  if (options_.held == HeldPart::handle) {
    const Vector3f way = options_.port - tip;
    const float inside = way.norm();
    const float outside = std::max(options_.shaft_length - inside, kLeastDistance);
    held = options_.port +
           (inside > 0 ? Vector3f(outside / inside * way) : Vector3f(outside * Vector3f::UnitZ()));
  }
  return options_.to_scene.linear().transpose() * (held - options_.to_scene.translation()) /
         options_.motion_scale;
}

}  // namespace pbdsurg
