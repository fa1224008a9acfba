// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Turns a failed CUDA call into an exception.

#include <string>

#include <cuda_runtime_api.h>

#include "pbdsurg/cuda/device.h"

namespace pbdsurg::cuda {

/// @throws DeviceError  unless status is cudaSuccess
inline void check(cudaError_t status, const char* call) {
  if (status != cudaSuccess) {
    // a sticky error stays, any other must not surface in the next call that asks
    static_cast<void>(cudaGetLastError());
    throw DeviceError(std::string(call) + " failed: " + cudaGetErrorString(status) + " (" +
                      cudaGetErrorName(status) + ")");
  }
}

}  // namespace pbdsurg::cuda

/// Throws DeviceError, naming the call, unless the call returns cudaSuccess. After a kernel launch:
/// PBDSURG_CUDA_CHECK(cudaGetLastError()).
#define PBDSURG_CUDA_CHECK(call) ::pbdsurg::cuda::check((call), #call)
