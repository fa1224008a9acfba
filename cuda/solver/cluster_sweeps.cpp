// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <numeric>
#include <optional>

#include "device_buffer.cuh"
#include "solver/cluster_program.h"
#include "solver/sweeps.h"

namespace pbdsurg::cuda {
namespace {

// A phase gives each warp of a block this many constraints or more, or the cluster is smaller:
// more blocks exchange more vertices.
constexpr Index kLeastShare = 32;

// Beyond, the whole device does more than the sixteen multiprocessors of a cluster.
constexpr Index kMostConstraints = 800'000;

Index count_constraints(std::span<const Stage> stages) {
  return std::accumulate(stages.begin(), stages.end(), Index{0},
                         [](Index sum, const Stage& stage) { return sum + stage.count; });
}

class ClusterSweeps final : public Sweeps {
 public:
  explicit ClusterSweeps(const SolverData& data)
      : kernels_(data.options.math == MathMode::strict ? strict_kernels : fast_kernels) {
    kind_.mode = data.options.mode;
    kind_.is_damped = data.has_damping && kind_.mode == ProjectionMode::compliance;
    kind_.has_solids = data.neo_hookeans.group_count() > 0;
    sweep_count_ = data.options.iterations;
  }

  [[nodiscard]] const char* name() const noexcept override { return "cluster"; }

  bool take_over(const SolverData& data, std::span<const Stage> stages, const StageRecords& records,
                 cudaStream_t stream) override {
    const auto place_count = static_cast<Index>(data.particles.size());
    const Index phase_size =
        count_constraints(stages) / std::max(static_cast<Index>(stages.size()), 1);
    Index block_count = kMostClusterBlocks;
    while (block_count > 1 && phase_size < kLeastShare * block_count) {
      block_count /= 2;
    }
    for (; block_count >= 1; block_count /= 2) {
      records_ = {};
      const std::optional<ClusterProgram> program =
          records_.make_program(stages, records, place_count, block_count, kind_.is_damped);
      if (!program) {
        return false;
      }
      upload(*program, stream);
      if (kernels_.prepare_cluster(kind_, arrays_)) {
        return true;
      }
    }
    return false;
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
  void upload(const ClusterProgram& program, cudaStream_t stream) {
    kind_.thread_count = program.thread_count;
    const bool remembers = kind_.mode == ProjectionMode::compliance && sweep_count_ > 1;
    arrays_ = {blocks_.upload(program.blocks, stream),
               places_.upload(program.places, stream),
               rounds_.upload(program.rounds, stream),
               arrivals_.upload(program.arrivals, stream),
               homes_.upload(program.homes, stream),
               words_.upload(program.words, stream),
               multipliers_.reserve(remembers ? program.multiplier_count : 0),
               static_cast<std::uint32_t>(program.blocks.size()),
               static_cast<std::uint32_t>(program.phase_count),
               static_cast<std::uint32_t>(program.most_slots),
               static_cast<std::uint32_t>(program.most_rounds),
               static_cast<std::uint32_t>(program.most_words * sizeof(Word128))};
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // the program goes
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
