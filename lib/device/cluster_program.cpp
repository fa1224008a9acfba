// SPDX-License-Identifier: Apache-2.0
#include "lib/device/cluster_program.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace pbdsurg::cuda {
namespace {

// Of a record, by its numbers.
SweepConstraint to_constraint(const ClusterShape& shape, const std::uint32_t* numbers) {
  SweepConstraint constraint;
  constraint.places.fill(kInvalidIndex);
  if (static_cast<Index>(numbers[0]) >= 0) {
    std::transform(numbers, numbers + shape.corner_count, constraint.places.begin(),
                   [](std::uint32_t place) { return static_cast<Index>(place); });
  }
  return constraint;
}

template <class T>
std::vector<std::uint32_t> numbers_of(const std::vector<T>& values) {
  std::vector<std::uint32_t> numbers(values.size() * sizeof(T) / sizeof(std::uint32_t));
  if (!values.empty()) {
    std::memcpy(numbers.data(), values.data(), values.size() * sizeof(T));
  }
  return numbers;
}

std::size_t words_of(const ClusterRound& round) {
  return std::size_t{round.count} * round.words + round.border;
}

}  // namespace

std::optional<ClusterProgram> ClusterProgram::make(std::span<const Stage> stages,
                                                   const StageRecords& records, Index place_count,
                                                   std::span<const PlaceRun> ordered,
                                                   Index block_count, bool is_damped,
                                                   GrowthRoom room) {
  if (stages.empty() || static_cast<Index>(stages.size()) > kMostClusterPhases ||
      std::ranges::any_of(stages, [](const Stage& stage) {
        return stage.level_count > 0 || shape_of(stage.kind) == nullptr;
      })) {
    return std::nullopt;
  }
  ClusterProgram program(stages, records, is_damped, room);
  program.make_schedule(place_count, ordered, block_count);
  program.find_sizes();
  if (program.sizes_.slot_room > static_cast<Index>(kSlotMask)) {
    return std::nullopt;
  }
  program.write_all();
  return program;
}

ClusterProgram::ClusterProgram(std::span<const Stage> stages, const StageRecords& records,
                               bool is_damped, GrowthRoom room)
    : is_damped_(is_damped), room_(room), stages_(stages.begin(), stages.end()) {
  numbers(DeviceArray::distance_damping) = numbers_of(records.distance_damping);
  records.for_each_list([&]<class Constraint>(const std::vector<Record<Constraint>>& list) {
    numbers(array_of(KindOf<Constraint>::kPhase)) = numbers_of(list);
  });
}

void ClusterProgram::make_schedule(Index place_count, std::span<const PlaceRun> ordered,
                                   Index block_count) {
  std::vector<std::vector<SweepConstraint>> phases;
  for (const Stage& stage : stages_) {
    const ClusterShape& shape = *shape_of(stage.kind);
    auto& constraints = constraints_[static_cast<int>(shape.array)];
    constraints.resize(static_cast<std::size_t>(stage.first), kInvalidIndex);
    auto& phase = phases.emplace_back();
    for (Index record = stage.first; record < stage.first + stage.count; ++record) {
      const SweepConstraint constraint =
          to_constraint(shape, &numbers(shape.array)[static_cast<std::size_t>(record) *
                                                     static_cast<std::size_t>(shape.record_size)]);
      if (constraint.places[0] == kInvalidIndex) {
        constraints.push_back(kOfPhase - static_cast<Index>(phases.size() - 1));
        continue;
      }
      constraints.push_back(static_cast<Index>(record_of_constraint_.size()));
      record_of_constraint_.push_back(record);
      phase.push_back(constraint);
    }
  }
  schedule_.emplace(phases, place_count, ordered, block_count);
}

void ClusterProgram::find_sizes() {
  const Index phase_count = schedule_->phase_count();
  sizes_.block_count = schedule_->block_count();
  sizes_.phase_count = phase_count;
  sizes_.place_room = schedule_->place_count();
  std::size_t most = 0;
  for (Index b = 0; b < sizes_.block_count; ++b) {
    sizes_.slot_room =
        std::max(sizes_.slot_room, static_cast<Index>(schedule_->slots().places(b).size()));
    for (Index phase = 0; phase < phase_count; ++phase) {
      most = std::max(most, schedule_->constraints(b, phase).size());
    }
  }
  sizes_.thread_count =
      static_cast<Index>(most) <= kFewClusterThreads ? kFewClusterThreads : kManyClusterThreads;
  blocks_.resize(static_cast<std::size_t>(sizes_.block_count));
  for (Index b = 0; b < sizes_.block_count; ++b) {
    blocks_[b].first_rounds.assign(static_cast<std::size_t>(phase_count) + 1, 0);
    for (Index phase = 0; phase < phase_count; ++phase) {
      count_rounds(b, phase);
    }
    const std::vector<Round>& rounds = blocks_[b].rounds;
    sizes_.round_room = std::max(sizes_.round_room, static_cast<Index>(rounds.size()));
    for (const Round& round : rounds) {
      sizes_.round_words = std::max(sizes_.round_words, static_cast<Index>(most_words(round.now)));
      sizes_.word_room += with_room(words_of(round.now));
      sizes_.multiplier_room += with_room(round.now.count * multipliers_of(round.now));
    }
  }
  if (room_ != GrowthRoom::none) {
    // Edits gather: a block may get most of what they bring.
    constexpr Index kRounds = 4;  // beside one of each phase
    constexpr Index kSlots = 64;
    constexpr Index kPlaces = 1024;
    sizes_.round_room += phase_count + kRounds;
    const Index more_slots = room_ == GrowthRoom::ample ? sizes_.slot_room / 2 + 2 * kSlots
                                                        : sizes_.slot_room / 8 + kSlots;
    sizes_.slot_room = std::max(
        sizes_.slot_room, std::min(sizes_.slot_room + more_slots, static_cast<Index>(kSlotMask)));
    sizes_.place_room += sizes_.place_room + kPlaces;
    // for rounds that outgrow their places
    sizes_.word_room += sizes_.word_room + 4 * static_cast<std::size_t>(sizes_.round_words);
    sizes_.multiplier_room += sizes_.multiplier_room / 2 +
                              4 * static_cast<std::size_t>(sizes_.thread_count) *
                                  static_cast<std::size_t>(NeoHookeanConstraint::kMultiplierCount);
  }
  sections_ = ClusterSections(sizes_);
}

void ClusterProgram::write_all() {
  image_.assign(sections_.words + kNumbers * sizes_.word_room, 0);
  words_ = RangePool(sizes_.word_room);
  multipliers_ = RangePool(sizes_.multiplier_room);
  for (Index b = 0; b < sizes_.block_count; ++b) {
    for (Index phase = 0; phase < sizes_.phase_count; ++phase) {
      static_cast<void>(write_phase(b, phase));  // there is room
      write_arrivals(b, phase);
    }
    write_arrivals(b, sizes_.phase_count);
    for (std::size_t slot = 0; slot < schedule_->slots().places(b).size(); ++slot) {
      write_slot(b, static_cast<Index>(slot));
    }
    write_block(b);
  }
}

bool ClusterProgram::follow(std::vector<WordChange>& words, Index place_count) {
  if (!take_over(words) || place_count > sizes_.place_room ||
      !schedule_->follow(placements_, place_count, sizes_.thread_count, sizes_.slot_room)) {
    return false;
  }
  written_ = &words;
  const bool fits = write_changes();
  written_ = nullptr;
  return fits;
}

Index ClusterProgram::constraint_of(DeviceArray array, std::size_t record) {
  auto& constraints = constraints_[static_cast<int>(array)];
  if (record >= constraints.size()) {
    return kInvalidIndex;
  }
  Index& n = constraints[record];
  if (n <= kOfPhase) {
    n = schedule_->add(kOfPhase - n);
    record_of_constraint_.push_back(static_cast<Index>(record));
  }
  return n;
}

bool ClusterProgram::take_over(std::span<const WordChange> changes) {
  changed_.clear();
  for (const WordChange& change : changes) {
    const bool is_damping = change.array == DeviceArray::distance_damping;
    const ClusterShape* const shape = shape_of(is_damping ? DeviceArray::distances : change.array);
    if (shape == nullptr) {
      continue;
    }
    const Index n = constraint_of(
        shape->array,
        change.word / (is_damping ? 1 : static_cast<std::size_t>(shape->record_size)));
    if (n == kInvalidIndex) {
      return false;  // another plan's
    }
    numbers(change.array)[change.word] = change.value;
    if (changed_.empty() || changed_.back().first != n) {
      changed_.emplace_back(n, shape);
    }
  }
  std::ranges::sort(changed_, {}, &std::pair<Index, const ClusterShape*>::first);
  changed_.erase(std::unique(changed_.begin(), changed_.end()), changed_.end());
  placements_.clear();
  for (const auto& [n, shape] : changed_) {
    placements_.push_back({n, to_constraint(*shape, record_of(n))});
  }
  return true;
}

bool ClusterProgram::write_changes() {
  for (Index b = 0; b < sizes_.block_count; ++b) {
    if (static_cast<Index>(schedule_->slots().places(b).size()) > sizes_.slot_room) {
      return false;
    }
  }
  const ScheduleChanges& changes = schedule_->changes();
  for (const auto& [b, phase] : changes.rounds) {
    blocks_[b].is_changed = true;
    count_rounds(b, phase);
    if (static_cast<Index>(blocks_[b].rounds.size()) > sizes_.round_room ||
        !write_phase(b, phase)) {
      return false;
    }
  }
  for (const Index n : changes.constraints) {
    if (schedule_->constraint(n).block != kInvalidIndex) {
      write_constraint(n);
    }
  }
  for (const Index n : changes.stayed) {
    const ScheduledConstraint& constraint = schedule_->constraint(n);
    if (constraint.block != kInvalidIndex && constraint.is_removed) {
      write(head_of(constraint) + kFirstParameter, std::span(&kRemovedConstraint, 1));
    } else if (constraint.block != kInvalidIndex) {
      write_constraint(n);
    }
  }
  for (const auto& [b, slot] : schedule_->slots().changed) {
    blocks_[b].is_changed = true;
    write_slot(b, slot);
  }
  for (const auto& [b, phase] : changes.arrivals) {
    write_arrivals(b, phase);
  }
  for (Index b = 0; b < sizes_.block_count; ++b) {
    if (blocks_[b].is_changed) {
      write_block(b);
    }
  }
  return true;
}

// How many rounds a phase takes, and how many constraints each. A block without constraints in a
// phase has nothing to wait for in it; but it has one round at least.
void ClusterProgram::count_rounds(Index b, Index phase) {
  auto& [rounds, first_rounds, is_changed] = blocks_[b];
  const auto size = static_cast<Index>(schedule_->constraints(b, phase).size());
  const Index needed = std::max((size + sizes_.thread_count - 1) / sizes_.thread_count,
                                phase == 0 ? Index{1} : Index{0});
  const Index end = first_rounds[phase + 1];
  const Index more = needed - (end - first_rounds[phase]);
  if (more > 0) {
    const ClusterShape& shape = *shape_of(stages_[phase].kind);
    Round round;
    round.now.phase = static_cast<std::uint16_t>(phase);
    round.now.kind = static_cast<std::uint8_t>(shape.kind);
    round.now.words = static_cast<std::uint8_t>(shape.words(is_damped_));
    rounds.insert(rounds.begin() + end, static_cast<std::size_t>(more), round);
  } else {
    const auto first = rounds.begin() + (end + more);
    for (auto round = first; round != rounds.begin() + end; ++round) {
      words_.give_back(round->words);
      multipliers_.give_back(round->multipliers);
    }
    rounds.erase(first, rounds.begin() + end);
  }
  if (more != 0) {
    for (Index next = phase + 1; next <= sizes_.phase_count; ++next) {
      first_rounds[next] += more;
    }
  }
  const Index border = schedule_->border_count(b, phase);
  for (Index i = 0; i < needed; ++i) {
    const Index first = i * sizes_.thread_count;
    ClusterRound& round = rounds[first_rounds[phase] + i].now;
    const Index count = std::min(sizes_.thread_count, size - first);
    round.count = static_cast<std::uint16_t>(count);
    round.border = static_cast<std::uint16_t>(std::clamp(border - first, Index{0}, count));
  }
}

// Of constraints that stay where they are, no more than what lies elsewhere since: all words, where
// the round has moved or words of a constraint are so many apart as there are constraints; else
// targets, which lie behind all words.
bool ClusterProgram::write_phase(Index b, Index phase) {
  auto& [rounds, first_rounds, is_changed] = blocks_[b];
  const std::vector<Index>& constraints = schedule_->constraints(b, phase);
  for (Index i = first_rounds[phase]; i < first_rounds[phase + 1]; ++i) {
    Round& round = rounds[i];
    if (!fit(round)) {
      return false;
    }
    const bool has_other_count = round.written_count != round.now.count;
    const bool is_elsewhere = round.written_first != round.now.first;
    Index count = has_other_count ? round.now.border : 0;
    if (is_elsewhere || (has_other_count && round.now.words > 1)) {
      count = round.now.count;
    }
    const Index first = (i - first_rounds[phase]) * sizes_.thread_count;
    for (Index lane = 0; lane < count; ++lane) {
      write_constraint(constraints[first + lane]);
    }
    round.written_first = round.now.first;
    round.written_count = round.now.count;
  }
  return true;
}

// Moves a round that has outgrown its words or multipliers to where there is room, for half as many
// again. Nobody remembers a multiplier between two steps.
bool ClusterProgram::fit(Round& round) {
  const auto move = [&](RangePool::Range& range, RangePool& pool, std::size_t size,
                        std::size_t wanted) {
    pool.give_back(std::exchange(range, {}));
    const std::optional<RangePool::Range> taken = pool.take(size, wanted);
    range = taken.value_or(RangePool::Range{});
    return taken.has_value();
  };
  const auto room_for = [&](std::size_t size, const RangePool::Range& before) {
    return with_room(before.size == 0 ? size : size + size / 2);
  };
  const std::size_t words = words_of(round.now);
  const auto most = static_cast<std::size_t>(sizes_.round_words);
  if (words > most ||
      (words > round.words.size &&
       !move(round.words, words_, words, std::min(room_for(words, round.words), most)))) {
    return false;
  }
  const std::size_t multipliers = round.now.count * multipliers_of(round.now);
  if (multipliers > round.multipliers.size && !move(round.multipliers, multipliers_, multipliers,
                                                    room_for(multipliers, round.multipliers))) {
    return false;
  }
  round.now.first = static_cast<std::uint32_t>(round.words.first);
  round.now.first_multiplier = static_cast<std::uint32_t>(round.multipliers.first);
  return true;
}

// How large a round may become.
std::size_t ClusterProgram::most_words(const ClusterRound& round) const {
  constexpr Index kFewest = 8;
  switch (room_) {
    case GrowthRoom::none:
      break;
    case GrowthRoom::some: {
      const auto grown = [&](Index count) {
        return static_cast<std::size_t>(std::min(count + count / 4 + kFewest, sizes_.thread_count));
      };
      return grown(round.count) * round.words + grown(round.border);
    }
    case GrowthRoom::ample: {  // all of it may come to lie at a border
      const Index most = std::min(2 * round.count + kFewest, sizes_.thread_count);
      return static_cast<std::size_t>(most) * (round.words + 1U);
    }
  }
  return words_of(round);
}

std::size_t ClusterProgram::with_room(std::size_t count) const {
  return room_ == GrowthRoom::none ? count : count + count / 8 + 8;
}

std::size_t ClusterProgram::multipliers_of(const ClusterRound& round) {
  return static_cast<std::size_t>(shape_of(static_cast<PhaseKind>(round.kind))->multiplier_count);
}

std::vector<std::uint32_t>& ClusterProgram::numbers(DeviceArray array) {
  return records_[static_cast<int>(array)];
}

const std::uint32_t* ClusterProgram::record_of(Index n) const {
  const ClusterShape& shape = *shape_of(stages_[schedule_->constraint(n).phase].kind);
  return records_[static_cast<int>(shape.array)].data() +
         static_cast<std::size_t>(record_of_constraint_[n]) *
             static_cast<std::size_t>(shape.record_size);
}

const ClusterRound& ClusterProgram::round_of(const ScheduledConstraint& constraint) const {
  const auto& [rounds, first_rounds, is_changed] = blocks_[constraint.block];
  return rounds[first_rounds[constraint.phase] + constraint.position / sizes_.thread_count].now;
}

// Where its first word lies.
std::size_t ClusterProgram::head_of(const ScheduledConstraint& constraint) const {
  return sections_.words +
         kNumbers * (std::size_t{round_of(constraint).first} +
                     static_cast<std::size_t>(constraint.position % sizes_.thread_count));
}

void ClusterProgram::write_constraint(Index n) {
  const ScheduledConstraint& constraint = schedule_->constraint(n);
  const ClusterShape& shape = *shape_of(stages_[constraint.phase].kind);
  const ClusterRound& round = round_of(constraint);
  const Index lane = constraint.position % sizes_.thread_count;

  std::array<std::uint32_t, kNumbers * kMostWords> all{};
  std::array<std::uint32_t, kNumbers> targets{};
  for (Index corner = 0; corner < shape.corner_count; ++corner) {
    const VertexTarget& target = constraint.targets[corner];
    std::uint32_t half = constraint.slots[corner];
    if (target.block != constraint.block) {
      half |= kLeaves;
      targets[corner] = pack_target(target.block, target.phase, target.slot);
    }
    all[corner / 2] |= half << (16 * (corner % 2));
  }
  if (shape.kind == PhaseKind::distance) {
    all[1] = numbers(DeviceArray::distance_damping)[record_of_constraint_[n]];
  }
  const std::uint32_t* const record = record_of(n);
  for (Index p = 0; p < shape.packed_parameters(is_damped_); ++p) {
    all[kFirstParameter + p] = record[shape.corner_count + p];  // after the slots
  }
  if (constraint.is_removed) {
    all[kFirstParameter] = kRemovedConstraint;
  }

  const auto word = [&](Index index) {  // of the round
    return sections_.words +
           kNumbers * (std::size_t{round.first} + static_cast<std::size_t>(index));
  };
  for (Index w = 0; w < round.words; ++w) {
    write(word(w * round.count + lane),
          std::span(all).subspan(static_cast<std::size_t>(kNumbers * w), kNumbers));
  }
  if (lane < round.border) {
    write(word(round.words * round.count + lane), targets);
  }
}

void ClusterProgram::write_slot(Index b, Index slot) {
  const ClusterSlots& slots = schedule_->slots();
  const Index place = slots.places(b)[slot];
  const auto at = static_cast<std::size_t>(b * sizes_.slot_room + slot);
  const std::uint32_t number = place == kInvalidIndex ? 0 : static_cast<std::uint32_t>(place);
  write(sections_.places + at, std::span(&number, 1));
  if (slot < slots.home_count(b)) {
    const std::uint32_t home =
        static_cast<std::uint32_t>(b) << 16 | static_cast<std::uint32_t>(slot);
    write(sections_.homes + number, std::span(&home, 1));
  }
}

void ClusterProgram::write_arrivals(Index b, Index phase) {
  const auto at = static_cast<std::size_t>(b * (sizes_.phase_count + 1) + phase);
  const std::uint32_t bytes =
      static_cast<std::uint32_t>(schedule_->arrivals(b, phase)) * sizeof(Word128);
  write(sections_.arrivals + at, std::span(&bytes, 1));
}

// With the list of its rounds.
void ClusterProgram::write_block(Index b) {
  blocks_[b].is_changed = false;
  const auto& rounds = blocks_[b].rounds;
  const ClusterSlots& slots = schedule_->slots();
  const ClusterBlock block{static_cast<std::uint32_t>(b * sizes_.slot_room),
                           static_cast<std::uint32_t>(slots.home_count(b)),
                           static_cast<std::uint32_t>(slots.places(b).size()),
                           static_cast<std::uint32_t>(b * sizes_.round_room),
                           static_cast<std::uint32_t>(rounds.size())};
  constexpr std::size_t kBlockNumbers = sizeof block / sizeof(std::uint32_t);
  write(sections_.blocks + static_cast<std::size_t>(b) * kBlockNumbers,
        std::bit_cast<std::array<std::uint32_t, kBlockNumbers>>(block));
  for (std::size_t i = 0; i < rounds.size(); ++i) {
    constexpr std::size_t kRoundNumbers = sizeof(ClusterRound) / sizeof(std::uint32_t);
    write(sections_.rounds + (block.first_round + i) * kRoundNumbers,
          std::bit_cast<std::array<std::uint32_t, kRoundNumbers>>(rounds[i].now));
  }
}

void ClusterProgram::write(std::size_t at, std::span<const std::uint32_t> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (image_[at + i] == numbers[i]) {
      continue;
    }
    image_[at + i] = numbers[i];
    if (written_ != nullptr) {
      written_->push_back({DeviceArray::cluster, static_cast<std::uint32_t>(at + i), numbers[i]});
    }
  }
}

}  // namespace pbdsurg::cuda
