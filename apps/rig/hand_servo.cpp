// SPDX-License-Identifier: Apache-2.0
#include "apps/rig/hand_servo.h"

#include <cmath>

namespace rig {
namespace {

constexpr double kMissed = 1.5;  // periods between ticks, from which one is missed

}  // namespace

Eigen::Vector3f HandServo::tick(double time, const pbdsurg::MappedInstrument& instrument,
                                bool is_ready, bool is_warm) noexcept {
  const bool has_leapt = is_to_disengage_.exchange(false, std::memory_order_relaxed);
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
  Eigen::Isometry3f tip = instrument.pose;
  tip.rotate(Eigen::AngleAxisf(roll_.load(std::memory_order_relaxed), Eigen::Vector3f::UnitZ()));
  report_.force = pbdsurg::servo_tick(state_, packet,
                                      {.time = time,
                                       .tip = tip,
                                       .lever = instrument.lever,
                                       .is_ready = is_ready,
                                       .is_warm = is_warm,
                                       .has_leapt = has_leapt});
  report_.faults = state_.chain().faults();
  report_.engaged = state_.chain().engaged();
  // the last tick of a device that is lost is not to be missed
  if (report_.tick_count % kReportPeriod == 0 || !is_ready) {
    reports.draft() = report_;
    reports.publish();
  }
  return report_.force.commanded;
}

}  // namespace rig
