// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Chooses and launches the kernel of cluster_kernel.cuh, where the device has room for it.

#include "cuda/solver/cluster_kernel.cuh"
#include "cuda/solver/kernel_support.cuh"
#include "lib/device/cluster_layout.h"

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

using ClusterKernel = void (*)(ClusterArrays, DeviceState, ToolArrays, StepInput*, ClusterSweep);

template <int kThreads, bool kDamped>
ClusterKernel choose_cluster_kernel(ClusterTissue tissue) {
  constexpr auto kMode = ProjectionMode::compliance;
  switch (tissue) {
    case ClusterTissue::all:
      return sweep_by_cluster<kMode, kDamped, ClusterTissue::all, kThreads, false>;
    case ClusterTissue::solids:
      return sweep_by_cluster<kMode, kDamped, ClusterTissue::solids, kThreads, false>;
    case ClusterTissue::springs:
      break;
  }
  return sweep_by_cluster<kMode, kDamped, ClusterTissue::springs, kThreads, false>;
}

/// With extra phases, for any tissue.
template <int kThreads>
ClusterKernel choose_extra_kernel(const ClusterKind& kind) {
  constexpr auto kMode = ProjectionMode::compliance;
  constexpr auto kFraction = ProjectionMode::fraction;
  if (kind.mode == kFraction) {
    return sweep_by_cluster<kFraction, false, ClusterTissue::springs, kThreads, true>;
  }
  return kind.is_damped ? sweep_by_cluster<kMode, true, ClusterTissue::all, kThreads, true>
                        : sweep_by_cluster<kMode, false, ClusterTissue::all, kThreads, true>;
}

template <int kThreads>
ClusterKernel choose_cluster_kernel(const ClusterKind& kind) {
  if (kind.has_extra_phases) {
    return choose_extra_kernel<kThreads>(kind);
  }
  if (kind.mode == ProjectionMode::fraction) {
    return sweep_by_cluster<ProjectionMode::fraction, false, ClusterTissue::springs, kThreads,
                            false>;
  }
  return kind.is_damped ? choose_cluster_kernel<kThreads, true>(kind.tissue)
                        : choose_cluster_kernel<kThreads, false>(kind.tissue);
}

ClusterKernel choose_cluster_kernel(const ClusterKind& kind) {
  return kind.thread_count == kFewClusterThreads ? choose_cluster_kernel<kFewClusterThreads>(kind)
                                                 : choose_cluster_kernel<kManyClusterThreads>(kind);
}

/// A launch of one cluster a copy.
struct ClusterLaunch {
  cudaLaunchAttribute attributes[2]{};
  cudaLaunchConfig_t config{};
  std::uint32_t least_bytes;  ///< of shared memory

  ClusterLaunch(const ClusterKind& kind, const ClusterArrays& cluster, const Launch& how) {
    attributes[0].id = cudaLaunchAttributeClusterDimension;
    attributes[0].val.clusterDim = {cluster.block_count, 1, 1};
    attributes[1].id = cudaLaunchAttributeProgrammaticStreamSerialization;
    attributes[1].val.programmaticStreamSerializationAllowed = 1;
    config.gridDim = dim3(cluster.block_count, static_cast<unsigned>(how.copies));
    config.blockDim = dim3(static_cast<unsigned>(kind.thread_count + kWarp));
    const bool has_displacements = kind.mode == ProjectionMode::compliance;
    least_bytes = ClusterLayout(cluster, has_displacements, kind.is_damped).size;
    const std::uint32_t wanted =
        least_bytes + 16 * static_cast<std::uint32_t>(kMostStagedCorners - kStagedClusterCorners);
    const auto room =
        static_cast<std::uint32_t>(device_attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin));
    config.dynamicSmemBytes = least_bytes < room && room < wanted ? room : wanted;
    config.stream = how.stream;
    config.attrs = attributes;
    config.numAttrs = how.overlaps ? 2 : 1;
  }
};

Index prepare_cluster(const ClusterKind& kind, const ClusterArrays& cluster) {
#if PBDSURG_CUDA_TOOLKIT_HAS_CLUSTERS
  constexpr std::uint32_t kPortableBlocks = 8;
  const auto* const kernel = reinterpret_cast<const void*>(choose_cluster_kernel(kind));
  const ClusterLaunch launch(kind, cluster, {});
  const int room = device_attribute(cudaDevAttrMaxSharedMemoryPerBlockOptin);
  if (device_attribute(cudaDevAttrClusterLaunch) == 0 || code_architecture() < 90 ||
      static_cast<int>(launch.least_bytes) > room) {
    return 0;
  }
  // the room is the same for all solvers: a kernel's attributes are, too
  check(cudaFuncSetAttribute(kernel, cudaFuncAttributeMaxDynamicSharedMemorySize, room),
        "asking for all shared memory of a block");
  if (cluster.block_count > kPortableBlocks) {
    check(cudaFuncSetAttribute(kernel, cudaFuncAttributeNonPortableClusterSizeAllowed, 1),
          "asking for clusters of sixteen blocks");
  }
  int clusters = 0;
  const cudaError_t status = cudaOccupancyMaxActiveClusters(&clusters, kernel, &launch.config);
  if (status == cudaErrorInvalidClusterSize || status == cudaErrorInvalidValue) {
    static_cast<void>(cudaGetLastError());  // an answer
    return 0;
  }
  check(status, "asking how many clusters the device runs at a time");
  return clusters;
#else
  static_cast<void>(kind);
  static_cast<void>(cluster);
  return 0;
#endif
}

void sweep_cluster(const ClusterKind& kind, const ClusterArrays& cluster, const DeviceState& state,
                   const ToolArrays& tools, StepInput* input, const ClusterSweep& sweep,
                   const Launch& how) {
  const ClusterLaunch launch(kind, cluster, how);
  check(cudaLaunchKernelEx(&launch.config, choose_cluster_kernel(kind), cluster, state, tools,
                           input, sweep),
        "launching the sweeps of a cluster");
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
