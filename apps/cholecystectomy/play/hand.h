// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A hand that mouse and keyboard move.

#include <Eigen/Geometry>
#include <string>

#include "pbdsurg/base/clock.h"
#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/device.h"

namespace cholecystectomy {

/// Where an instrument may go: through its port, with the tip within a ball around the organs.
struct Reach {
  Eigen::Vector3f port;    ///< m
  Eigen::Vector3f centre;  ///< m
  float radius;            ///< m
};

/// The window's thread moves it, the simulation's reads it as a device. All moves are of the tip;
/// the shaft passes through the port.
class MouseHand final : public pbdsurg::Device {
 public:
  /// @param clock  gives states their time; outlives the hand
  MouseHand(std::string name, const Reach& reach, const Eigen::Vector3f& tip,
            const pbdsurg::Clock& clock);

  /// @name The window's thread
  /// @{
  void move(const Eigen::Vector3f& way);  ///< m; ends at the border of the reach
  void roll(float angle);                 ///< rad, about the shaft
  void set_jaw(float jaw);                ///< 0 closed to 1 open
  void set_pedals(const pbdsurg::Pedals& pedals);
  void reset();                  ///< to where it was made, the jaws open, pedals up
  void refresh() { publish(); }  ///< says that it is still there
  /// Ports and places to begin at; both begin anew there.
  void exchange_places(MouseHand& other);
  [[nodiscard]] const Eigen::Vector3f& tip() const { return tip_; }
  [[nodiscard]] float jaw() const { return jaw_; }
  /// @}

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] pbdsurg::DeviceState state() noexcept override;

 private:
  void publish();

  std::string name_;
  Reach reach_;
  const pbdsurg::Clock& clock_;
  Eigen::Vector3f start_, tip_;
  float roll_ = 0;
  float jaw_ = 1;
  pbdsurg::Pedals pedals_;
  pbdsurg::Mailbox<pbdsurg::DeviceState> states_;
};

}  // namespace cholecystectomy
