// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Arrays in device memory, and in host memory that the device reads and writes.

#include <cstddef>
#include <span>
#include <utility>

#include <cuda_runtime_api.h>

#include "cuda/check.cuh"

namespace pbdsurg::cuda {

struct DeviceMemory {
  static void allocate(void** data, std::size_t bytes) {
    PBDSURG_CUDA_CHECK(cudaMalloc(data, bytes));
  }
  static void free(void* data) noexcept { static_cast<void>(cudaFree(data)); }
};

/// Host and device have one address space.
struct PinnedMemory {
  static void allocate(void** data, std::size_t bytes) {
    PBDSURG_CUDA_CHECK(cudaHostAlloc(data, bytes, cudaHostAllocMapped));
  }
  static void free(void* data) noexcept { static_cast<void>(cudaFreeHost(data)); }
};

/// Grows when asked for more, forgetting what it held, and never shrinks. No kernel or copy may be
/// at work on it then.
template <class T, class Memory>
class Buffer {
 public:
  Buffer() = default;
  ~Buffer() { Memory::free(data_); }
  Buffer(Buffer&& other) noexcept { swap(other); }
  Buffer& operator=(Buffer&& other) noexcept {
    swap(other);
    return *this;
  }

  /// @return the array, of at least `size` elements, not initialised
  T* reserve(std::size_t size) {
    if (size > capacity_) {
      Buffer larger;
      Memory::allocate(reinterpret_cast<void**>(&larger.data_), size * sizeof(T));
      larger.capacity_ = size;
      swap(larger);
    }
    return data_;
  }

  [[nodiscard]] T* get() const noexcept { return data_; }
  [[nodiscard]] std::size_t memory_bytes() const noexcept { return capacity_ * sizeof(T); }

 private:
  void swap(Buffer& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(capacity_, other.capacity_);
  }

  T* data_ = nullptr;
  std::size_t capacity_ = 0;
};

template <class T>
using PinnedBuffer = Buffer<T, PinnedMemory>;

template <class T>
class DeviceBuffer : public Buffer<T, DeviceMemory> {
 public:
  /// Reserves, and sets all bytes to `byte`.
  T* fill(std::size_t size, int byte, cudaStream_t stream) {
    T* const data = this->reserve(size);
    if (size > 0) {
      PBDSURG_CUDA_CHECK(cudaMemsetAsync(data, byte, size * sizeof(T), stream));
    }
    return data;
  }

  /// Makes room in each of some parts that lie one after another, and keeps what they have; all
  /// bytes of what is new are `byte`. Waits, if there is too little.
  /// @param before  elements of a part until now
  /// @param size    from now on
  T* enlarge(std::size_t parts, std::size_t before, std::size_t size, int byte,
             cudaStream_t stream) {
    if (parts == 0 || size <= before) {
      return this->get();
    }
    DeviceBuffer larger;
    T* const start = larger.fill(parts * size, byte, stream);
    if (before > 0) {
      PBDSURG_CUDA_CHECK(cudaMemcpy2DAsync(start, size * sizeof(T), this->get(), before * sizeof(T),
                                           before * sizeof(T), parts, cudaMemcpyDeviceToDevice,
                                           stream));
    }
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the smaller goes
    *this = std::move(larger);
    return start;
  }

  /// Reserves, and copies from the host.
  T* upload(std::span<const T> values, cudaStream_t stream) {
    T* const data = this->reserve(values.size());
    if (!values.empty()) {
      PBDSURG_CUDA_CHECK(cudaMemcpyAsync(data, values.data(), values.size_bytes(),
                                         cudaMemcpyHostToDevice, stream));
    }
    return data;
  }
};

}  // namespace pbdsurg::cuda
