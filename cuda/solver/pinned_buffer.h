// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An array in host memory that the device reads and writes.

#include <cstddef>
#include <utility>

#include <cuda_runtime_api.h>

#include "check.cuh"

namespace pbdsurg::cuda {

/// Grows when asked for more, forgetting what it held, and never shrinks. No kernel or copy may be
/// at work on it then.
template <class T>
class PinnedBuffer {
 public:
  PinnedBuffer() = default;
  ~PinnedBuffer() { static_cast<void>(cudaFreeHost(data_)); }
  PinnedBuffer(PinnedBuffer&& other) noexcept { swap(other); }
  PinnedBuffer& operator=(PinnedBuffer&& other) noexcept {
    swap(other);
    return *this;
  }

  /// @return the array, of at least `size` elements, not initialised
  T* reserve(std::size_t size) {
    if (size > capacity_) {
      PinnedBuffer larger;
      PBDSURG_CUDA_CHECK(cudaHostAlloc(reinterpret_cast<void**>(&larger.data_), size * sizeof(T),
                                       cudaHostAllocMapped));
      larger.capacity_ = size;
      swap(larger);
    }
    return data_;
  }

  /// Where the host finds it, and the device, too: both have one address space.
  [[nodiscard]] T* get() const noexcept { return data_; }

 private:
  void swap(PinnedBuffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

}  // namespace pbdsurg::cuda
