// SPDX-License-Identifier: Apache-2.0
#include "apps/hdapi/device_fault.h"

namespace rig {

const char* name_of(DeviceFault fault) noexcept {
  switch (fault) {
    case DeviceFault::warm_motors:
      return "warm motors";
    case DeviceFault::exceeded_force:
      return "too much force";
    case DeviceFault::exceeded_impulse:
      return "force changed too fast";
    case DeviceFault::exceeded_velocity:
      return "stylus too fast";
    case DeviceFault::force_error:
      return "force error";
    case DeviceFault::bad_call:
      return "refused call";
    case DeviceFault::bad_reading:
      return "unreadable pose";
    case DeviceFault::simulation_not_a_number:
      return "NaN from the simulation";
    case DeviceFault::clock_jump:
      return "clock jump";
    case DeviceFault::late_tick:
      return "late tick";
    case DeviceFault::dropped_tick:
      return "dropped tick";
    case DeviceFault::stuck_calibration:
      return "stuck calibration";
    case DeviceFault::lost_communication:
      return "lost communication";
    case DeviceFault::device_failure:
      return "device failure";
    case DeviceFault::wrong_handle:
      return "wrong handle";
    case DeviceFault::scheduler_failure:
      return "scheduler failure";
    case DeviceFault::swapped_devices:
      return "swapped devices";
  }
  return "";
}

}  // namespace rig
