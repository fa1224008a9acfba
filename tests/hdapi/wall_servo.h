// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a device runs in truth: a servo with its safety chain, and packets of a wall.

#include <cstdint>
#include <limits>
#include <vector>

#include "pbdsurg/haptics/servo.h"

#include "apps/hdapi/hdapi_device.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/hdapi/rig_of_two.h"

namespace rig::testing {

/// A wall below y = 0, for a tool that is at a pose.
inline pbdsurg::ContactPacket wall_packet(std::uint64_t sequence, double time,
                                          const Eigen::Isometry3f& pose) {
  pbdsurg::ContactPacket packet;
  packet.sequence = sequence;
  packet.time = time;
  set_pose(packet, pose);
  packet.plane_count = 1;
  packet.planes[0] = {.normal = {0, 1, 0}, .stiffness = kStiffness};
  packet.force = pbdsurg::packet_vector(plane_force(packet, pose));
  return packet;
}

/// A device's force in one tick.
inline pbdsurg::ServoForce servo_force(pbdsurg::ServoState& servo,
                                       const pbdsurg::ContactPacket& packet,
                                       const HdapiTick& tick) {
  return servo_tick(
      servo, packet,
      {.time = tick.time, .tip = tick.pose, .is_ready = tick.is_ready, .is_warm = tick.is_warm});
}

/// What the servo of a device knew and said in one tick.
struct ServoRecord {
  bool is_ready;
  Eigen::Vector3f computed, commanded;  ///< N
  float engaged;                        ///< 0 to 1, of the safety chain
};

/// The servo of one device, with a packet in each tenth tick. Faults above HDAPI are its own: no
/// packets, and a force that is no number after the safety chain.
class WallServo {
 public:
  explicit WallServo(const hdapi_emulator::Emulator& emulator, int device = 0)
      : emulator_(&emulator), device_(device) {
    records.reserve(1 << 16);
  }

  Eigen::Vector3f force(const HdapiTick& tick) {
    using hdapi_emulator::Fault;
    if (records.size() % 10 == 0 && !emulator_->is_active(Fault::stale_packets, device_)) {
      packet_ = wall_packet(packet_.sequence + 1, tick.time, tick.pose);
    }
    const pbdsurg::ServoForce force = servo_force(servo, packet_, tick);
    records.push_back({tick.is_ready, force.computed, force.commanded, servo.chain().engaged()});
    if (emulator_->is_active(Fault::simulation_nan, device_)) {
      return Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
    }
    return force.commanded;
  }

  pbdsurg::ServoState servo;
  std::vector<ServoRecord> records;  ///< one a tick

 private:
  const hdapi_emulator::Emulator* emulator_;
  int device_;
  pbdsurg::ContactPacket packet_;
};

}  // namespace rig::testing
