// SPDX-License-Identifier: Apache-2.0
#include "solver/cluster_program.h"

#include <algorithm>
#include <bit>
#include <cstddef>

namespace pbdsurg::cuda {
namespace {

constexpr Index kNumbers = sizeof(Word128) / sizeof(std::uint32_t);

/// A constraint without its vertices, the same for all kinds.
struct Numbers {
  Index corner_count;
  std::vector<float> parameters;  // the first two go into word 0
  float damping = 0;              // in word 0, of constraints of two
};

template <std::size_t kCount>
void append_places(const Index (&places)[kCount], std::vector<SweepConstraint>& constraints) {
  SweepConstraint constraint;
  constraint.places.fill(kInvalidIndex);
  std::copy(std::begin(places), std::end(places), constraint.places.begin());
  constraints.push_back(constraint);
}

std::vector<SweepConstraint> places_of(const Stage& stage, const StageRecords& records) {
  std::vector<SweepConstraint> constraints;
  for (Index i = stage.first; i < stage.first + stage.count; ++i) {
    switch (stage.kind) {
      case PhaseKind::distance:
        append_places(records.distances[i].places, constraints);
        break;
      case PhaseKind::volume:
        append_places(records.volumes[i].places, constraints);
        break;
      case PhaseKind::neo_hookean:
        append_places(records.neo_hookeans[i].places, constraints);
        break;
      default:
        append_places(records.strain_limits[i].places, constraints);
        break;
    }
  }
  return constraints;
}

Numbers numbers_of(PhaseKind kind, Index record, const StageRecords& records, bool is_damped) {
  switch (kind) {
    case PhaseKind::distance: {
      const DistanceRecord& distance = records.distances[record];
      return {2, {distance.rest, distance.stiffness}, records.distance_damping[record]};
    }
    case PhaseKind::volume: {
      const VolumeRecord& volume = records.volumes[record];
      Numbers numbers{4, {volume.rest, volume.stiffness}};
      if (is_damped) {
        numbers.parameters.push_back(volume.damping);
      }
      return numbers;
    }
    case PhaseKind::neo_hookean: {
      const auto& parameters = records.neo_hookeans[record].parameters;
      return {4, {std::begin(parameters), std::end(parameters)}};
    }
    default:
      return {2, {records.strain_limits[record].limit, 0}};
  }
}

DeviceArray array_of(PhaseKind kind) {
  switch (kind) {
    case PhaseKind::distance:
      return DeviceArray::distances;
    case PhaseKind::volume:
      return DeviceArray::volumes;
    case PhaseKind::neo_hookean:
      return DeviceArray::neo_hookeans;
    default:
      return DeviceArray::strain_limits;
  }
}

Index words_of(PhaseKind kind, bool is_damped) {
  switch (kind) {
    case PhaseKind::volume:
      return is_damped ? 2 : 1;
    case PhaseKind::neo_hookean:
      return 1 + (NeoHookeanConstraint::kParameterCount - 2 + kNumbers - 1) / kNumbers;
    default:
      return 1;
  }
}

Index multipliers_of(PhaseKind kind) {
  return kind == PhaseKind::neo_hookean ? NeoHookeanConstraint::kMultiplierCount : 1;
}

std::uint32_t& number(Word128& word, Index i) {
  std::uint32_t* const numbers[] = {&word.x, &word.y, &word.z, &word.w};
  return *numbers[i];
}

/// How a kind's record lies, by words of 4 bytes.
struct RecordShape {
  Index size;
  Index corner_count;
  Index parameter_count;
};

RecordShape shape_of(DeviceArray array) {
  switch (array) {
    case DeviceArray::volumes:
      return {sizeof(VolumeRecord) / sizeof(float), 4, 3};
    case DeviceArray::neo_hookeans:
      return {sizeof(NeoHookeanRecord) / sizeof(float), 4, NeoHookeanConstraint::kParameterCount};
    case DeviceArray::strain_limits:
      return {sizeof(StrainLimitRecord) / sizeof(float), 2, 1};
    default:
      return {sizeof(DistanceRecord) / sizeof(float), 2, 2};
  }
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
    auto& locations = locations_[static_cast<int>(array_of(stage.kind))];
    locations.resize(
        std::max(locations.size(), static_cast<std::size_t>(stage.first + stage.count)));
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
  const ScheduledBlock& block = schedule.blocks()[b];
  const auto& constraints = block.constraints[phase];
  const auto count = static_cast<Index>(constraints.size());
  const Index words = words_of(stage.kind, is_damped_);
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
    program.multiplier_count += static_cast<std::size_t>(size * multipliers_of(stage.kind));
    program.words.resize(targets + static_cast<std::size_t>(border));
    program.most_words = std::max(program.most_words, size * words + border);
    for (Index i = 0; i < size; ++i) {
      const Index constraint = constraints[first + i];
      const Index record = stage.first + constraint;
      const Numbers numbers = numbers_of(stage.kind, record, records, is_damped_);
      const std::size_t here = start + static_cast<std::size_t>(i);
      locations_[static_cast<int>(array_of(stage.kind))][record] = {
          static_cast<std::uint32_t>(here), static_cast<std::uint32_t>(size)};
      Word128& head = program.words[here];
      for (Index corner = 0; corner < numbers.corner_count; ++corner) {
        const VertexTarget& target = schedule.target(phase, constraint, corner);
        auto half = static_cast<std::uint32_t>(schedule.slot(phase, constraint, corner));
        if (target.block != b) {
          half |= kLeaves;
          number(program.words[targets + static_cast<std::size_t>(i)], corner) =
              pack_target(target.block, target.phase, target.slot);
        }
        number(head, corner / 2) |= half << (16 * (corner % 2));
      }
      if (numbers.corner_count == 2) {
        head.y = std::bit_cast<std::uint32_t>(numbers.damping);
      }
      for (Index p = 0; p < static_cast<Index>(numbers.parameters.size()); ++p) {
        const Index at = p + 2;  // after the slots
        number(program.words[here + static_cast<std::size_t>(at / kNumbers * size)],
               at % kNumbers) = std::bit_cast<std::uint32_t>(numbers.parameters[p]);
      }
    }
  }
}

Index ClusterRecords::words_per_record(DeviceArray array) const noexcept {
  switch (array) {
    case DeviceArray::volumes:
      return words_of(PhaseKind::volume, is_damped_);
    case DeviceArray::neo_hookeans:
      return words_of(PhaseKind::neo_hookean, is_damped_);
    default:
      return 1;
  }
}

void ClusterRecords::follow(std::span<const WordChange> changes,
                            std::vector<WordChange>& words) const {
  for (const WordChange& change : changes) {
    const auto& locations = locations_[static_cast<int>(change.array)];
    const RecordShape shape = shape_of(change.array);
    const Index record = static_cast<Index>(change.word) / shape.size;
    if (record >= static_cast<Index>(locations.size())) {
      continue;  // of what no sweep projects
    }
    const Location& location = locations[record];
    const auto write = [&](Index parameter, std::uint32_t value) {
      const auto at = static_cast<std::uint32_t>(parameter + 2);
      words.push_back({DeviceArray::cluster,
                       kNumbers * (location.word + at / kNumbers * location.stride) + at % kNumbers,
                       value});
    };
    const Index field = static_cast<Index>(change.word) % shape.size;
    const Index parameter = field - shape.corner_count;
    if (field == 0 && static_cast<Index>(change.value) < 0) {
      write(0, kRemovedConstraint);
    } else if (parameter >= 0 && parameter < shape.parameter_count &&
               parameter + 2 < kNumbers * words_per_record(change.array)) {
      write(parameter, change.value);
    }
  }
}

}  // namespace pbdsurg::cuda
