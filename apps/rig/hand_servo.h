// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The servo of one hand, between the thread that knows contacts and the one that ticks.

#include <Eigen/Geometry>
#include <atomic>
#include <cstdint>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/haptics/instrument_mapping.h"
#include "pbdsurg/haptics/servo.h"

#include "apps/rig/age_histogram.h"

namespace rig {

/// What a servo has done until now.
struct ServoReport {
  double time = 0;                 ///< s, of its last tick
  std::uint64_t tick_count = 0;    ///< since the start
  std::uint64_t missed_count = 0;  ///< ticks that there should have been between those
  AgeHistogram packet_ages;        ///< at each tick, of the newest packet, while there is one
  pbdsurg::ServoForce force;       ///< N, in the last tick, in the scene's axes
  pbdsurg::ServoFaults faults;     ///< since the start
  float engaged = 0;               ///< 0 no force to 1 all of it
};

/// Evaluates packets at the pose of the tick, and keeps account. tick() is the servo thread's, the
/// other threads have their ends of the mailboxes.
class HandServo {
 public:
  static constexpr double kPeriod = 1e-3;   ///< s
  static constexpr int kReportPeriod = 10;  ///< ticks, while force is on

  /// @throws pbdsurg::InvalidArgument  as ServoState
  explicit HandServo(const pbdsurg::ServoOptions& options) : state_(options) {}

  pbdsurg::Mailbox<pbdsurg::ContactPacket> packets;  ///< contacts' thread writes
  pbdsurg::Mailbox<ServoReport> reports;             ///< the window reads

  /// Turns the instrument about its shaft beside what the arm does, rad. Any thread.
  void set_roll(float roll) noexcept { roll_.store(roll, std::memory_order_relaxed); }

  /// Force is let in anew, while nothing is touched: after the scene has leapt. Any thread.
  void disengage() noexcept { is_to_disengage_.store(true, std::memory_order_relaxed); }

  /// One tick. No lock, no allocation; about 2 us.
  /// @param time      s, by the clock of the packets
  /// @param is_ready  see pbdsurg::ServoInput; is_warm likewise
  /// @return          N, for the motors, in the scene's axes
  Eigen::Vector3f tick(double time, const pbdsurg::MappedInstrument& instrument, bool is_ready,
                       bool is_warm) noexcept;

  /// As of the last tick. The servo thread's.
  [[nodiscard]] const ServoReport& report() const noexcept { return report_; }

 private:
  pbdsurg::ServoState state_;
  std::atomic<float> roll_ = 0;
  std::atomic<bool> is_to_disengage_ = false;
  ServoReport report_;
};

}  // namespace rig
