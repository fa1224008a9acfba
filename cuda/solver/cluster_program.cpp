// SPDX-License-Identifier: Apache-2.0
#include "solver/cluster_program.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstring>

namespace pbdsurg::cuda {
namespace {

constexpr Index kNumbers = sizeof(Word128) / sizeof(std::uint32_t);

/// How a kind of constraint lies in its records and in the words of a cluster.
struct Shape {
  DeviceArray array;
  Index corner_count;
  Index parameter_count;  // after the places of a record
  Index record_size;      // numbers
  Index multiplier_count;

  // The first two parameters are in word 0. Damping is the last one of volumes, and left out where
  // nothing is damped.
  [[nodiscard]] Index packed_parameters(bool is_damped) const {
    return array == DeviceArray::volumes && !is_damped ? parameter_count - 1 : parameter_count;
  }
  [[nodiscard]] Index words(bool is_damped) const {
    return 1 + (std::max<Index>(packed_parameters(is_damped) - 2, 0) + kNumbers - 1) / kNumbers;
  }
};

template <class Record>
constexpr Index kSizeOf = sizeof(Record) / sizeof(float);

constexpr Shape kDistances{DeviceArray::distances, 2, 2, kSizeOf<DistanceRecord>, 1};
constexpr Shape kVolumes{DeviceArray::volumes, 4, 3, kSizeOf<VolumeRecord>, 1};
constexpr Shape kNeoHookeans{DeviceArray::neo_hookeans, 4, NeoHookeanConstraint::kParameterCount,
                             kSizeOf<NeoHookeanRecord>, NeoHookeanConstraint::kMultiplierCount};
constexpr Shape kStrainLimits{DeviceArray::strain_limits, 2, 1, kSizeOf<StrainLimitRecord>, 0};

/// Calls visit(shape, records) for a kind.
template <class Visit>
auto visit_kind(PhaseKind kind, const StageRecords& records, Visit visit) {
  switch (kind) {
    case PhaseKind::distance:
      return visit(kDistances, records.distances);
    case PhaseKind::volume:
      return visit(kVolumes, records.volumes);
    case PhaseKind::neo_hookean:
      return visit(kNeoHookeans, records.neo_hookeans);
    default:
      return visit(kStrainLimits, records.strain_limits);
  }
}

/// Null for what no cluster projects.
const Shape* shape_of(DeviceArray array) {
  for (const Shape* const shape : {&kDistances, &kVolumes, &kNeoHookeans, &kStrainLimits}) {
    if (shape->array == array) {
      return shape;
    }
  }
  return nullptr;
}

std::vector<SweepConstraint> places_of(const Stage& stage, const StageRecords& records) {
  return visit_kind(stage.kind, records, [&](const Shape&, const auto& all) {
    std::vector<SweepConstraint> constraints(static_cast<std::size_t>(stage.count));
    for (Index i = 0; i < stage.count; ++i) {
      constraints[i].places.fill(kInvalidIndex);
      std::ranges::copy(all[stage.first + i].places, constraints[i].places.begin());
    }
    return constraints;
  });
}

std::uint32_t& number(Word128& word, Index i) {
  std::uint32_t* const numbers[] = {&word.x, &word.y, &word.z, &word.w};
  return *numbers[i];
}

void append_vertices(const ScheduledBlock& block, std::uint32_t b, ClusterProgram& program) {
  for (Index slot = 0; slot < block.home_count; ++slot) {
    program.homes[block.places[slot]] = b << 16 | static_cast<std::uint32_t>(slot);
  }
  program.places.insert(program.places.end(), block.places.begin(), block.places.end());
  for (const Index arrivals : block.arrivals) {
    program.arrivals.push_back(static_cast<std::uint32_t>(arrivals) * sizeof(Word128));
  }
}

}  // namespace

std::optional<ClusterProgram> ClusterRecords::make_program(std::span<const Stage> stages,
                                                           const StageRecords& records,
                                                           Index place_count, Index block_count,
                                                           bool is_damped) {
  if (stages.empty() || static_cast<Index>(stages.size()) > kMostClusterPhases ||
      std::ranges::any_of(stages, [](const Stage& stage) {
        return stage.level_count > 0 || stage.kind == PhaseKind::joint;
      })) {
    return std::nullopt;
  }
  std::vector<std::vector<SweepConstraint>> phases;
  for (const Stage& stage : stages) {
    phases.push_back(places_of(stage, records));
  }
  is_damped_ = is_damped;
  const ClusterSchedule schedule(phases, place_count, block_count);
  ClusterProgram program;
  program.phase_count = static_cast<Index>(stages.size());
  std::size_t most = 0;
  for (const ScheduledBlock& block : schedule.blocks()) {
    program.most_slots = std::max(program.most_slots, static_cast<Index>(block.places.size()));
    for (const auto& constraints : block.constraints) {
      most = std::max(most, constraints.size());
    }
  }
  if (program.most_slots > static_cast<Index>(kSlotMask)) {
    return std::nullopt;
  }
  program.thread_count = most <= kFewClusterThreads ? kFewClusterThreads : kManyClusterThreads;
  for (const Stage& stage : stages) {
    visit_kind(stage.kind, records, [&](const Shape& shape, const auto& all) {
      locations_[static_cast<int>(shape.array)].resize(all.size());
    });
  }
  program.homes.resize(static_cast<std::size_t>(place_count));
  for (std::size_t b = 0; b < schedule.blocks().size(); ++b) {
    const std::size_t first_place = program.places.size();
    const std::size_t first_round = program.rounds.size();
    append_vertices(schedule.blocks()[b], static_cast<std::uint32_t>(b), program);
    for (Index phase = 0; phase < program.phase_count; ++phase) {
      append_phase(schedule, static_cast<Index>(b), phase, stages[phase], records, program);
    }
    const std::size_t round_count = program.rounds.size() - first_round;
    program.most_rounds = std::max(program.most_rounds, static_cast<Index>(round_count));
    program.blocks.push_back({static_cast<std::uint32_t>(first_place),
                              static_cast<std::uint32_t>(schedule.blocks()[b].home_count),
                              static_cast<std::uint32_t>(schedule.blocks()[b].places.size()),
                              static_cast<std::uint32_t>(first_round),
                              static_cast<std::uint32_t>(round_count)});
  }
  return program;
}

void ClusterRecords::append_phase(const ClusterSchedule& schedule, Index b, Index phase,
                                  const Stage& stage, const StageRecords& records,
                                  ClusterProgram& program) {
  visit_kind(stage.kind, records, [&](const Shape& shape, const auto& all) {
    const ScheduledBlock& block = schedule.blocks()[b];
    const auto& constraints = block.constraints[phase];
    const auto count = static_cast<Index>(constraints.size());
    const Index words = shape.words(is_damped_);
    auto& locations = locations_[static_cast<int>(shape.array)];
    // one round at least: each block waits for what comes to it in each phase
    for (Index first = 0; first == 0 || first < count; first += program.thread_count) {
      const Index size = std::min(program.thread_count, count - first);
      const Index border = std::clamp(block.border_counts[phase] - first, Index{0}, size);
      const std::size_t start = program.words.size();
      const std::size_t targets = start + static_cast<std::size_t>(size * words);
      program.rounds.push_back(
          {static_cast<std::uint32_t>(start), static_cast<std::uint32_t>(program.multiplier_count),
           static_cast<std::uint16_t>(size), static_cast<std::uint16_t>(border),
           static_cast<std::uint16_t>(phase), static_cast<std::uint8_t>(stage.kind),
           static_cast<std::uint8_t>(words)});
      program.multiplier_count += static_cast<std::size_t>(size * shape.multiplier_count);
      program.words.resize(targets + static_cast<std::size_t>(border));
      program.most_words = std::max(program.most_words, size * words + border);
      for (Index i = 0; i < size; ++i) {
        const Index constraint = constraints[first + i];
        const Index record = stage.first + constraint;
        const std::size_t here = start + static_cast<std::size_t>(i);
        locations[record] = {static_cast<std::uint32_t>(here), static_cast<std::uint32_t>(size)};
        Word128& head = program.words[here];
        for (Index corner = 0; corner < shape.corner_count; ++corner) {
          const VertexTarget& target = schedule.target(phase, constraint, corner);
          auto half = static_cast<std::uint32_t>(schedule.slot(phase, constraint, corner));
          if (target.block != b) {
            half |= kLeaves;
            number(program.words[targets + static_cast<std::size_t>(i)], corner) =
                pack_target(target.block, target.phase, target.slot);
          }
          number(head, corner / 2) |= half << (16 * (corner % 2));
        }
        if (stage.kind == PhaseKind::distance) {
          head.y = std::bit_cast<std::uint32_t>(records.distance_damping[record]);
        }
        std::array<std::uint32_t, sizeof all[0] / sizeof(std::uint32_t)> numbers;
        std::memcpy(numbers.data(), &all[record], sizeof all[0]);
        for (Index p = 0; p < shape.packed_parameters(is_damped_); ++p) {
          const Index at = p + 2;  // after the slots
          number(program.words[here + static_cast<std::size_t>(at / kNumbers * size)],
                 at % kNumbers) = numbers[shape.corner_count + p];
        }
      }
    }
  });
}

void ClusterRecords::follow(std::span<const WordChange> changes,
                            std::vector<WordChange>& words) const {
  for (const WordChange& change : changes) {
    const Shape* const shape = shape_of(change.array);
    if (shape == nullptr) {
      continue;
    }
    const Index record = static_cast<Index>(change.word) / shape->record_size;
    const Index field = static_cast<Index>(change.word) % shape->record_size;
    const Index parameter = field - shape->corner_count;
    const Location& location = locations_[static_cast<int>(change.array)][record];
    const auto write = [&](Index p, std::uint32_t value) {
      const auto at = static_cast<std::uint32_t>(p + 2);
      words.push_back({DeviceArray::cluster,
                       kNumbers * (location.word + at / kNumbers * location.stride) + at % kNumbers,
                       value});
    };
    if (field == 0 && static_cast<Index>(change.value) < 0) {
      write(0, kRemovedConstraint);
    } else if (parameter >= 0 && parameter < shape->packed_parameters(is_damped_)) {
      write(parameter, change.value);
    }
  }
}

}  // namespace pbdsurg::cuda
