// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device that a test moves.

#include <string>

#include "pbdsurg/haptics/device.h"

namespace pbdsurg::testing {

/// What the puppet says and was told, out of its owner's reach.
struct Strings {
  DeviceState state;
  Eigen::Vector3f force = Eigen::Vector3f::Zero();
};

class Puppet final : public Device {
 public:
  explicit Puppet(Strings& strings) : strings_(strings) {}
  [[nodiscard]] std::string name() const override { return "puppet"; }
  [[nodiscard]] DeviceState state() noexcept override { return strings_.state; }
  void set_force(const Eigen::Vector3f& force) noexcept override { strings_.force = force; }

 private:
  Strings& strings_;
};

}  // namespace pbdsurg::testing
