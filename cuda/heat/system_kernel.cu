// SPDX-License-Identifier: Apache-2.0
#include <cuda_runtime.h>

#include "cuda/check.cuh"
#include "cuda/heat/system_kernel.cuh"

namespace pbdsurg::cuda {
namespace {

__global__ void __launch_bounds__(kSystemThreads, 1)
    solve(const __grid_constant__ SystemArrays arrays, const __grid_constant__ SystemInput input,
          const __grid_constant__ SystemOutput output) {
  extern __shared__ uint4 shared[];
  SystemSolution(arrays, input, reinterpret_cast<unsigned char*>(shared)).run(output);
}

int attribute(cudaDeviceAttr which) {
  int device = 0;
  int value = 0;
  PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
  PBDSURG_CUDA_CHECK(cudaDeviceGetAttribute(&value, which, device));
  return value;
}

/// A launch of one cluster.
struct SystemLaunch {
  cudaLaunchAttribute cluster{};
  cudaLaunchConfig_t config{};

  SystemLaunch(Index block_count, std::size_t shared_bytes, cudaStream_t stream) {
    cluster.id = cudaLaunchAttributeClusterDimension;
    cluster.val.clusterDim = {static_cast<unsigned>(block_count), 1, 1};
    config.gridDim = dim3(static_cast<unsigned>(block_count));
    config.blockDim = dim3(kSystemThreads);
    config.dynamicSmemBytes = shared_bytes;
    config.stream = stream;
    config.attrs = &cluster;
    config.numAttrs = block_count > 1 ? 1 : 0;
  }
};

// Whether the device runs clusters of so many blocks.
bool can_launch(Index block_count, std::size_t shared_bytes) {
  const SystemLaunch launch(block_count, shared_bytes, nullptr);
  int clusters = 0;
  const cudaError_t status = cudaOccupancyMaxActiveClusters(&clusters, solve, &launch.config);
  if (status == cudaErrorInvalidClusterSize || status == cudaErrorInvalidValue) {
    static_cast<void>(cudaGetLastError());  // an answer
    return false;
  }
  check(status, "asking how many clusters the device runs at a time");
  return clusters > 0;
}

}  // namespace

SystemLimits prepare_system_kernel() {
  cudaFuncAttributes attributes;
  PBDSURG_CUDA_CHECK(cudaFuncGetAttributes(&attributes, solve));
  // the room is the same for all systems: a kernel's attributes are, too
  const int room = attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  PBDSURG_CUDA_CHECK(
      cudaFuncSetAttribute(solve, cudaFuncAttributeMaxDynamicSharedMemorySize, room));
  SystemLimits limits{1, static_cast<std::size_t>(room) - sizeof(SharedSums)};
#if PBDSURG_CUDA_TOOLKIT_HAS_CLUSTERS
  if (attribute(cudaDevAttrClusterLaunch) != 0 && attributes.binaryVersion >= 90) {
    PBDSURG_CUDA_CHECK(
        cudaFuncSetAttribute(solve, cudaFuncAttributeNonPortableClusterSizeAllowed, 1));
    limits.most_blocks = kMostSystemBlocks;
    while (limits.most_blocks > 1 &&
           !can_launch(limits.most_blocks, static_cast<std::size_t>(room))) {
      limits.most_blocks /= 2;
    }
  }
#endif
  return limits;
}

void solve_system(const SystemArrays& arrays, const SystemInput& input, const SystemOutput& output,
                  Index block_count, cudaStream_t stream) {
  const std::size_t shared_bytes =
      sizeof(SharedSums) + (arrays.is_in_shared_memory ? arrays.block_bytes : 0);
  const SystemLaunch launch(block_count, shared_bytes, stream);
  check(cudaLaunchKernelEx(&launch.config, solve, arrays, input, output),
        "launching the solution of a system");
}

}  // namespace pbdsurg::cuda
