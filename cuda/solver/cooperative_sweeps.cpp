// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/sweeps.h"
#include "lib/device/neighbor_lists.h"
#include "lib/device/vertex_tiles.h"
#include "lib/solver/methods/vertex_kernel.h"
#include "lib/solver/solver_options.h"

namespace pbdsurg::cuda {
namespace {

int multiprocessor_count() {
  int device = 0;
  int count = 0;
  PBDSURG_CUDA_CHECK(cudaGetDevice(&device));
  PBDSURG_CUDA_CHECK(cudaDeviceGetAttribute(&count, cudaDevAttrMultiProcessorCount, device));
  return count;
}

class CooperativeSweeps final : public Sweeps {
 public:
  explicit CooperativeSweeps(const SolverData& data)
      : kernels_(kernels_of(data.options)),
        over_relaxation_(data.options.over_relaxation),
        is_explicit_(is_explicit(data.options)) {}

  bool take_over(const SolverData& data, std::span<const Stage> stages,
                 const StageRecords& /*records*/, cudaStream_t stream) override {
    const bool has_others = std::ranges::any_of(
        stages, [](const Stage& stage) { return stage.kind != PhaseKind::vertex; });
    if (has_others || stages.empty() || stages.size() > VertexColors::kMost ||
        data.options.iterations > kMostSweeps) {
      return false;
    }
    const NeighborLists lists(data.vertex_blocks);
    const auto copies = data.copy_count();
    if (lists.longest > TileArrays::kMostNeighbors) {
      return false;
    }
    tiles_.parts = is_explicit_ ? kRowParts : parts_for(data, stages);
    VertexTiles tiles = make_tiles(data, lists);
    // a vertex whose warp keeps it is faster than one that shares a warp with others by turns
    while (is_explicit_ && !stays() && tiles_.parts > kFewParts &&
           data.options.math == MathMode::fast) {
      tiles_.parts /= 2;
      tiles = make_tiles(data, lists);
    }
    if (block_count_ == 0) {
      return false;
    }
    const auto records = [](Index rows, Index row_copies) {
      return static_cast<std::size_t>(rows) * static_cast<std::size_t>(row_copies) * kTileThreads;
    };
    const Index row_copies = data.vertex_blocks.has_damping() ? copies : 1;
    tiles_.blocks = blocks_.upload(tiles.blocks, stream);
    tiles_.neighbors = neighbors_.upload(tiles.neighbors, stream);
    tiles_.pulls = pulls_.reserve(records(tiles.pull_rows, 1));
    tiles_.springs = springs_.reserve(records(tiles.spring_rows, row_copies));
    tiles_.volumes = volumes_.reserve(records(tiles.volume_rows, row_copies));
    tiles_.spring_rows = tiles.spring_rows;
    tiles_.volume_rows = tiles.volume_rows;
    copy_count_ = static_cast<std::size_t>(copies);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the tiles end here
    return true;
  }

  void follow_rows(const VertexArrays& vertices, const Launch& launch) override {
    kernels_.pack_rows(vertices, tiles_, false, launch);
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    if (arrays.vertices.is_damped) {
      kernels_.pack_rows(arrays.vertices, tiles_, true, launch);
    }
    sweep(arrays.has_tools() ? Reach::held_substep : Reach::substep, arrays, substep, launch);
  }

  // Tools need contacts found in each substep, damping its rows written, and so on: then there is a
  // launch for each part of it. One substep alone is faster without the ends of a step.
  [[nodiscard]] bool takes_whole_step(const SweepArrays& arrays, int substeps) const override {
    return !arrays.has_tools() &&
           (is_explicit_ || (substeps > 1 && !arrays.vertices.is_damped &&
                             arrays.state.ways == nullptr && arrays.free_pieces.count == 0));
  }

  [[nodiscard]] Index moves_in_substep(const SweepArrays& arrays) const override {
    return is_explicit_ ? 1 : 1 + arrays.sweep_count;
  }

  void begin_steps(const SweepArrays& arrays, const Launch& launch) override {
    kernels_.fill_mailboxes(arrays.state, mailboxes(arrays), arrays.input, launch);
  }

  void enqueue_step(const SweepArrays& arrays, const Launch& launch) override {
    if (is_explicit_) {
      kernels_.step_explicitly({thread_blocks_for(vertex_blocks_), stays()}, arrays.state,
                               arrays.vertices, tiles_, mailboxes(arrays), arrays.input, launch);
    } else {
      sweep(Reach::step, arrays, 0, launch);
    }
  }

  void make_room(std::size_t vertices) override { odd_points_.reserve(copy_count_ * vertices); }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return odd_points_.memory_bytes() + blocks_.memory_bytes() + neighbors_.memory_bytes() +
           pulls_.memory_bytes() + springs_.memory_bytes() + volumes_.memory_bytes();
  }

 private:
  void sweep(Reach reach, const SweepArrays& arrays, Index substep, const Launch& launch) const {
    VertexColors colors{};
    Index largest = 1;
    for (const Stage& stage : arrays.stages) {
      colors.blocks[colors.count++] = {stage.first, stage.count};
      largest = std::max(largest, stage.count);
    }
    kernels_.sweep_vertices(
        {reach, substep, arrays.sweep_count, over_relaxation_, thread_blocks_for(largest)}, colors,
        arrays.state, arrays.vertices, tiles_, arrays.tools, mailboxes(arrays), arrays.input,
        launch);
  }

  [[nodiscard]] Mailboxes mailboxes(const SweepArrays& arrays) const {
    return {{arrays.state.fixed_points, odd_points_.get()}};
  }

  // With the room that a device has for them.
  VertexTiles make_tiles(const SolverData& data, const NeighborLists& lists) {
    VertexTiles tiles(data.vertex_blocks, lists, tiles_.parts);
    tiles_.most_neighbors = tiles.most_neighbors;
    vertex_blocks_ = data.vertex_blocks.block_count();
    const auto prepare =
        is_explicit_ ? kernels_.prepare_explicit_step : kernels_.prepare_sweep_of_vertices;
    block_count_ = prepare(tiles_) / data.copy_count();
    return tiles;
  }

  // Whether each tile of explicit steps has a warp of its own.
  [[nodiscard]] bool stays() const {
    return vertex_blocks_ * tiles_of_block(tiles_.parts) <=
           block_count_ * (kBlockThreads / kTileThreads);
  }

  // Threads of a vertex: many make a colour short where the device has room for all at once, few
  // make less work where it has not. Serial bits take as many as there are parts.
  static Index parts_for(const SolverData& data, std::span<const Stage> stages) {
    constexpr std::int64_t kWarpsAtOnce = 24;  // of a multiprocessor
    std::int64_t largest = 0;
    for (const Stage& stage : stages) {
      largest = std::max<std::int64_t>(largest, stage.count);
    }
    const std::int64_t warps = largest * tiles_of_block(kRowParts) * data.copy_count();
    const std::int64_t room = kWarpsAtOnce * multiprocessor_count();
    return data.options.math == MathMode::strict || warps <= room ? kRowParts
           : warps <= 4 * room                                    ? kRowParts / 2
                                                                  : kFewParts;
  }

  // Blocks of threads of a copy that move so many blocks of vertices side by side: no more than the
  // device has at once, and no more than their rounds need.
  [[nodiscard]] Index thread_blocks_for(Index blocks) const {
    constexpr auto kRoundUp = [](Index count, Index of) { return (count + of - 1) / of; };
    const Index tiles = blocks * tiles_of_block(tiles_.parts);
    const Index wanted = kRoundUp(tiles, kBlockThreads / kTileThreads);
    return kRoundUp(wanted, kRoundUp(wanted, block_count_));
  }

  static constexpr Index kFewParts = 4;
  // of a substep: counts of neighbours are to follow one another
  static constexpr Index kMostSweeps = TileArrays::kCountBits / 4;

  const StepKernels& kernels_;
  float over_relaxation_;
  bool is_explicit_;
  std::size_t copy_count_ = 1;
  Index vertex_blocks_ = 0;
  Index block_count_ = 0;  // of threads, at once, for each copy
  TileArrays tiles_{};
  DeviceBuffer<TileBlock> blocks_;
  DeviceBuffer<Neighbor> neighbors_;
  DeviceBuffer<PullRecord> pulls_;
  DeviceBuffer<SpringRecord> springs_;
  DeviceBuffer<VolumeRecord> volumes_;
  DeviceBuffer<FixedPoint> odd_points_;  // [copy][capacity] see Mailboxes
};

}  // namespace

std::unique_ptr<Sweeps> make_cooperative_sweeps(const SolverData& data) {
  return std::make_unique<CooperativeSweeps>(data);
}

}  // namespace pbdsurg::cuda
