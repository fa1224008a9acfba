// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/hand_servo.h"

#include <cmath>

namespace rig {
namespace {

constexpr double kMissed = 1.5;  // periods between ticks, from which one is missed

pbdsurg::ServoOptions scaled_as(pbdsurg::ServoOptions options,
                                const pbdsurg::InstrumentMapping& mapping) {
  options.motion_scale = mapping.options().motion_scale;
  return options;
}

}  // namespace

HandServo::HandServo(const pbdsurg::ServoOptions& options,
                     const pbdsurg::InstrumentMapping& mapping)
    : mapping_(mapping), state_(scaled_as(options, mapping)) {}

Eigen::Vector3f HandServo::tick(double time, const Eigen::Isometry3f& arm, bool is_ready,
                                bool is_warm) noexcept {
  const double interval = time - report_.time;
  if (report_.tick_count > 0 && interval > kMissed * kPeriod) {
    report_.missed_count += static_cast<std::uint64_t>(std::lround(interval / kPeriod)) - 1;
  }
  report_.time = time;
  ++report_.tick_count;

  packets.take();
  const pbdsurg::ContactPacket& packet = packets.value();
  if (packet.sequence > 0) {
    report_.packet_ages.add(time - packet.time);
  }
  pbdsurg::MappedInstrument mapped = mapping_.map(arm);
  mapped.pose.rotate(
      Eigen::AngleAxisf(roll_.load(std::memory_order_relaxed), Eigen::Vector3f::UnitZ()));
  report_.force = pbdsurg::servo_tick(state_, packet,
                                      {.time = time,
                                       .tip = mapped.pose,
                                       .lever = mapped.lever,
                                       .is_ready = is_ready,
                                       .is_warm = is_warm});
  if (report_.tick_count % kReportPeriod == 0) {
    report_.faults = state_.chain().faults();
    report_.engaged = state_.chain().engaged();
    reports.draft() = report_;
    reports.publish();
  }
  return mapping_.force_at_arm(report_.force.commanded);
}

}  // namespace rig
