// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime_api.h>

#include "pbdsurg/cuda/device.h"

#include "cuda/check.cuh"

namespace pbdsurg::cuda {
namespace {

int attribute(cudaDeviceAttr which, int device) {
  int value = 0;
  PBDSURG_CUDA_CHECK(cudaDeviceGetAttribute(&value, which, device));
  return value;
}

DeviceInfo describe(int device) {
  cudaDeviceProp properties{};
  PBDSURG_CUDA_CHECK(cudaGetDeviceProperties(&properties, device));
  DeviceInfo info;
  info.id = device;
  info.name = properties.name;
  info.compute_major = properties.major;
  info.compute_minor = properties.minor;
  info.memory = properties.totalGlobalMem;
  info.multiprocessor_count = properties.multiProcessorCount;
  info.supports_clusters = attribute(cudaDevAttrClusterLaunch, device) != 0;
  return info;
}

}  // namespace

DeviceList find_devices() {
  DeviceList list;
  int count = 0;
  const cudaError_t status = cudaGetDeviceCount(&count);
  if (status != cudaSuccess || count == 0) {
    static_cast<void>(cudaGetLastError());  // an answer, which later calls must not report again
    int driver = 0;
    if (cudaDriverGetVersion(&driver) == cudaSuccess && driver == 0) {
      list.reason = "no NVIDIA driver is installed";
    } else {
      list.reason = std::string("the CUDA runtime finds no device: ") + cudaGetErrorString(status);
    }
    return list;
  }
  for (int device = 0; device < count; ++device) {
    list.devices.push_back(describe(device));
  }
  return list;
}

}  // namespace pbdsurg::cuda
