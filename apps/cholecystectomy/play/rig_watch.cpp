// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/rig_watch.h"

#include <cstdio>

namespace cholecystectomy {

using rig::DeviceFault;
using rig::HandStatus;
using rig::HdapiCalibration;
using rig::Mover;

std::vector<std::string> RigWatch::update(rig::Side side, const HandStatus& now) {
  HandStatus& before = before_[static_cast<std::size_t>(side)];
  std::vector<std::string> news;
  const auto tell = [&](bool is_so, const char* format) {
    if (is_so) {
      std::array<char, 192> text{};
      std::snprintf(text.data(), text.size(), format, texts_.sides[static_cast<std::size_t>(side)]);
      news.emplace_back(text.data());
    }
  };
  if (now.mover == Mover::arm) {
    const auto grew = [&](DeviceFault fault) {
      return now.arm.faults.of(fault) > before.arm.faults.of(fault);
    };
    const auto began = [&](HdapiCalibration calibration) {
      return now.arm.calibration == calibration && before.arm.calibration != calibration;
    };
    tell(now.arm.is_lost && !before.arm.is_lost, texts_.arm_lost);
    tell(!now.arm.is_lost && !now.is_connected && before.is_connected, texts_.arm_silent);
    tell(began(HdapiCalibration::needs_inkwell), texts_.arm_inkwell);
    tell(grew(DeviceFault::stuck_calibration), texts_.arm_stuck);
    if (grew(DeviceFault::warm_motors)) {
      double& last = warm_[static_cast<std::size_t>(side)];
      tell(now.servo.time - last > kSpell, texts_.arm_warm);
      last = now.servo.time;
    }
    tell(now.handle == pbdsurg::HandleCondition::lost && before.handle != now.handle,
         texts_.handle_lost);
    tell(now.handle == pbdsurg::HandleCondition::live &&
             before.handle == pbdsurg::HandleCondition::lost,
         texts_.handle_back);
  } else if (now.mover == Mover::trace) {
    tell(!now.is_connected && before.is_connected && now.servo.tick_count > 0, texts_.trace_over);
  }
  before = now;
  return news;
}

std::string RigWatch::line(rig::Side side, const HandStatus& status) const {
  if (status.mover == Mover::mouse) {
    return {};
  }
  const char* condition = texts_.hand_fine;
  if (!status.is_connected) {
    condition = texts_.hand_lost;
  } else if (status.mover == Mover::arm && status.arm.calibration != HdapiCalibration::done) {
    condition = texts_.hand_not_calibrated;
  } else if (status.servo.engaged < 1) {
    condition = texts_.hand_engaging;
  }
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), texts_.hand_line,
                texts_.sides[static_cast<std::size_t>(side)], status.name.c_str(),
                static_cast<double>(status.servo.force.commanded.norm()),
                static_cast<double>(status.servo.force.computed.norm()), condition);
  return text.data();
}

}  // namespace cholecystectomy
