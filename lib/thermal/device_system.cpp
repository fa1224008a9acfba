// SPDX-License-Identifier: Apache-2.0
#include "thermal/device_system.h"

#include <utility>

#include "pbdsurg/core/error.h"

#include "core/check.h"

namespace pbdsurg {
namespace {

constinit MakeDeviceSystem registered = nullptr;  // before all static initialisers

}  // namespace

MakeDeviceSystem set_device_system_maker(MakeDeviceSystem make) noexcept {
  return std::exchange(registered, make);
}

std::unique_ptr<DeviceSystem> make_device_system(FieldBackend backend) {
  check(backend <= FieldBackend::cuda, "backend of a field", static_cast<double>(backend),
        "one of FieldBackend");
  if (backend == FieldBackend::cpu) {
    return nullptr;
  }
  try {
    if (registered == nullptr) {
      throw BackendUnavailable(
          "heat and potential cannot take a CUDA device: this program is not linked with "
          "pbdsurg::cuda");
    }
    return registered();
  } catch (const BackendUnavailable&) {
    if (backend == FieldBackend::cuda) {
      throw;
    }
    return nullptr;
  }
}

}  // namespace pbdsurg
