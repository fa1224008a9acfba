// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/sweep_answers.h"
#include "cuda/solver/sweeps.h"
#include "lib/device/neighbor_lists.h"
#include "lib/device/vertex_counts.h"
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
    if (!can_sweep(stages) || data.options.iterations > kMostSweeps) {
      return false;
    }
    const NeighborLists lists(data.vertex_blocks);
    const auto copies = data.copy_count();
    if (lists.longest > TileArrays::kMostNeighbors) {
      return false;
    }
    tiles_.parts = is_explicit_ ? kRowParts : parts_for(data, stages);
    make_tiles(data, lists);
    // a vertex whose warp keeps it is faster than one that shares a warp with others by turns
    while (is_explicit_ && !stays() && tiles_.parts > kFewParts &&
           data.options.math == MathMode::fast) {
      tiles_.parts /= 2;
      make_tiles(data, lists);
    }
    if (block_count_ == 0) {
      return false;
    }
    copy_count_ = static_cast<std::size_t>(copies);
    row_copies_ = data.vertex_blocks.has_damping() ? copy_count_ : 1;
    const auto growth = data.vertex_blocks.expected_growth(data.options.spare);
    set_room(tiles_now().with(
                 [&](std::size_t count) { return count * growth.blocks / layout_.blocks.size(); }),
             stream);
    blocks_.upload(layout_.blocks, stream);
    neighbors_.upload(layout_.neighbors, stream);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the neighbours end here
    layout_.neighbors = {};
    unpacked_.reserve(kUsualBlocks);
    return true;
  }

  bool follow(const SolverData& data, std::span<const Stage> stages,
              std::vector<WordChange>& words) override {
    vertex_blocks_ = data.vertex_blocks.block_count();
    if (!can_sweep(stages) || !layout_.follow(data.vertex_blocks, data.changes, words)) {
      return false;
    }
    if (layout_.most_neighbors > tiles_.most_neighbors ||
        VertexCounts(data).has_rare_rows() != tiles_.has_rare_rows) {
      prepare(data);
      has_other_kernels_ = true;
    }
    return block_count_ > 0;
  }

  void follow_rows(const VertexArrays& vertices, const Launch& launch) override {
    const std::vector<Index> changed = layout_.take_unpacked();
    if (are_all_unpacked_) {
      kernels_.pack_rows(vertices, tiles_, nullptr, vertices.block_count, launch);
    } else if (!changed.empty()) {
      Index* const which = unpacked_.reserve(std::bit_ceil(changed.size()));
      std::ranges::copy(changed, which);
      kernels_.pack_rows(vertices, tiles_, which, static_cast<Index>(changed.size()), launch);
    }
    are_all_unpacked_ = false;
  }

  [[nodiscard]] std::uint32_t* start(DeviceArray array) const noexcept override {
    if (array == DeviceArray::tile_blocks) {
      return reinterpret_cast<std::uint32_t*>(blocks_.get());
    }
    return array == DeviceArray::tile_neighbors ? neighbors_.get() : nullptr;
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    if (arrays.vertices.is_damped) {
      kernels_.pack_numbers(arrays.vertices, tiles_, launch);
    }
    const Reach reach = arrays.has_touches   ? Reach::met_substep
                        : arrays.has_grips   ? Reach::gripped_substep
                        : arrays.has_tools() ? Reach::held_substep
                                             : Reach::substep;
    // nothing comes between sweeps that are launched together: see answer_sweep()
    for (Index first = 0; first < arrays.sweep_count;) {
      const bool is_alone = arrays.has_touches || arrays.has_grips || arrays.has_meeters ||
                            (first == 0 && arrays.has_correction());
      const Index end = is_alone ? first + 1 : arrays.sweep_count;
      sweep(reach, arrays, substep, {first, end}, launch);
      answer_sweep(kernels_, arrays, substep, first == 0, launch, [&] { correct(arrays, launch); });
      first = end;
    }
  }

  // Tools need contacts found in each substep, damping its rows written, and so on: then there is a
  // launch for each part of it. One substep alone is faster without the ends of a step.
  [[nodiscard]] bool takes_whole_step(const SweepArrays& arrays, int substeps,
                                      bool changes_lengths) const override {
    return !arrays.has_tools() &&
           (is_explicit_ || (substeps > 1 && !changes_lengths && !arrays.vertices.is_damped &&
                             arrays.state.ways == nullptr && arrays.free_pieces.count == 0 &&
                             !arrays.has_correction()));
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
      sweep(Reach::step, arrays, 0, {0, arrays.sweep_count}, launch);
    }
  }

  bool make_room(std::size_t vertices, cudaStream_t stream) override {
    odd_points_.reserve(copy_count_ * vertices);
    const bool has_other_tiles = make_room_for_tiles(stream);
    return std::exchange(has_other_kernels_, false) || has_other_tiles;
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return odd_points_.memory_bytes() + blocks_.memory_bytes() + neighbors_.memory_bytes() +
           pulls_.memory_bytes() + springs_.memory_bytes() + volumes_.memory_bytes();
  }

 private:
  void correct(const SweepArrays& arrays, const Launch& launch) const {
    find_residuals(arrays, launch);
    kernels_.move_by_modes(arrays.state, arrays.coarse, arrays.input, arrays.has_tools(), launch);
    find_residuals(arrays, launch);
    kernels_.turn_back_moves(arrays.state, arrays.coarse, arrays.input, launch);
  }

  void find_residuals(const SweepArrays& arrays, const Launch& launch) const {
    kernels_.find_residuals_by_tiles(arrays.state, arrays.vertices, tiles_, arrays.coarse,
                                     arrays.input, arrays.has_tools(), launch);
  }

  struct SweepRange {
    Index first, end;
  };

  void sweep(Reach reach, const SweepArrays& arrays, Index substep, const SweepRange& range,
             const Launch& launch) const {
    VertexColors colors{};
    Index largest = 1;
    for (const Stage& stage : arrays.stages) {
      colors.blocks[colors.count++] = {stage.first, stage.count};
      largest = std::max(largest, stage.count);
    }
    kernels_.sweep_vertices({reach, substep, arrays.sweep_count, range.first, range.end,
                             over_relaxation_, thread_blocks_for(largest)},
                            colors, arrays.state, arrays.vertices, tiles_, arrays.tools,
                            mailboxes(arrays), arrays.input, launch);
  }

  [[nodiscard]] Mailboxes mailboxes(const SweepArrays& arrays) const {
    return {{arrays.state.fixed_points, odd_points_.get()}};
  }

  // With the room that a device has for them.
  void make_tiles(const SolverData& data, const NeighborLists& lists) {
    layout_ = VertexTiles(data.vertex_blocks, lists, tiles_.parts);
    vertex_blocks_ = data.vertex_blocks.block_count();
    prepare(data);
  }

  void prepare(const SolverData& data) {
    const auto prepare_kernels =
        is_explicit_ ? kernels_.prepare_explicit_step : kernels_.prepare_sweep_of_vertices;
    tiles_.most_neighbors = layout_.most_neighbors;
    tiles_.has_rare_rows = VertexCounts(data).has_rare_rows();
    block_count_ = prepare_kernels(tiles_) / data.copy_count();
    if (data.coarse_space.node_count() > 0 && kernels_.prepare_residuals(tiles_) == 0) {
      block_count_ = 0;
    }
  }

  [[nodiscard]] static bool can_sweep(std::span<const Stage> stages) {
    return !stages.empty() && stages.size() <= VertexColors::kMost &&
           std::ranges::all_of(stages,
                               [](const Stage& stage) { return stage.kind == PhaseKind::vertex; });
  }

  // Rows of an array, or blocks.
  struct TileRoom {
    std::size_t blocks = 0, neighbors = 0, pulls = 0, springs = 0, volumes = 0;

    [[nodiscard]] bool has_room_for(const TileRoom& other) const noexcept {
      return other.blocks <= blocks && other.neighbors <= neighbors && other.pulls <= pulls &&
             other.springs <= springs && other.volumes <= volumes;
    }
    // With more(count) of each.
    template <class More>
    [[nodiscard]] TileRoom with(const More& more) const {
      return {blocks + more(blocks), neighbors + more(neighbors), pulls + more(pulls),
              springs + more(springs), volumes + more(volumes)};
    }
  };

  [[nodiscard]] TileRoom tiles_now() const {
    const auto rows = [](Index count) { return static_cast<std::size_t>(count); };
    return {rows(layout_.most_blocks), rows(layout_.neighbor_rows), rows(layout_.pull_rows),
            rows(layout_.spring_rows), rows(layout_.volume_rows)};
  }

  // Whether there was too little room: then arrays are others, and records are to be packed anew.
  bool make_room_for_tiles(cudaStream_t stream) {
    if (room_.has_room_for(tiles_now())) {
      return false;
    }
    set_room(tiles_now().with(part_to_grow), stream);
    return true;
  }

  void set_room(const TileRoom& room, cudaStream_t stream) {
    const auto threads = [](std::size_t rows) { return rows * kTileThreads; };
    tiles_.blocks = blocks_.enlarge(1, room_.blocks, room.blocks, 0, stream);
    tiles_.neighbors =
        neighbors_.enlarge(1, threads(room_.neighbors), threads(room.neighbors), 0, stream);
    tiles_.pulls = pulls_.reserve(threads(room.pulls));
    tiles_.springs = springs_.reserve(threads(row_copies_ * room.springs));
    tiles_.volumes = volumes_.reserve(threads(row_copies_ * room.volumes));
    tiles_.spring_rows = static_cast<Index>(room.springs);
    tiles_.volume_rows = static_cast<Index>(room.volumes);
    room_ = room;
    are_all_unpacked_ = true;
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
  static constexpr std::size_t kUsualBlocks = 1024;  // that an edit touches

  const StepKernels& kernels_;
  float over_relaxation_;
  bool is_explicit_;
  std::size_t copy_count_ = 1, row_copies_ = 1;
  Index vertex_blocks_ = 0;
  VertexTiles layout_;
  TileRoom room_;
  bool are_all_unpacked_ = false, has_other_kernels_ = false;
  Index block_count_ = 0;  // of threads, at once, for each copy
  TileArrays tiles_{};
  DeviceBuffer<TileBlock> blocks_;
  DeviceBuffer<Neighbor> neighbors_;
  DeviceBuffer<PullRecord> pulls_;
  DeviceBuffer<SpringRecord> springs_;
  DeviceBuffer<VolumeRecord> volumes_;
  PinnedBuffer<Index> unpacked_;         // blocks
  DeviceBuffer<FixedPoint> odd_points_;  // [copy][capacity] see Mailboxes
};

}  // namespace

std::unique_ptr<Sweeps> make_cooperative_sweeps(const SolverData& data) {
  return std::make_unique<CooperativeSweeps>(data);
}

}  // namespace pbdsurg::cuda
