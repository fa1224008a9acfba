// SPDX-License-Identifier: Apache-2.0
#include <memory>
#include <string>

#include "pbdsurg/core/error.h"
#include "pbdsurg/cuda/device.h"

#include "solver/backend.h"
#include "solver/cuda_backend.h"
#include "solver/cuda_hook.h"
#include "thermal/cuda_system.h"
#include "thermal/device_system.h"

namespace pbdsurg::cuda {
namespace {

// Devices do not come and go, so only a failure is asked about again.
bool is_available(std::string& why_not) {
  try {
    static const DeviceList list = find_devices();
    why_not = list.reason;
    return !list.devices.empty();
  } catch (const DeviceError& error) {
    why_not = error.what();
    return false;
  }
}

constexpr CudaHook kHook{is_available, make_backend};

std::unique_ptr<DeviceSystem> make_system() {
  std::string why_not;
  if (!is_available(why_not)) {
    throw BackendUnavailable("heat and potential cannot take a CUDA device: " + why_not);
  }
  return make_cuda_system();
}

struct Registration {
  Registration() {
    set_cuda_hook(&kHook);
    set_device_system_maker(make_system);
  }
} const registration;

}  // namespace
}  // namespace pbdsurg::cuda

// The linker takes a member of a static library only for a symbol that somebody needs: this one,
// which CMake asks for.
extern "C" {
extern const char pbdsurg_cuda_backend;
const char pbdsurg_cuda_backend = 1;
}
