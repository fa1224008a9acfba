// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/sweeps.h"
#include "lib/device/neighbor_lists.h"

namespace pbdsurg::cuda {
namespace {

class CooperativeSweeps final : public Sweeps {
 public:
  explicit CooperativeSweeps(const SolverData& data)
      : kernels_(kernels_of(data.options)), over_relaxation_(data.options.over_relaxation) {}

  bool take_over(const SolverData& data, std::span<const Stage> stages,
                 const StageRecords& /*records*/, cudaStream_t stream) override {
    const bool has_others = std::ranges::any_of(
        stages, [](const Stage& stage) { return stage.kind != PhaseKind::vertex; });
    const VertexBlocks::Arrays rows = data.vertex_blocks.arrays();
    if (has_others || stages.empty() || stages.size() > VertexColors::kMost ||
        data.options.iterations > VertexRecords::kMostSweeps) {
      return false;
    }
    const NeighborLists lists(data.vertex_blocks);
    records_.longest_list = lists.longest;
    const auto copies = data.copy_count();
    block_count_ = lists.longest <= VertexRecords::kMostNeighbors
                       ? kernels_.prepare_sweep_of_vertices(records_) / copies
                       : 0;
    if (block_count_ == 0) {
      return false;
    }
    const auto row_copies = static_cast<std::size_t>(data.vertex_blocks.has_damping() ? copies : 1);
    records_.lists = ranges_.upload(lists.ranges, stream);
    records_.neighbors = neighbors_.upload(lists.neighbors, stream);
    records_.pulls = pulls_.reserve(rows.pulls.size() * kBlockLanes);
    records_.springs = springs_.reserve(row_copies * rows.springs.size() * kBlockLanes);
    records_.volumes = volumes_.reserve(row_copies * rows.volumes.size() * kBlockLanes);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the lists end here
    return true;
  }

  void follow_rows(const VertexArrays& vertices, const Launch& launch) override {
    kernels_.pack_rows(vertices, records_, false, launch);
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    if (arrays.vertices.is_damped) {
      kernels_.pack_rows(arrays.vertices, records_, true, launch);
    }
    VertexColors colors{};
    Index largest = 1;
    for (const Stage& stage : arrays.stages) {
      colors.blocks[colors.count++] = {stage.first, stage.count};
      largest = std::max(largest, stage.count);
    }
    const VertexSweeps sweeps{substep, arrays.sweep_count, over_relaxation_, arrays.has_tools(),
                              std::min(block_count_, kernels_.thread_blocks_for(largest))};
    kernels_.sweep_vertices(sweeps, colors, arrays.state, arrays.vertices, records_, arrays.tools,
                            arrays.input, launch);
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return ranges_.memory_bytes() + neighbors_.memory_bytes() + pulls_.memory_bytes() +
           springs_.memory_bytes() + volumes_.memory_bytes();
  }

 private:
  const StepKernels& kernels_;
  float over_relaxation_;
  Index block_count_ = 0;  // of threads, at once, for each copy
  VertexRecords records_{};
  DeviceBuffer<RowRange> ranges_;
  DeviceBuffer<Neighbor> neighbors_;
  DeviceBuffer<PullRecord> pulls_;
  DeviceBuffer<SpringRecord> springs_;
  DeviceBuffer<VolumeRecord> volumes_;
};

}  // namespace

std::unique_ptr<Sweeps> make_cooperative_sweeps(const SolverData& data) {
  return std::make_unique<CooperativeSweeps>(data);
}

}  // namespace pbdsurg::cuda
