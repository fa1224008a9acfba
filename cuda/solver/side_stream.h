// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Kernels side by side: those that need nothing of each other.

#include <cuda_runtime_api.h>

#include "cuda/solver/step_kernels.h"
#include "cuda/stream.cuh"

namespace pbdsurg::cuda {

/// A stream beside that of a step.
class SideStream {
 public:
  SideStream() {
    for (cudaEvent_t* event : {&fork_, &join_}) {
      PBDSURG_CUDA_CHECK(cudaEventCreateWithFlags(event, cudaEventDisableTiming));
    }
  }
  ~SideStream() {
    static_cast<void>(cudaEventDestroy(fork_));
    static_cast<void>(cudaEventDestroy(join_));
  }
  SideStream(const SideStream&) = delete;
  SideStream& operator=(const SideStream&) = delete;

  /// What comes here from now on waits for what is in another stream.
  void fork(cudaStream_t from) const { wait(stream_.get(), from, fork_); }
  /// What comes there from now on waits for what is here.
  void join(cudaStream_t to) const { wait(to, stream_.get(), join_); }
  [[nodiscard]] cudaStream_t get() const noexcept { return stream_.get(); }

 private:
  static void wait(cudaStream_t waiting, cudaStream_t other, cudaEvent_t event) {
    PBDSURG_CUDA_CHECK(cudaEventRecord(event, other));
    PBDSURG_CUDA_CHECK(cudaStreamWaitEvent(waiting, event));
  }

  Stream stream_;
  cudaEvent_t fork_ = nullptr, join_ = nullptr;
};

/// Enqueues two chains of kernels, neither of which needs what the other writes. What is enqueued
/// later waits for both.
/// @param first   (launch)
/// @param second  (launch)
template <class First, class Second>
void side_by_side(const Launch& launch, const First& first, const Second& second) {
  if (launch.side == nullptr) {
    first(launch);
    second(launch);
    return;
  }
  const SideStream& side = *launch.side;
  side.fork(launch.stream);
  second(Launch{side.get(), launch.overlaps, launch.copies});
  first(Launch{launch.stream, launch.overlaps, launch.copies});
  side.join(launch.stream);
}

}  // namespace pbdsurg::cuda
