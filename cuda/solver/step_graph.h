// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step recorded once and launched as a whole.

#include <functional>

#include <cuda_runtime_api.h>

namespace pbdsurg::cuda {

class StepGraph {
 public:
  StepGraph() = default;
  ~StepGraph();
  StepGraph(const StepGraph&) = delete;
  StepGraph& operator=(const StepGraph&) = delete;

  /// Records what a function enqueues on a stream, in place of what was recorded before. Nothing of
  /// it is executed.
  void record(cudaStream_t stream, const std::function<void()>& enqueue);

  void launch(cudaStream_t stream) const;

 private:
  cudaGraphExec_t executable_ = nullptr;
};

}  // namespace pbdsurg::cuda
