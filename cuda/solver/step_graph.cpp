// SPDX-License-Identifier: Apache-2.0
#include "cuda/solver/step_graph.h"

#include <utility>

#include "cuda/check.cuh"

namespace pbdsurg::cuda {
namespace {

struct Recording {
  Recording() = default;
  ~Recording() {
    if (graph != nullptr) {
      static_cast<void>(cudaGraphDestroy(graph));
    }
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  cudaGraph_t graph = nullptr;
};

}  // namespace

StepGraph::~StepGraph() {
  if (executable_ != nullptr) {
    static_cast<void>(cudaGraphExecDestroy(executable_));
  }
}

void StepGraph::record(cudaStream_t stream, const std::function<void()>& enqueue) {
  Recording recording;
  PBDSURG_CUDA_CHECK(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal));
  try {
    enqueue();
  } catch (...) {
    static_cast<void>(cudaStreamEndCapture(stream, &recording.graph));
    static_cast<void>(cudaGetLastError());  // of the capture that this broke off
    throw;
  }
  PBDSURG_CUDA_CHECK(cudaStreamEndCapture(stream, &recording.graph));
  if (executable_ != nullptr) {
    PBDSURG_CUDA_CHECK(cudaGraphExecDestroy(std::exchange(executable_, nullptr)));
  }
  PBDSURG_CUDA_CHECK(cudaGraphInstantiate(&executable_, recording.graph, 0));
}

void StepGraph::launch(cudaStream_t stream) const {
  PBDSURG_CUDA_CHECK(cudaGraphLaunch(executable_, stream));
}

}  // namespace pbdsurg::cuda
