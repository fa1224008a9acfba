// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The CUDA devices of this machine. Plain C++: needs no CUDA header.

#include <cstddef>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"

namespace pbdsurg::cuda {

/// A CUDA call that failed, or a device that was lost. The message names the call and the reason.
class PBDSURG_API DeviceError : public Error {
 public:
  using Error::Error;
};

/// One device of this machine.
struct DeviceInfo {
  int id = 0;                      ///< as the CUDA runtime numbers it
  std::string name;                ///< "NVIDIA H200"
  int compute_major = 0;           ///< compute capability, 9 of 9.0
  int compute_minor = 0;           ///< 0 of 9.0
  std::size_t memory = 0;          ///< total device memory, bytes
  int multiprocessor_count = 0;    ///< streaming multiprocessors
  bool supports_clusters = false;  ///< thread block clusters with distributed shared memory
};

/// The devices found, or why there are none.
struct DeviceList {
  std::vector<DeviceInfo> devices;  ///< in the order of their ids
  std::string reason;               ///< empty if devices is not, else one sentence for the user
};

/// Lists the devices. No driver and no device are answers, not errors. The first call in a process
/// may take a second, while the driver starts.
///
/// @throws DeviceError  if a driver with devices is there but does not answer about one of them
[[nodiscard]] PBDSURG_API DeviceList find_devices();

/// A device for solvers, heat, potential and colourings.
/// @param ordinal  DeviceInfo::id
/// @throws BackendUnavailable  if there is none, saying why, or none of this ordinal
/// @throws DeviceError         as find_devices()
[[nodiscard]] PBDSURG_API Executor device(int ordinal = 0);

/// The first device, where there is one that answers, and executor::threads() else, or for a scene
/// that the device cannot take. Executor::name() and Solver::backend_name() say which.
[[nodiscard]] PBDSURG_API Executor best();

}  // namespace pbdsurg::cuda
