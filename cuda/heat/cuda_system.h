// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Local systems on the current device.

#include <memory>

#include "lib/heat/device_system.h"

namespace pbdsurg::cuda {

/// @throws BackendUnavailable  if the current device cannot run it
std::unique_ptr<DeviceSystem> make_cuda_system();

}  // namespace pbdsurg::cuda
