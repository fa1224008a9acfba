// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a block of a cluster does with its own and others' shared memory: the few instructions that
/// the language has no word for. Addresses are those of the shared state space. PTX ISA 8.1, which
/// is CUDA 12.1, for compute capability 9.0 on.

#include <cstdint>

#include <cuda_runtime.h>

namespace pbdsurg::cuda {

#define PBDSURG_CUDA_TOOLKIT_HAS_CLUSTERS \
  (__CUDACC_VER_MAJOR__ > 12 || (__CUDACC_VER_MAJOR__ == 12 && __CUDACC_VER_MINOR__ >= 1))
#if PBDSURG_CUDA_TOOLKIT_HAS_CLUSTERS && defined(__CUDA_ARCH__) && __CUDA_ARCH__ >= 900
#define PBDSURG_CUDA_HAS_CLUSTERS 1
#endif

#if defined(PBDSURG_CUDA_HAS_CLUSTERS)

__device__ inline std::uint32_t shared_address(const void* pointer) {
  return static_cast<std::uint32_t>(__cvta_generic_to_shared(pointer));
}

__device__ inline std::uint32_t block_of_cluster() {
  std::uint32_t rank;
  asm("mov.u32 %0, %%cluster_ctarank;" : "=r"(rank));
  return rank;
}

/// The same address in another block of the cluster.
__device__ inline std::uint32_t address_in(std::uint32_t block, std::uint32_t address) {
  std::uint32_t there;
  asm("mapa.shared::cluster.u32 %0, %1, %2;" : "=r"(there) : "r"(address), "r"(block));
  return there;
}

/// Waits for all threads of the cluster; what they wrote before is then seen.
__device__ inline void meet_cluster() {
  asm volatile(
      "barrier.cluster.arrive.release;\n"
      "barrier.cluster.wait.acquire;" ::
          : "memory");
}

/// Waits for `count` threads of the block, whole warps that name the same barrier.
__device__ inline void meet(int barrier, int count) {
  __syncwarp();
  asm volatile("barrier.sync.aligned %0, %1;" ::"r"(barrier), "r"(count) : "memory");
}

__device__ inline uint4 load_shared(std::uint32_t address) {
  uint4 v;
  asm volatile("ld.shared.v4.u32 {%0, %1, %2, %3}, [%4];"
               : "=r"(v.x), "=r"(v.y), "=r"(v.z), "=r"(v.w)
               : "r"(address)
               : "memory");
  return v;
}

__device__ inline void store_shared(std::uint32_t address, const float4& v) {
  asm volatile("st.shared.v4.f32 [%0], {%1, %2, %3, %4};" ::"r"(address), "f"(v.x), "f"(v.y),
               "f"(v.z), "f"(v.w)
               : "memory");
}

/// Without a branch.
__device__ inline void store_shared_if(bool condition, std::uint32_t address, const float4& v) {
  asm volatile(
      "{\n"
      ".reg .pred p;\n"
      "setp.ne.u32 p, %5, 0;\n"
      "@p st.shared.v4.f32 [%0], {%1, %2, %3, %4};\n"
      "}" ::"r"(address),
      "f"(v.x), "f"(v.y), "f"(v.z), "f"(v.w), "r"(static_cast<std::uint32_t>(condition))
      : "memory");
}

/// A barrier completes when all have come that it waits for; then it starts again, with the other
/// parity. One that waits for bytes waits for who arms it, and for as many as that asks for.
__device__ inline void make_barrier(std::uint32_t barrier, std::uint32_t count = 1) {
  asm volatile("mbarrier.init.shared::cta.b64 [%0], %1;" ::"r"(barrier), "r"(count) : "memory");
}

/// After make_barrier(), before other blocks may use it.
__device__ inline void publish_barriers() {
  asm volatile("fence.mbarrier_init.release.cluster;" ::: "memory");
}

__device__ inline void arm(std::uint32_t barrier, std::uint32_t bytes) {
  asm volatile("mbarrier.arrive.expect_tx.shared::cta.b64 _, [%0], %1;" ::"r"(barrier), "r"(bytes)
               : "memory");
}

/// Acquires for the block alone, as is usual for what copy engines bring: what comes lies in this
/// block's shared memory before the barrier completes. An acquire for the cluster empties the cache
/// each time, which costs a tenth of a step.
__device__ inline void wait_for(std::uint32_t barrier, std::uint32_t parity) {
  std::uint32_t is_complete;
  do {
    asm volatile(
        "{\n"
        ".reg .pred p;\n"
        "mbarrier.test_wait.parity.shared::cta.b64 p, [%1], %2;\n"
        "selp.u32 %0, 1, 0, p;\n"
        "}"
        : "=r"(is_complete)
        : "r"(barrier), "r"(parity)
        : "memory");
  } while (is_complete == 0);
}

/// Comes to a barrier of any block. Who waits for the cluster there sees what this thread, and
/// those that it met before, wrote.
__device__ inline void arrive(std::uint32_t barrier_there) {
  asm volatile("mbarrier.arrive.release.cluster.shared::cluster.b64 _, [%0];" ::"r"(barrier_there)
               : "memory");
}

/// Likewise, for the cluster.
__device__ inline void wait_for_cluster(std::uint32_t barrier, std::uint32_t parity) {
  std::uint32_t is_complete;
  do {
    asm volatile(
        "{\n"
        ".reg .pred p;\n"
        "mbarrier.test_wait.parity.acquire.cluster.shared::cta.b64 p, [%1], %2;\n"
        "selp.u32 %0, 1, 0, p;\n"
        "}"
        : "=r"(is_complete)
        : "r"(barrier), "r"(parity)
        : "memory");
  } while (is_complete == 0);
}

/// Of any block.
__device__ inline float4 load_there(std::uint32_t there) {
  float4 v;
  asm volatile("ld.shared::cluster.v4.f32 {%0, %1, %2, %3}, [%4];"
               : "=f"(v.x), "=f"(v.y), "=f"(v.z), "=f"(v.w)
               : "r"(there)
               : "memory");
  return v;
}
__device__ inline void store_there(std::uint32_t there, const float4& v) {
  asm volatile("st.shared::cluster.v4.f32 [%0], {%1, %2, %3, %4};" ::"r"(there), "f"(v.x), "f"(v.y),
               "f"(v.z), "f"(v.w)
               : "memory");
}

/// Writes into another block and completes 16 bytes of a barrier there, if asked to: without a
/// branch, so that threads of a warp that send different corners stay together.
__device__ inline void send_if(bool condition, std::uint32_t there, const float4& v,
                               std::uint32_t barrier_there) {
  asm volatile(
      "{\n"
      ".reg .pred p;\n"
      "setp.ne.u32 p, %6, 0;\n"
      "@p st.async.shared::cluster.mbarrier::complete_tx::bytes.v4.b32 [%0], {%1, %2, %3, %4}, "
      "[%5];\n"
      "}" ::"r"(there),
      "r"(__float_as_uint(v.x)), "r"(__float_as_uint(v.y)), "r"(__float_as_uint(v.z)),
      "r"(__float_as_uint(v.w)), "r"(barrier_there), "r"(static_cast<std::uint32_t>(condition))
      : "memory");
}

/// Copies into this block and completes the bytes of a barrier.
/// @param bytes  a positive multiple of 16
__device__ inline void fetch(std::uint32_t here, const void* from, std::uint32_t bytes,
                             std::uint32_t barrier) {
  asm volatile(
      "cp.async.bulk.shared::cluster.global.mbarrier::complete_tx::bytes [%0], [%1], %2, [%3];" ::
          "r"(here),
      "l"(from), "r"(bytes), "r"(barrier)
      : "memory");
}

#endif

}  // namespace pbdsurg::cuda
