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

// Whether it has the same kernels in the same order, and does what was recorded from now on: a cut
// changes how many blocks of vertices there are and little else, which takes less time so.
bool can_take(cudaGraphExec_t executable, cudaGraph_t graph) {
  cudaGraphExecUpdateResultInfo info{};
  const bool has_taken = cudaGraphExecUpdate(executable, graph, &info) == cudaSuccess;
  if (!has_taken) {
    static_cast<void>(cudaGetLastError());  // there is another way
  }
  return has_taken;
}

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
  if (executable_ != nullptr && can_take(executable_, recording.graph)) {
    return;
  }
  if (executable_ != nullptr) {
    PBDSURG_CUDA_CHECK(cudaGraphExecDestroy(std::exchange(executable_, nullptr)));
  }
  PBDSURG_CUDA_CHECK(cudaGraphInstantiate(&executable_, recording.graph, 0));
}

void StepGraph::launch(cudaStream_t stream) const {
  PBDSURG_CUDA_CHECK(cudaGraphLaunch(executable_, stream));
}

}  // namespace pbdsurg::cuda
