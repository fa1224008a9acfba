// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "buffer.cuh"
#include "solver/cluster_program.h"
#include "solver/sweeps.h"

namespace pbdsurg::cuda {
namespace {

// Beyond, the whole device does more than the sixteen multiprocessors of a cluster.
constexpr Index kMostConstraints = 800'000;

Index count_constraints(std::span<const Stage> stages) {
  return std::accumulate(stages.begin(), stages.end(), Index{0},
                         [](Index sum, const Stage& stage) { return sum + stage.count; });
}

// How long a phase takes, in the time that a block takes for one more constraint, some 2 ns; fitted
// to the meshes of table 2 on an H200.
Index phase_time(Index phase_size, Index block_count) {
  constexpr Index kMeeting = 150;  // of a block's threads, and what cannot be done side by side
  constexpr Index kMessage = 60;   // between blocks
  return kMeeting + (block_count > 1 ? kMessage : 0) + phase_size / block_count;
}

class ClusterSweeps final : public Sweeps {
 public:
  explicit ClusterSweeps(const SolverData& data) : kernels_(kernels_of(data.options)) {
    kind_.mode = data.options.mode;
    kind_.is_damped = data.has_damping && kind_.mode == ProjectionMode::compliance;
    kind_.has_solids = data.neo_hookeans.group_count() > 0;
    sweep_count_ = data.options.iterations;
  }

  bool take_over(const SolverData& data, std::span<const Stage> stages, const StageRecords& records,
                 cudaStream_t stream) override {
    const Index phase_size =
        count_constraints(stages) / std::max(static_cast<Index>(stages.size()), 1);
    std::vector<Index> sizes;
    for (Index size = kMostClusterBlocks; size >= 1; size /= 2) {
      sizes.push_back(size);
    }
    std::ranges::stable_sort(sizes, {}, [&](Index size) { return phase_time(phase_size, size); });
    std::optional<ClusterProgram> best;
    Index best_time = std::numeric_limits<Index>::max();
    for (const Index size : sizes) {
      ClusterRecords candidate;
      const auto program = candidate.make_program(
          stages, records, static_cast<Index>(data.place_of_vertex.size()), size, kind_.is_damped);
      const Index at_a_time = program ? prepare(*program) : 0;
      if (at_a_time == 0) {
        continue;  // such as too many vertices for the shared memory of so few blocks
      }
      const Index waves = (data.copy_count() - 1) / at_a_time + 1;
      const Index time = waves * phase_time(phase_size, size);
      if (time < best_time) {
        best_time = time;
        records_ = std::move(candidate);
        best = program;
      }
      if (waves == 1) {
        break;  // no other is faster
      }
    }
    if (!best) {
      return false;
    }
    upload(*best, data.copy_count(), stream);
    return true;
  }

  void follow(std::span<const WordChange> changes, std::vector<WordChange>& words) override {
    records_.follow(changes, words);
  }

  [[nodiscard]] std::uint32_t* words() const noexcept override {
    return reinterpret_cast<std::uint32_t*>(words_.get());
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    kernels_.sweep_cluster(kind_, arrays_, arrays.state, arrays.tools, arrays.input,
                           {substep, sweep_count_, arrays.has_attachments, arrays.has_pushers},
                           launch);
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return blocks_.memory_bytes() + places_.memory_bytes() + rounds_.memory_bytes() +
           arrivals_.memory_bytes() + homes_.memory_bytes() + words_.memory_bytes() +
           multipliers_.memory_bytes();
  }

 private:
  // How many clusters run at a time.
  Index prepare(const ClusterProgram& program) {
    kind_.thread_count = program.thread_count;
    return kernels_.prepare_cluster(kind_, sizes_of(program));
  }

  void upload(const ClusterProgram& program, Index copies, cudaStream_t stream) {
    kind_.thread_count = program.thread_count;
    arrays_ = sizes_of(program);
    arrays_.blocks = blocks_.upload(program.blocks, stream);
    arrays_.places = places_.upload(program.places, stream);
    arrays_.rounds = rounds_.upload(program.rounds, stream);
    arrays_.arrivals = arrivals_.upload(program.arrivals, stream);
    arrays_.homes = homes_.upload(program.homes, stream);
    arrays_.words = words_.upload(program.words, stream);
    arrays_.multipliers =
        multipliers_.reserve(static_cast<std::size_t>(copies) * arrays_.multiplier_count);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the program goes
  }

  [[nodiscard]] ClusterArrays sizes_of(const ClusterProgram& program) const {
    const bool remembers = kind_.mode == ProjectionMode::compliance && sweep_count_ > 1;
    ClusterArrays sizes{};
    sizes.multiplier_count = remembers ? program.multiplier_count : 0;
    sizes.block_count = static_cast<std::uint32_t>(program.blocks.size());
    sizes.phase_count = static_cast<std::uint32_t>(program.phase_count);
    sizes.slot_room = static_cast<std::uint32_t>(program.most_slots);
    sizes.round_room = static_cast<std::uint32_t>(program.most_rounds);
    // whole warps load, some of them more than there is: that must not reach into the next stage
    constexpr Index kLoadedTogether = 32;
    const Index stage_words = std::max(program.most_words + kLoadedTogether, program.thread_count);
    sizes.stage_bytes = static_cast<std::uint32_t>(stage_words * sizeof(Word128));
    return sizes;
  }

  const StepKernels& kernels_;
  ClusterKind kind_{};
  Index sweep_count_ = 0;
  ClusterRecords records_;
  ClusterArrays arrays_{};
  DeviceBuffer<ClusterBlock> blocks_;
  DeviceBuffer<Index> places_;
  DeviceBuffer<ClusterRound> rounds_;
  DeviceBuffer<std::uint32_t> arrivals_;
  DeviceBuffer<std::uint32_t> homes_;
  DeviceBuffer<Word128> words_;
  DeviceBuffer<float> multipliers_;
};

}  // namespace

bool is_for_cluster(std::span<const Stage> stages) noexcept {
  return count_constraints(stages) <= kMostConstraints;
}

std::unique_ptr<Sweeps> make_cluster_sweeps(const SolverData& data) {
  return std::make_unique<ClusterSweeps>(data);
}

}  // namespace pbdsurg::cuda
