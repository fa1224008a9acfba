// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An array in device memory.

#include <cstddef>
#include <span>
#include <utility>

#include <cuda_runtime_api.h>

#include "check.cuh"

namespace pbdsurg::cuda {

/// Grows when asked for more, forgetting what it held, and never shrinks.
template <class T>
class DeviceBuffer {
 public:
  DeviceBuffer() = default;
  ~DeviceBuffer() { static_cast<void>(cudaFree(data_)); }
  DeviceBuffer(DeviceBuffer&& other) noexcept { swap(other); }
  DeviceBuffer& operator=(DeviceBuffer&& other) noexcept {
    swap(other);
    return *this;
  }

  /// @return the array, of at least `size` elements, not initialised
  T* reserve(std::size_t size) {
    if (size > capacity_) {
      DeviceBuffer larger;
      PBDSURG_CUDA_CHECK(cudaMalloc(reinterpret_cast<void**>(&larger.data_), size * sizeof(T)));
      larger.capacity_ = size;
      swap(larger);
    }
    return data_;
  }

  /// Reserves, and sets all bytes to `byte`.
  T* fill(std::size_t size, int byte, cudaStream_t stream) {
    reserve(size);
    if (size > 0) {
      PBDSURG_CUDA_CHECK(cudaMemsetAsync(data_, byte, size * sizeof(T), stream));
    }
    return data_;
  }

  /// Reserves, and copies from the host.
  T* upload(std::span<const T> values, cudaStream_t stream) {
    reserve(values.size());
    if (!values.empty()) {
      PBDSURG_CUDA_CHECK(cudaMemcpyAsync(data_, values.data(), values.size_bytes(),
                                         cudaMemcpyHostToDevice, stream));
    }
    return data_;
  }

  [[nodiscard]] T* get() const noexcept { return data_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return capacity_ * sizeof(T); }

 private:
  void swap(DeviceBuffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

}  // namespace pbdsurg::cuda
