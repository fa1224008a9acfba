// SPDX-License-Identifier: Apache-2.0
// Arms of a build with HDAPI: OpenHaptics or its emulator.
#include <string_view>
#include <utility>

#include "apps/rig/arms.h"

namespace rig {
namespace {

class HdapiArms final : public Arms {
 public:
  HdapiArms(std::vector<HdapiDeviceOptions> devices, pbdsurg::Clock& clock)
      : session_(std::move(devices), clock) {}

  [[nodiscard]] pbdsurg::Device& device(int index) override { return session_.device(index); }
  [[nodiscard]] HdapiStatus status(int index) override { return session_.device(index).status(); }
  [[nodiscard]] const HdapiLimits& limits(int index) override {
    return session_.device(index).limits();
  }
  void poll() override { session_.poll(); }

 private:
  HdapiSession session_;
};

}  // namespace

std::unique_ptr<Arms> open_arms(const std::vector<ArmOptions>& arms, bool are_emulated,
                                pbdsurg::Clock& clock) {
  const bool has_emulator = std::string_view(hdapi_flavour()) == "emulator";
  if (are_emulated != has_emulator) {
    throw pbdsurg::BackendUnavailable(
        are_emulated ? "this build has OpenHaptics, not its emulator: configure another with "
                       "-D PBDSURG_HDAPI=emulator"
                     : "this build has the emulator of OpenHaptics: install the SDK, see "
                       "docs/rig.md, and configure with -D PBDSURG_HDAPI=sdk");
  }
  std::vector<HdapiDeviceOptions> devices;
  for (const ArmOptions& arm : arms) {
    devices.push_back({.label = arm.label,
                       .name = arm.name,
                       .serial_number = arm.serial_number,
                       .force = [mapping = arm.mapping, servo = arm.servo](const HdapiTick& tick) {
                         return mapping.force_at_arm(servo->tick(tick.time, mapping.map(tick.pose),
                                                                 tick.is_ready, tick.is_warm));
                       }});
  }
  return std::make_unique<HdapiArms>(std::move(devices), clock);
}

}  // namespace rig
