// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The twelve faults of the emulator, and what must come of each.

#include <algorithm>
#include <cstddef>
#include <optional>
#include <vector>

#include "apps/hdapi/device_fault.h"
#include "apps/hdapi_emulator/emulator.h"
#include "tests/support/catch.h"

namespace rig::testing {

/// What becomes of the force.
enum class After { comes_back, stays_off, never_off };

/// A fault, for some time, must do this.
struct FaultCase {
  hdapi_emulator::Fault fault;
  std::optional<DeviceFault> counted;  ///< by the driver; else by the servo
  After after;
  double duration = 0.1;  ///< s
};

inline const std::vector<FaultCase>& fault_cases() {
  using hdapi_emulator::Fault;
  static const std::vector<FaultCase> cases = {
      {Fault::lost_communication, DeviceFault::lost_communication, After::stays_off},
      {Fault::dropped_tick, DeviceFault::dropped_tick, After::never_off, 0.003},
      {Fault::late_tick, DeviceFault::late_tick, After::never_off, 0.001},
      {Fault::warm_motors, DeviceFault::warm_motors, After::comes_back},
      // long enough for as many updates as make it stuck, one a poll
      {Fault::stuck_calibration, DeviceFault::stuck_calibration, After::comes_back, 1},
      {Fault::wrong_handle, DeviceFault::wrong_handle, After::stays_off},
      {Fault::force_error, DeviceFault::force_error, After::comes_back},
      {Fault::unplugged, DeviceFault::device_failure, After::stays_off},
      {Fault::simulation_nan, DeviceFault::simulation_not_a_number, After::comes_back},
      {Fault::stale_packets, std::nullopt, After::comes_back, 0.5},
      {Fault::clock_jump, DeviceFault::clock_jump, After::comes_back, 0.001},
      {Fault::swapped_devices, DeviceFault::swapped_devices, After::stays_off},
  };
  return cases;
}

/// Whether it happens to both devices, not to the first alone.
inline bool is_of_both(hdapi_emulator::Fault fault) {
  return fault == hdapi_emulator::Fault::clock_jump ||
         fault == hdapi_emulator::Fault::swapped_devices;
}

/// Requires clamp and slew of a device's forces.
inline void check_bounds(const std::vector<hdapi_emulator::ForceRecord>& forces) {
  for (std::size_t index = 1; index < forces.size(); ++index) {
    INFO("at " << forces[index].time << " s");
    REQUIRE(forces[index].set.allFinite());
    REQUIRE(forces[index].set.norm() <= 2.6001);
    REQUIRE((forces[index].set - forces[index - 1].set).norm() <= 0.2001);
  }
}

/// N, that was commanded at a time, s.
inline double size_at(const std::vector<hdapi_emulator::ForceRecord>& forces, double time) {
  double size = -1;
  for (const hdapi_emulator::ForceRecord& force : forces) {
    if (force.time <= time) {
      size = force.set.norm();
    }
  }
  return size;
}

/// N, the least that was commanded between two times, s.
inline double least_between(const std::vector<hdapi_emulator::ForceRecord>& forces, double begin,
                            double end) {
  double least = 10;
  for (const hdapi_emulator::ForceRecord& force : forces) {
    if (force.time >= begin && force.time < end) {
      least = std::min(least, force.set.norm());
    }
  }
  return least;
}

/// Checks what the driver counted: what it must, and nothing else.
inline void check_counts(const FaultCase& one, const FaultCounts& counts) {
  for (std::size_t index = 0; index < kDeviceFaultCount; ++index) {
    const auto fault = static_cast<DeviceFault>(index);
    INFO(name_of(fault));
    if (fault != one.counted) {
      CHECK(counts.of(fault) == 0);
    } else if (is_fatal(fault)) {
      CHECK(counts.of(fault) == 1);  // though it lasts
    } else {
      CHECK(counts.of(fault) >= 1);
    }
  }
}

}  // namespace rig::testing
