// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/instrument_mapping.h"

#include <limits>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/haptics/servo.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"

namespace pbdsurg {
namespace {

using Eigen::Isometry3f;
using Eigen::Vector3f;
using testing::Approx;

float unit(int sample, int value) {
  return static_cast<float>(random_unit(7, sample, value));
}

// A turned arm beside a port, of either kind.
InstrumentMappingOptions rig_of(HeldPart held) {
  InstrumentMappingOptions options;
  options.held = held;
  options.port = {0.02F, -0.1F, -0.15F};
  options.motion_scale = 1.5F;
  options.to_scene = Eigen::Translation3f(0.04F, -0.16F, -0.22F) *
                     Eigen::AngleAxisf(0.9F, Vector3f(1, 2, -1).normalized());
  return options;
}

Isometry3f arm_of(int sample) {
  const Vector3f at =
      0.05F * Vector3f(unit(sample, 0) - 0.5F, unit(sample, 1) - 0.5F, unit(sample, 2) - 0.5F);
  return Eigen::Translation3f(at) *
         Eigen::AngleAxisf(2 * unit(sample, 3), Vector3f(unit(sample, 4), 1, -1).normalized());
}

}  // namespace

// Would catch a shaft that misses the port, a tip off its place, a pose that is no rotation, or an
// arm_at() that is not the way back.
TEST_CASE("instrument mapping: shafts pass through the port", "[property]") {
  for (const HeldPart held : {HeldPart::tip, HeldPart::handle}) {
    const InstrumentMapping mapping(rig_of(held));
    const InstrumentMappingOptions& options = mapping.options();
    for (int sample = 0; sample < 200; ++sample) {
      const Isometry3f arm = arm_of(sample);
      const Isometry3f pose = mapping.map(arm).pose;
      const Vector3f tip = pose.translation();
      const Vector3f held_at =
          options.to_scene.translation() +
          options.motion_scale * (options.to_scene.linear() * arm.translation());
      CHECK((pose.linear().transpose() * pose.linear()).isIdentity(1e-5F));
      CHECK(pose.linear().determinant() > 0);
      CHECK((pose.linear() * Vector3f::UnitZ()).isApprox((options.port - tip).normalized(), 1e-4F));
      if (held == HeldPart::tip) {
        CHECK(tip == held_at);
      } else {
        CHECK((held_at - tip).norm() == Approx(options.shaft_length).epsilon(1e-4));
        CHECK((options.port - tip).cross(held_at - tip).norm() < 1e-6F);
      }
      CHECK((mapping.arm_at(tip) - arm.translation()).norm() < 1e-6F);
    }
  }
}

// Would catch a lever of another convention than the servo's: work at the tip must be work in the
// hand, by differences of the mapping itself.
TEST_CASE("instrument mapping: the lever is the tip's motion a motion of the hand", "[property]") {
  for (const HeldPart held : {HeldPart::tip, HeldPart::handle}) {
    const InstrumentMapping mapping(rig_of(held));
    const InstrumentMappingOptions& options = mapping.options();
    for (int sample = 0; sample < 50; ++sample) {
      const Isometry3f arm = arm_of(sample);
      const MappedInstrument mapped = mapping.map(arm);
      for (int axis = 0; axis < 3; ++axis) {
        constexpr float kStep = 1e-4F;
        Isometry3f moved = arm;
        moved.translation() += kStep * Vector3f::Unit(axis);
        const Vector3f by_difference =
            (mapping.map(moved).pose.translation() - mapped.pose.translation()) / kStep;
        const Vector3f by_lever =
            options.motion_scale *
            (mapped.lever * (options.to_scene.linear() * Vector3f::Unit(axis)));
        CHECK((by_difference - by_lever).norm() < 0.02F);
      }
      if (held == HeldPart::handle) {
        const Vector3f handle =
            options.to_scene.translation() +
            options.motion_scale * (options.to_scene.linear() * arm.translation());
        const Eigen::Matrix3f lever =
            lever_about_port(options.port, handle, mapped.pose.translation());
        CHECK((lever - mapped.lever).norm() < 1e-3F);
      }
    }
  }
}

// Would catch a roll that is lost, of the wrong sign, or mixed with the way the stylus points.
TEST_CASE("instrument mapping: a stylus turned about itself turns the instrument", "[unit]") {
  InstrumentMappingOptions options;
  options.port = {0, 0, 0.2F};
  const InstrumentMapping mapping(options);
  const Eigen::AngleAxisf tilt(0.4F, Vector3f::UnitX());
  const Isometry3f still(tilt);
  const Isometry3f turned(tilt * Eigen::AngleAxisf(0.7F, Vector3f::UnitZ()));
  const Eigen::AngleAxisf between(mapping.map(still).pose.linear().transpose() *
                                  mapping.map(turned).pose.linear());
  CHECK(between.angle() == Approx(0.7).epsilon(1e-4));
  CHECK(between.axis().isApprox(Vector3f::UnitZ(), 1e-4F));
}

// Would catch a division by no distance: a hand may go anywhere.
TEST_CASE("instrument mapping: a hand at the port, behind it, or far away", "[unit]") {
  for (const HeldPart held : {HeldPart::tip, HeldPart::handle}) {
    InstrumentMappingOptions options;
    options.held = held;
    const InstrumentMapping mapping(options);
    for (const Vector3f& at : {Vector3f(0, 0, 0), Vector3f(0, 0, 1e-20F), Vector3f(0, 0, -0.01F),
                               Vector3f(0, 0, 5), Vector3f(0, 0, -5), Vector3f(1e6F, 0, 0)}) {
      const MappedInstrument mapped = mapping.map(Isometry3f(Eigen::Translation3f(at)));
      CHECK(mapped.pose.matrix().allFinite());
      CHECK(mapped.lever.allFinite());
      CHECK(mapped.lever.norm() < 25);  // of 0.33 m, a handle 0.02 m away
      CHECK((mapped.pose.linear().transpose() * mapped.pose.linear()).isIdentity(1e-4F));
      CHECK(mapping.arm_at(at).allFinite());
    }
  }
}

TEST_CASE("instrument mapping: what is refused", "[unit]") {
  const auto make = [](auto change) {
    return [change] {
      InstrumentMappingOptions options;
      change(options);
      return InstrumentMapping(options);
    };
  };
  using Options = InstrumentMappingOptions;
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  testing::check_refused(make([](Options& o) { o.motion_scale = 0; }), "motion scale");
  testing::check_refused(make([](Options& o) { o.shaft_length = kNan; }), "shaft's length");
  testing::check_refused(make([](Options& o) { o.port.x() = kNan; }), "port");
  testing::check_refused(make([](Options& o) { o.to_scene.linear() *= 2; }), "rigid");
}

}  // namespace pbdsurg
