// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A stream of one device, and which device calls go to.

#include <cuda_runtime_api.h>

#include "cuda/check.cuh"

namespace pbdsurg::cuda {

/// While it lives, a device is the thread's current one.
class CurrentDevice {
 public:
  explicit CurrentDevice(int device) {
    PBDSURG_CUDA_CHECK(cudaGetDevice(&before_));
    PBDSURG_CUDA_CHECK(cudaSetDevice(device));
  }
  ~CurrentDevice() { static_cast<void>(cudaSetDevice(before_)); }
  CurrentDevice(const CurrentDevice&) = delete;
  CurrentDevice& operator=(const CurrentDevice&) = delete;

 private:
  int before_ = 0;
};

/// Waits for nothing that other streams do.
class Stream {
 public:
  Stream() { PBDSURG_CUDA_CHECK(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking)); }
  ~Stream() { static_cast<void>(cudaStreamDestroy(stream_)); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  void wait() const { PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream_)); }
  [[nodiscard]] cudaStream_t get() const noexcept { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

}  // namespace pbdsurg::cuda
