// SPDX-License-Identifier: Apache-2.0
// How long one step of a chain takes on a CUDA device, by what hands it over to the next: what
// bounds a sweep, whose phases depend on each other. See cuda/README.md.
#include <cstdint>
#include <cstdio>

#include <benchmark/benchmark.h>

#include "pbdsurg/cuda/device.h"

#include "cuda/buffer.cuh"
#include "cuda/check.cuh"
#include "cuda/solver/cluster_memory.cuh"
#include "cuda/stream.cuh"

namespace pbdsurg::bench {
namespace {

using cuda::DeviceBuffer;
using cuda::Stream;

constexpr int kBlocks = 16;        // of a cluster
constexpr int kThreads = 256;      // of a block
constexpr int kHandovers = 20000;  // in a kernel
constexpr int kLaunches = 2000;    // of a stream or a graph

enum class Way {
  message,
  remote_store,
  remote_arrival,
  remote_load,
  cluster_barrier,
  block_barrier
};

#if defined(PBDSURG_CUDA_HAS_CLUSTERS)

__device__ void store_remote(std::uint32_t there, float value) {
  asm volatile("st.relaxed.cluster.shared::cluster.f32 [%0], %1;" ::"r"(there), "f"(value)
               : "memory");
}

__device__ float load_volatile(std::uint32_t here) {
  float value;
  asm volatile("ld.volatile.shared.f32 %0, [%1];" : "=f"(value) : "r"(here) : "memory");
  return value;
}

__device__ void arrive_remote(std::uint32_t barrier_there) {
  asm volatile("mbarrier.arrive.release.cluster.shared::cluster.b64 _, [%0];" ::"r"(barrier_there)
               : "memory");
}

__device__ std::uint32_t load_remote(std::uint32_t there) {
  std::uint32_t value;
  asm volatile("ld.relaxed.cluster.shared::cluster.u32 %0, [%1];"
               : "=r"(value)
               : "r"(there)
               : "memory");
  return value;
}

// The first block and the last pass the turn to and fro.
template <Way kWay>
__device__ std::uint32_t pass_turns(std::uint32_t slot, std::uint32_t barrier) {
  const std::uint32_t block = cuda::block_of_cluster();
  const std::uint32_t other = block == 0 ? kBlocks - 1 : 0;
  const std::uint32_t slot_there = cuda::address_in(other, slot);
  const std::uint32_t barrier_there = cuda::address_in(other, barrier);
  std::uint32_t parity = 0, loaded = 0;
  for (int turn = 0; turn < kHandovers; ++turn) {
    const bool sends = (turn % 2 == 0) == (block == 0);
    const float value = static_cast<float>(turn + 1);
    if constexpr (kWay == Way::message) {
      if (sends) {
        cuda::send_if(true, slot_there, {value, value, value, value}, barrier_there);
      } else {
        cuda::arm(barrier, 16);
        cuda::wait_for(barrier, parity);
        parity ^= 1;
      }
    } else if constexpr (kWay == Way::remote_store) {
      if (sends) {
        store_remote(slot_there, value);
      } else {
        while (load_volatile(slot) != value) {
        }
      }
    } else if constexpr (kWay == Way::remote_arrival) {
      if (sends) {
        arrive_remote(barrier_there);
      } else {
        cuda::wait_for(barrier, parity);
        parity ^= 1;
      }
    } else {  // each load's address follows from the one before, which brought a zero
      loaded = load_remote(slot_there + loaded);
    }
  }
  return loaded;
}

#endif

template <Way kWay>
__global__ void hand_over(std::uint32_t* sink) {
#if defined(PBDSURG_CUDA_HAS_CLUSTERS)
  __shared__ float4 slot;
  __shared__ std::uint64_t barrier;
  if (threadIdx.x == 0) {
    slot = make_float4(0, 0, 0, 0);
    cuda::make_barrier(cuda::shared_address(&barrier));
    cuda::publish_barriers();
  }
  __syncthreads();
  cuda::meet_cluster();
  if constexpr (kWay == Way::cluster_barrier) {
    for (int turn = 0; turn < kHandovers; ++turn) {
      cuda::meet_cluster();
    }
  } else if constexpr (kWay == Way::block_barrier) {
    for (int turn = 0; turn < kHandovers; ++turn) {
      __syncthreads();
    }
  } else {
    const std::uint32_t block = cuda::block_of_cluster();
    if (threadIdx.x == 0 && (block == 0 || (block == kBlocks - 1 && kWay != Way::remote_load))) {
      *sink = pass_turns<kWay>(cuda::shared_address(&slot), cuda::shared_address(&barrier));
    }
  }
  cuda::meet_cluster();
#else
  *sink = 0;
#endif
}

// The first block and the last write to each other through the memory that all blocks share.
__global__ void write_letters(std::uint64_t* letters) {
  const bool is_first = blockIdx.x == 0;
  if (threadIdx.x > 0 || (!is_first && blockIdx.x != gridDim.x - 1)) {
    return;
  }
  std::uint64_t* const there = letters + (is_first ? 16 : 0);  // in lines of their own
  const std::uint64_t* const here = letters + (is_first ? 0 : 16);
  for (std::uint64_t turn = 1; turn <= kHandovers; ++turn) {
    if ((turn % 2 == 1) == is_first) {
      asm volatile("st.relaxed.gpu.global.u64 [%0], %1;" ::"l"(there), "l"(turn) : "memory");
    } else {
      std::uint64_t read = 0;
      while (read != turn) {
        asm volatile("ld.relaxed.gpu.global.u64 %0, [%1];" : "=l"(read) : "l"(here) : "memory");
      }
    }
  }
}

__global__ void do_nothing() {}

// Milliseconds of what is enqueued, by the device's clock.
template <class Enqueue>
double device_ms(const Stream& stream, Enqueue enqueue) {
  cudaEvent_t start, end;
  PBDSURG_CUDA_CHECK(cudaEventCreate(&start));
  PBDSURG_CUDA_CHECK(cudaEventCreate(&end));
  PBDSURG_CUDA_CHECK(cudaEventRecord(start, stream.get()));
  enqueue();
  PBDSURG_CUDA_CHECK(cudaEventRecord(end, stream.get()));
  PBDSURG_CUDA_CHECK(cudaEventSynchronize(end));
  float ms = 0;
  PBDSURG_CUDA_CHECK(cudaEventElapsedTime(&ms, start, end));
  PBDSURG_CUDA_CHECK(cudaEventDestroy(start));
  PBDSURG_CUDA_CHECK(cudaEventDestroy(end));
  return ms;
}

void report(benchmark::State& state, double ms, int count) {
  state.SetIterationTime(1e-3 * ms);
  state.counters["ns_each"] = 1e6 * ms / count;
}

template <Way kWay>
void within_a_cluster(benchmark::State& state) {
  const Stream stream;
  DeviceBuffer<std::uint32_t> sink;
  cudaLaunchConfig_t config{};
  config.gridDim = kBlocks;
  config.blockDim = kThreads;
  config.stream = stream.get();
  cudaLaunchAttribute attribute{};
  attribute.id = cudaLaunchAttributeClusterDimension;
  attribute.val.clusterDim = {kBlocks, 1, 1};
  config.attrs = &attribute;
  config.numAttrs = 1;
  const auto launch = [&] {
    PBDSURG_CUDA_CHECK(cudaLaunchKernelEx(&config, hand_over<kWay>, sink.reserve(1)));
  };
  PBDSURG_CUDA_CHECK(
      cudaFuncSetAttribute(hand_over<kWay>, cudaFuncAttributeNonPortableClusterSizeAllowed, 1));
  device_ms(stream, launch);  // brings the kernel to the device
  for (auto _ : state) {
    report(state, device_ms(stream, launch), kHandovers);
  }
}

void letters_between_blocks(benchmark::State& state) {
  const Stream stream;
  DeviceBuffer<std::uint64_t> letters;
  constexpr std::size_t kCount = 32;
  std::uint64_t* const start = letters.reserve(kCount);
  int blocks = 0;  // one for each multiprocessor
  PBDSURG_CUDA_CHECK(cudaDeviceGetAttribute(&blocks, cudaDevAttrMultiProcessorCount, 0));
  const auto launch = [&] {
    PBDSURG_CUDA_CHECK(cudaMemsetAsync(start, 0, kCount * sizeof(std::uint64_t), stream.get()));
    void* arguments[] = {const_cast<std::uint64_t**>(&start)};
    PBDSURG_CUDA_CHECK(cudaLaunchCooperativeKernel(reinterpret_cast<const void*>(&write_letters),
                                                   blocks, kThreads, arguments, 0, stream.get()));
  };
  device_ms(stream, launch);
  for (auto _ : state) {
    report(state, device_ms(stream, launch), kHandovers);
  }
}

void launches_on_a_stream(benchmark::State& state) {
  const Stream stream;
  for (auto _ : state) {
    report(state,
           device_ms(stream,
                     [&] {
                       for (int i = 0; i < kLaunches; ++i) {
                         do_nothing<<<1, 32, 0, stream.get()>>>();
                       }
                       PBDSURG_CUDA_CHECK(cudaGetLastError());
                     }),
           kLaunches);
  }
}

void nodes_of_a_graph(benchmark::State& state) {
  const Stream stream;
  cudaGraph_t graph;
  cudaGraphExec_t executable;
  PBDSURG_CUDA_CHECK(cudaStreamBeginCapture(stream.get(), cudaStreamCaptureModeThreadLocal));
  for (int i = 0; i < kLaunches; ++i) {
    do_nothing<<<1, 32, 0, stream.get()>>>();
  }
  PBDSURG_CUDA_CHECK(cudaStreamEndCapture(stream.get(), &graph));
  PBDSURG_CUDA_CHECK(cudaGraphInstantiate(&executable, graph, 0));
  const auto launch = [&] { PBDSURG_CUDA_CHECK(cudaGraphLaunch(executable, stream.get())); };
  device_ms(stream, launch);
  for (auto _ : state) {
    report(state, device_ms(stream, launch), kLaunches);
  }
  PBDSURG_CUDA_CHECK(cudaGraphExecDestroy(executable));
  PBDSURG_CUDA_CHECK(cudaGraphDestroy(graph));
}

void register_all(bool has_clusters) {
  const auto add = [](const char* name, void (*function)(benchmark::State&)) {
    benchmark::RegisterBenchmark(name, function)->UseManualTime()->Unit(benchmark::kMillisecond);
  };
  add("launch_on_a_stream", launches_on_a_stream);
  add("node_of_a_graph", nodes_of_a_graph);
  add("letter_to_another_block", letters_between_blocks);
  if (has_clusters) {
    add("barrier_of_a_cluster", within_a_cluster<Way::cluster_barrier>);
    add("message_to_another_block", within_a_cluster<Way::message>);
    add("store_to_another_block", within_a_cluster<Way::remote_store>);
    add("arrival_on_another_block's_barrier", within_a_cluster<Way::remote_arrival>);
    add("load_from_another_block", within_a_cluster<Way::remote_load>);
    add("barrier_of_a_block", within_a_cluster<Way::block_barrier>);
  }
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  const pbdsurg::cuda::DeviceList devices = pbdsurg::cuda::find_devices();
  if (devices.devices.empty()) {
    std::printf("no benchmark: %s\n", devices.reason.c_str());
    return 0;
  }
  pbdsurg::bench::register_all(devices.devices.front().supports_clusters);
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) {
    return 1;
  }
  benchmark::RunSpecifiedBenchmarks();
}
