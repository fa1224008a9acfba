// SPDX-License-Identifier: Apache-2.0
#include "lib/heat/device_system.h"

#include "pbdsurg/base/error.h"

#include "lib/base/executor_state.h"

namespace pbdsurg {

DeviceSystem* DeviceChoice::find(Index rows) {
  const ExecutorState* const state = executor_.state();
  if (state == nullptr || state->device() == nullptr || rows < device_rows_) {
    return nullptr;
  }
  if (!has_looked_) {
    auto* const device = dynamic_cast<FieldDevice*>(state->device());
    if (device != nullptr) {
      try {
        system_ = device->make_system();
      } catch (const BackendUnavailable&) {
        if (!state->instead()) {
          throw;
        }
      }
    }
    has_looked_ = true;
  }
  return system_.get();
}

}  // namespace pbdsurg
