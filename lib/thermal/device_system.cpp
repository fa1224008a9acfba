// SPDX-License-Identifier: Apache-2.0
#include "thermal/device_system.h"

#include <utility>

#include "pbdsurg/core/error.h"

#include "core/check.h"

namespace pbdsurg {
namespace {

constinit MakeDeviceSystem registered = nullptr;  // before all static initialisers

std::unique_ptr<DeviceSystem> make_system() {
  if (registered == nullptr) {
    throw BackendUnavailable(
        "heat and potential cannot take a CUDA device: this program is not linked with "
        "pbdsurg::cuda");
  }
  return registered();
}

}  // namespace

MakeDeviceSystem set_device_system_maker(MakeDeviceSystem make) noexcept {
  return std::exchange(registered, make);
}

DeviceChoice::DeviceChoice(FieldBackend backend) : backend_(backend) {
  check(backend <= FieldBackend::cuda, "backend of a field", static_cast<double>(backend),
        "one of FieldBackend");
  if (backend == FieldBackend::cuda) {
    look();
  }
}

DeviceSystem* DeviceChoice::find(Index rows, Index rows_worth) {
  if (backend_ == FieldBackend::cpu || (backend_ == FieldBackend::automatic && rows < rows_worth)) {
    return nullptr;
  }
  if (!has_looked_) {
    look();
  }
  return system_.get();
}

void DeviceChoice::look() {
  try {
    system_ = make_system();
  } catch (const BackendUnavailable&) {
    if (backend_ == FieldBackend::cuda) {
      throw;
    }
  }
  has_looked_ = true;
}

}  // namespace pbdsurg
