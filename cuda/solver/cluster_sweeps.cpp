// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>
#include <vector>

#include "cuda/buffer.cuh"
#include "cuda/solver/sweeps.h"
#include "lib/device/cluster_program.h"

namespace pbdsurg::cuda {
namespace {

// Beyond, the whole device does more than the sixteen multiprocessors of a cluster.
constexpr Index kMostConstraints = 800'000;

// Without records for constraints to come.
Index count_constraints(std::span<const Stage> stages) {
  return std::accumulate(stages.begin(), stages.end(), Index{0}, [](Index sum, const Stage& stage) {
    return sum + stage.count - stage.spare;
  });
}

Index count_phases(std::span<const Stage> stages) {
  return static_cast<Index>(
      std::ranges::count_if(stages, [](const Stage& stage) { return stage.count > stage.spare; }));
}

// The vertices that the solver began with are ordered, and those of each body that came later;
// those of cuts are not.
std::vector<PlaceRun> find_ordered_places(const SolverData& data) {
  const std::span<const Body> bodies = data.tissue->bodies();
  const Index first = bodies.empty() ? 0 : data.tissue->first_later_vertex(0);
  std::vector<PlaceRun> ordered{{0, first}};
  for (const Body& body : bodies) {
    if (body.first_vertex >= first) {
      ordered.push_back({body.first_vertex, body.vertex_count});
    }
  }
  return ordered;
}

// How long a phase takes, in the time that a block takes for one more constraint, some 2 ns; fitted
// to the meshes of table 2 on an H200.
Index phase_time(Index phase_size, Index block_count) {
  constexpr Index kMeeting = 150;  // of a block's threads, and what cannot be done side by side
  constexpr Index kMessage = 60;   // between blocks
  return kMeeting + (block_count > 1 ? kMessage : 0) + phase_size / block_count;
}

// Whether a plan has records for constraints to come: then a program has room for them.
bool has_spare_records(const StageRecords& records) {
  const auto is_spare = [](const auto& record) { return record.places[0] < 0; };
  bool is_any = false;
  records.for_each_list([&](const auto& list) { is_any |= std::ranges::any_of(list, is_spare); });
  return is_any;
}

// Who projects a kind.
template <class Constraint>
constexpr ClusterTissue tissue_of() {
  constexpr PhaseKind kPhase = KindOf<Constraint>::kPhase;
  return kPhase == PhaseKind::membrane || kPhase == PhaseKind::fibre ? ClusterTissue::all
         : KindOf<Constraint>::kHasFraction                          ? ClusterTissue::springs
                                                                     : ClusterTissue::solids;
}

class ClusterSweeps final : public Sweeps {
 public:
  explicit ClusterSweeps(const SolverData& data) : kernels_(kernels_of(data.options)) {
    kind_.mode = data.options.mode;
    kind_.is_damped = data.sets.has_damping && kind_.mode == ProjectionMode::compliance;
    data.sets.for_each_set([&]<class Constraint>(const ConstraintSlots<Constraint>& slots) {
      if (slots.group_count() > 0) {
        kind_.tissue = std::max(kind_.tissue, tissue_of<Constraint>());
      }
    });
    has_one_sweep_ = data.options.iterations == 1;
  }

  bool take_over(const SolverData& data, std::span<const Stage> stages, const StageRecords& records,
                 cudaStream_t stream) override {
    constexpr std::array kRooms{GrowthRoom::ample, GrowthRoom::some};
    constexpr std::array kNoRoom{GrowthRoom::none};
    if (!(has_spare_records(records) && choose_program(data, stages, records, kRooms)) &&
        !choose_program(data, stages, records, kNoRoom)) {
      return false;
    }
    upload(data.copy_count(), stream);
    return true;
  }

  bool follow(const SolverData& data, std::span<const Stage> /*stages*/,
              std::vector<WordChange>& words) override {
    return program_->follow(words, static_cast<Index>(data.particles.size()));
  }

  [[nodiscard]] std::uint32_t* start(DeviceArray array) const noexcept override {
    return array == DeviceArray::cluster ? image_.get() : nullptr;
  }

  void enqueue(const SweepArrays& arrays, Index substep, const Launch& launch) override {
    ClusterKind kind = kind_;
    kind.has_extra_phases = arrays.has_grips || arrays.has_touches;
    kernels_.sweep_cluster(kind, arrays_, arrays.state, arrays.tools, arrays.input,
                           {substep, arrays.sweep_count, arrays.has_attachments, arrays.has_pushers,
                            arrays.has_meeters, arrays.has_grips, arrays.has_touches},
                           launch);
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept override {
    return image_.memory_bytes() + multipliers_.memory_bytes();
  }

 private:
  // The fastest, of as many blocks as it takes; of those that are as fast, the first.
  bool choose_program(const SolverData& data, std::span<const Stage> stages,
                      const StageRecords& records, std::span<const GrowthRoom> rooms) {
    const Index phase_size = count_constraints(stages) / std::max(count_phases(stages), 1);
    std::vector<Index> sizes;
    for (Index size = kMostClusterBlocks; size >= 1; size /= 2) {
      sizes.push_back(size);
    }
    std::ranges::stable_sort(sizes, {}, [&](Index size) { return phase_time(phase_size, size); });
    program_.reset();
    const auto place_count = static_cast<Index>(data.place_of_vertex.size());
    const std::vector<PlaceRun> ordered = find_ordered_places(data);
    Index best_time = std::numeric_limits<Index>::max();
    for (const Index size : sizes) {
      for (const GrowthRoom room : rooms) {
        auto candidate = ClusterProgram::make(stages, records, place_count, ordered, size,
                                              kind_.is_damped, room);
        const Index at_a_time = candidate ? prepare(candidate->sizes()) : 0;
        if (at_a_time == 0) {
          continue;  // such as too many vertices for the shared memory of so few blocks
        }
        const Index waves = (data.copy_count() - 1) / at_a_time + 1;
        const Index time = waves * phase_time(phase_size, size);
        if (time < best_time) {
          best_time = time;
          program_ = std::move(candidate);
        }
        if (waves == 1) {
          return true;  // no other is faster
        }
      }
    }
    return program_.has_value();
  }

  // How many clusters run at a time, with extra phases, which may begin at any time, or without.
  Index prepare(const ClusterSizes& sizes) {
    kind_.thread_count = sizes.thread_count;
    ClusterKind extra = kind_;
    extra.has_extra_phases = true;
    const ClusterArrays arrays = arrays_of(sizes);
    return std::min(kernels_.prepare_cluster(kind_, arrays),
                    kernels_.prepare_cluster(extra, arrays));
  }

  void upload(Index copies, cudaStream_t stream) {
    const ClusterSizes& sizes = program_->sizes();
    const ClusterSections sections(sizes);
    kind_.thread_count = sizes.thread_count;
    std::uint32_t* const image = image_.upload(program_->image(), stream);
    arrays_ = arrays_of(sizes);
    arrays_.blocks = reinterpret_cast<const ClusterBlock*>(image + sections.blocks);
    arrays_.places = reinterpret_cast<const Index*>(image + sections.places);
    arrays_.rounds = reinterpret_cast<const ClusterRound*>(image + sections.rounds);
    arrays_.arrivals = image + sections.arrivals;
    arrays_.homes = image + sections.homes;
    arrays_.words = reinterpret_cast<const Word128*>(image + sections.words);
    arrays_.multipliers =
        multipliers_.reserve(static_cast<std::size_t>(copies) * arrays_.multiplier_count);
    PBDSURG_CUDA_CHECK(cudaStreamSynchronize(stream));  // edits change the program
  }

  // All but the pointers.
  [[nodiscard]] ClusterArrays arrays_of(const ClusterSizes& sizes) const {
    const bool remembers = kind_.mode == ProjectionMode::compliance && !has_one_sweep_;
    ClusterArrays arrays{};
    arrays.multiplier_count = remembers ? sizes.multiplier_room : 0;
    arrays.block_count = static_cast<std::uint32_t>(sizes.block_count);
    arrays.phase_count = static_cast<std::uint32_t>(sizes.phase_count);
    arrays.slot_room = static_cast<std::uint32_t>(sizes.slot_room);
    arrays.round_room = static_cast<std::uint32_t>(sizes.round_room);
    // whole warps load, some of them more than there is: that must not reach into the next stage
    constexpr Index kLoadedTogether = 32;
    const Index stage_words = std::max(sizes.round_words + kLoadedTogether, sizes.thread_count);
    arrays.stage_bytes = static_cast<std::uint32_t>(stage_words * sizeof(Word128));
    return arrays;
  }

  const StepKernels& kernels_;
  ClusterKind kind_{};
  bool has_one_sweep_ = false;  // in each substep
  std::optional<ClusterProgram> program_;
  ClusterArrays arrays_{};
  DeviceBuffer<std::uint32_t> image_;
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
