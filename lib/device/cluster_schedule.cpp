// SPDX-License-Identifier: Apache-2.0
#include "lib/device/cluster_schedule.h"

#include <algorithm>
#include <cstddef>
#include <limits>
#include <numeric>
#include <utility>

namespace pbdsurg::cuda {
namespace {

// Room in a vertex's chain: for what comes, and of a new vertex.
constexpr Index kSpareVisits = 8;
constexpr std::size_t kUsualVisits = 48;

// Blocks in whose parts places lie, by which constraints are shared out. Places in order are halved
// and halved again; others lie where a neighbour does.
std::vector<Index> find_parts(std::span<const std::vector<SweepConstraint>> phases,
                              Index place_count, std::span<const PlaceRun> ordered,
                              std::size_t block_count) {
  std::vector<Index> parts(static_cast<std::size_t>(place_count), kInvalidIndex);
  for (const auto& [first, count] : ordered) {
    for (Index i = 0; i < count; ++i) {
      parts[first + i] = static_cast<Index>(static_cast<std::int64_t>(i) *
                                            static_cast<std::int64_t>(block_count) / count);
    }
  }
  const bool are_all_ordered = std::ranges::find(parts, kInvalidIndex) == parts.end();
  for (std::size_t phase = 0; phase < phases.size() && !are_all_ordered; ++phase) {
    for (const auto& [places] : phases[phase]) {
      const auto known = std::ranges::find_if(places, [&](Index place) {
        return place != kInvalidIndex && parts[place] != kInvalidIndex;
      });
      for (const Index place : places) {
        if (known != places.end() && place != kInvalidIndex && parts[place] == kInvalidIndex) {
          parts[place] = parts[*known];
        }
      }
    }
  }
  std::ranges::replace(parts, kInvalidIndex, 0);
  return parts;
}

}  // namespace

ClusterSchedule::ClusterSchedule(std::span<const std::vector<SweepConstraint>> phases,
                                 Index place_count, std::span<const PlaceRun> ordered,
                                 int block_count)
    : blocks_(static_cast<std::size_t>(block_count)),
      chains_(static_cast<std::size_t>(place_count)),
      slots_(block_count),
      is_touched_(chains_.size(), 0),
      is_round_marked_(blocks_.size() * phases.size(), 0) {
  slots_.set_place_count(place_count);
  for (Block& block : blocks_) {
    block.constraints.resize(phases.size());
    block.border_counts.resize(phases.size());
    block.arrivals.assign(phases.size() + 1, 0);
  }
  const std::vector<Index> parts = find_parts(phases, place_count, ordered, blocks_.size());
  assign_blocks(phases, parts);

  std::vector<Index> lengths(chains_.size(), 0);
  const auto for_each_corner = [&](auto visit) {
    for (std::size_t n = 0; n < constraints_.size(); ++n) {
      for (std::size_t corner = 0; corner < 4; ++corner) {
        const Index place = constraints_[n].places[corner];
        if (place != kInvalidIndex) {
          visit(static_cast<Index>(n), corner, place);
        }
      }
    }
  };
  for_each_corner([&](Index, std::size_t, Index place) { ++lengths[place]; });
  for (std::size_t place = 0; place < chains_.size(); ++place) {
    chains_[place].reserve(static_cast<std::size_t>(lengths[place] + kSpareVisits));
  }
  for_each_corner([&](Index n, std::size_t corner, Index place) {
    const ScheduledConstraint& constraint = constraints_[n];
    chains_[place].push_back({n, static_cast<std::uint16_t>(constraint.phase),
                              static_cast<std::uint8_t>(corner),
                              static_cast<std::uint8_t>(constraint.block)});
  });
  for (Index place = 0; place < place_count; ++place) {
    const Chain& chain = chains_[place];
    const Index home = chain.empty() ? parts[place] : chain.front().block;
    slots_.acquire(home, place);
    slots_.settle(home, place);
  }
  for_each_corner(
      [&](Index n, std::size_t, Index place) { slots_.acquire(constraints_[n].block, place); });
  for (Index place = 0; place < place_count; ++place) {
    link(place);
  }
  for (Index block = 0; block < block_count; ++block) {
    for (Index phase = 0; phase < phase_count(); ++phase) {
      std::vector<Index>& list = blocks_[block].constraints[phase];
      std::stable_partition(list.begin(), list.end(),
                            [&](Index n) { return constraints_[n].border_corners != 0; });
      number_constraints(block, phase);
    }
  }
  forget_changes();
}

// Who projects what: the block in whose part most of its vertices lie.
void ClusterSchedule::assign_blocks(std::span<const std::vector<SweepConstraint>> phases,
                                    const std::vector<Index>& parts) {
  const std::size_t count =
      std::accumulate(phases.begin(), phases.end(), std::size_t{0},
                      [](std::size_t sum, const auto& phase) { return sum + phase.size(); });
  constraints_.reserve(count + count / 4);  // for edits, without a copy of all
  first_.push_back(0);
  for (std::size_t phase = 0; phase < phases.size(); ++phase) {
    std::vector<Index> load(blocks_.size(), 0);
    for (const SweepConstraint& from : phases[phase]) {
      const auto& places = from.places;
      Index best = kInvalidIndex;
      std::ptrdiff_t best_votes = 0;
      for (const Index place : places) {
        if (place == kInvalidIndex) {
          break;
        }
        const Index block = parts[place];
        const auto votes = std::ranges::count_if(
            places, [&](Index other) { return other != kInvalidIndex && parts[other] == block; });
        if (votes > best_votes || (votes == best_votes && load[block] < load[best])) {
          best = block;
          best_votes = votes;
        }
      }
      if (best != kInvalidIndex) {
        ++load[best];
        blocks_[best].constraints[phase].push_back(static_cast<Index>(constraints_.size()));
      }
      constraints_.push_back({.places = places, .phase = static_cast<Index>(phase), .block = best});
    }
    first_.push_back(static_cast<Index>(constraints_.size()));
  }
}

Index ClusterSchedule::add(Index phase) {
  constraints_.push_back({.places = {}, .phase = phase});
  constraints_.back().places.fill(kInvalidIndex);
  return static_cast<Index>(constraints_.size()) - 1;
}

bool ClusterSchedule::follow(std::span<const Placement> placements, Index place_count,
                             Index round_size, Index slot_room) {
  forget_changes();
  const Index count_before = this->place_count();
  if (place_count > count_before) {
    chains_.resize(static_cast<std::size_t>(place_count));
    for (Index place = count_before; place < place_count; ++place) {
      chains_[place].reserve(kUsualVisits);
    }
    is_touched_.resize(chains_.size(), 0);
    slots_.set_place_count(place_count);
  }
  for (Index place = count_before; place < place_count; ++place) {
    touch(place);
  }
  moving_.clear();
  for (const Placement& placement : placements) {
    ScheduledConstraint& constraint = constraints_[placement.constraint];
    const bool exists = placement.next.places[0] != kInvalidIndex;
    if (constraint.block != kInvalidIndex &&
        (!exists || constraint.places == placement.next.places)) {
      constraint.is_removed = !exists;
      changes_.stayed.push_back(placement.constraint);
    } else if (exists) {
      const Index first = std::ranges::min(
          placement.next.places, {}, [](Index place) { return static_cast<std::uint32_t>(place); });
      moving_.push_back({first, &placement});
    }
  }
  // neighbours one after another, so that each finds where the last went
  std::ranges::sort(moving_, {}, [](const Moving& moving) {
    return std::pair(moving.first_place, moving.placement);  // which lie in one list
  });
  // all leave before any comes, for one may come where another was
  for (const auto& [first, placement] : moving_) {
    if (constraints_[placement->constraint].block != kInvalidIndex) {
      take_out(placement->constraint);
    }
  }
  for (Index place = place_count; place < count_before; ++place) {
    touch(place);
    while (!chains_[place].empty()) {
      if (!constraints_[chains_[place].back().constraint].is_removed) {
        return false;
      }
      take_out(chains_[place].back().constraint);
    }
  }
  for (const auto& [first, placement] : moving_) {
    ScheduledConstraint& constraint = constraints_[placement->constraint];
    constraint.places = placement->next.places;
    constraint.is_removed = false;
    for (const Index place : constraint.places) {
      if (place != kInvalidIndex && (place >= place_count || !make_way(place, constraint.phase))) {
        return false;
      }
    }
    put_in(placement->constraint, choose_block(constraint, round_size, slot_room));
  }
  link_touched(place_count);
  return true;
}

void ClusterSchedule::forget_changes() {
  for (const Index n : changes_.constraints) {
    constraints_[n].is_changed = false;
  }
  for (const auto& [block, phase] : changes_.rounds) {
    is_round_marked_[round_index(block, phase)] = 0;
  }
  changes_.constraints.clear();
  changes_.stayed.clear();
  changes_.rounds.clear();
  changes_.arrivals.clear();
  slots_.changed.clear();
  slots_.moved.clear();
}

void ClusterSchedule::mark_constraint(Index n) {
  if (!constraints_[n].is_changed) {
    constraints_[n].is_changed = true;
    changes_.constraints.push_back(n);
  }
}

void ClusterSchedule::mark_round(Index block, Index phase) {
  std::uint8_t& is_marked = is_round_marked_[round_index(block, phase)];
  if (is_marked == 0) {
    is_marked = 1;
    changes_.rounds.emplace_back(block, phase);
  }
}

void ClusterSchedule::count_arrival(const VertexTarget& target, Index more) {
  blocks_[target.block].arrivals[target.phase] += more;
  changes_.arrivals.emplace_back(target.block, target.phase);
}

// Its links are no more, until all is where it will be: see link_touched().
void ClusterSchedule::touch(Index place) {
  if (is_touched_[place] != 0) {
    return;
  }
  is_touched_[place] = 1;
  touched_.push_back(place);
  for (const Visit& visit : chains_[place]) {
    const VertexTarget& target = constraints_[visit.constraint].targets[visit.corner];
    if (target.block != visit.block) {
      count_arrival(target, -1);
    }
  }
}

void ClusterSchedule::take_out(Index n) {
  ScheduledConstraint& constraint = constraints_[n];
  for (const Index place : constraint.places) {
    if (place != kInvalidIndex) {
      touch(place);
      chains_[place].erase(find_visit(place, constraint.phase));
    }
  }
  if (constraint.border_corners != 0) {
    leave_border(n);
  }
  auto& list = blocks_[constraint.block].constraints[constraint.phase];
  swap_with(n, list.back());
  list.pop_back();
  mark_round(constraint.block, constraint.phase);
  constraint.block = constraint.position = kInvalidIndex;
  constraint.border_corners = 0;
}

// Nobody else may have the vertex in that phase; one that only lets it pass gives way.
bool ClusterSchedule::make_way(Index place, Index phase) {
  const auto visit = find_visit(place, phase);
  if (visit == chains_[place].end() || visit->phase != phase) {
    return true;
  }
  if (!constraints_[visit->constraint].is_removed) {
    return false;
  }
  take_out(visit->constraint);
  return true;
}

void ClusterSchedule::put_in(Index n, Index block) {
  ScheduledConstraint& constraint = constraints_[n];
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const Index place = constraint.places[corner];
    if (place != kInvalidIndex) {
      touch(place);
      chains_[place].insert(find_visit(place, constraint.phase),
                            {n, static_cast<std::uint16_t>(constraint.phase),
                             static_cast<std::uint8_t>(corner), static_cast<std::uint8_t>(block)});
    }
  }
  auto& list = blocks_[block].constraints[constraint.phase];
  constraint.block = block;
  constraint.position = static_cast<Index>(list.size());
  list.push_back(n);
  mark_constraint(n);
  mark_round(block, constraint.phase);
}

// Where it adds the fewest messages, then where there is least to do. One constraint more than a
// block projects at once costs as much as all of them, and a block that is out of slots all that
// edits have brought.
Index ClusterSchedule::choose_block(const ScheduledConstraint& constraint, Index round_size,
                                    Index slot_room) const {
  constexpr Index kMostMessages = 8;
  const auto has_slots = [&](Index block) {
    const auto used = static_cast<Index>(slots_.places(block).size()) - slots_.free_count(block);
    return used < slot_room - slot_room / 8 ||
           std::ranges::all_of(constraint.places, [&](Index place) {
             return place == kInvalidIndex || slots_.slot(block, place) != kInvalidIndex;
           });
  };
  std::array<std::array<Index, 2>, 4> neighbours;  // blocks, before and after
  for (std::size_t corner = 0; corner < 4; ++corner) {
    const Index place = constraint.places[corner];
    neighbours[corner].fill(kInvalidIndex);
    if (place == kInvalidIndex) {
      continue;
    }
    const Chain& chain = chains_[place];
    neighbours[corner].fill(slots_.home(place));
    if (!chain.empty()) {  // sweeps follow each other: the first comes after the last
      const auto next = find_visit(place, constraint.phase);
      neighbours[corner] = {next == chain.begin() ? chain.back().block : (next - 1)->block,
                            next == chain.end() ? chain.front().block : next->block};
    }
  }
  Index best = 0;
  std::pair<Index, Index> best_cost{std::numeric_limits<Index>::max(), 0};
  for (Index block = 0; block < block_count(); ++block) {
    const auto load = static_cast<Index>(constraints(block, constraint.phase).size());
    Index messages = load > 0 && load % round_size == 0 ? kMostMessages + 1 : 0;
    messages += has_slots(block) ? 0 : 2 * (kMostMessages + 1);
    for (const auto& corner : neighbours) {
      messages += static_cast<Index>(std::ranges::count_if(
          corner, [&](Index other) { return other != kInvalidIndex && other != block; }));
    }
    if (const std::pair cost(messages, load); cost < best_cost) {
      best = block;
      best_cost = cost;
    }
  }
  return best;
}

void ClusterSchedule::link_touched(Index place_count) {
  for (std::size_t i = 0; i < touched_.size(); ++i) {  // which grows
    find_slots(touched_[i], touched_[i] < place_count);
    for (const Index place : slots_.moved) {
      touch(place);
    }
    slots_.moved.clear();
  }
  for (const Index place : touched_) {
    link(place);
    is_touched_[place] = 0;
  }
  touched_.clear();
  chains_.resize(static_cast<std::size_t>(place_count));
  is_touched_.resize(chains_.size());
  slots_.set_place_count(place_count);
}

void ClusterSchedule::find_slots(Index place, bool exists) {
  const Chain& chain = chains_[place];
  const Index home_before = slots_.home(place);
  Index home = kInvalidIndex;
  if (!chain.empty()) {
    home = chain.front().block;
  } else if (exists) {
    home = home_before != kInvalidIndex ? home_before : emptiest_block();
  }
  if (home_before != kInvalidIndex && home_before != home) {
    slots_.unsettle(place);
  }
  std::uint32_t needed = home == kInvalidIndex ? 0 : 1U << home;
  for (const Visit& visit : chain) {
    needed |= 1U << visit.block;
  }
  for (Index block = 0; block < block_count(); ++block) {
    if ((needed >> block & 1) != 0) {
      slots_.acquire(block, place);
    } else if (slots_.slot(block, place) != kInvalidIndex) {
      slots_.release(block, place);
    }
  }
  if (home != home_before && home != kInvalidIndex) {
    slots_.settle(home, place);
  }
}

Index ClusterSchedule::emptiest_block() const {
  Index best = 0;
  for (Index block = 1; block < block_count(); ++block) {
    if (slots_.places(block).size() < slots_.places(best).size()) {
      best = block;
    }
  }
  return best;
}

// Tells each constraint of a vertex where it comes from and where it goes to.
void ClusterSchedule::link(Index place) {
  const Chain& chain = chains_[place];
  Index from = slots_.home(place);
  for (std::size_t i = 0; i < chain.size(); ++i) {
    const Visit& visit = chain[i];
    const bool is_last = i + 1 == chain.size();
    const Index to = is_last ? slots_.home(place) : chain[i + 1].block;
    const VertexTarget target{
        static_cast<std::uint16_t>(to), static_cast<std::uint16_t>(slots_.slot(to, place)),
        is_last ? static_cast<std::uint16_t>(phase_count()) : chain[i + 1].phase};
    if (to != visit.block) {
      count_arrival(target, 1);
    }
    ScheduledConstraint& constraint = constraints_[visit.constraint];
    const auto slot = static_cast<std::uint16_t>(slots_.slot(visit.block, place));
    if (constraint.slots[visit.corner] != slot || constraint.targets[visit.corner] != target) {
      constraint.slots[visit.corner] = slot;
      constraint.targets[visit.corner] = target;
      mark_constraint(visit.constraint);
    }
    const bool was_border = constraint.border_corners != 0;
    const auto bit = static_cast<std::uint8_t>(1U << visit.corner);
    if (from != visit.block || to != visit.block) {
      constraint.border_corners |= bit;
    } else {
      constraint.border_corners &= static_cast<std::uint8_t>(~bit);
    }
    const bool is_border = constraint.border_corners != 0;
    if (was_border != is_border && constraint.position != kInvalidIndex) {
      if (is_border) {
        join_border(visit.constraint);
      } else {
        leave_border(visit.constraint);
      }
    }
    from = visit.block;
  }
}

void ClusterSchedule::number_constraints(Index block, Index phase) {
  const auto& list = blocks_[block].constraints[phase];
  Index& border = blocks_[block].border_counts[phase];
  border = 0;
  for (std::size_t i = 0; i < list.size(); ++i) {
    constraints_[list[i]].position = static_cast<Index>(i);
    border += constraints_[list[i]].border_corners != 0;
  }
}

// Constraints of one block and phase.
void ClusterSchedule::swap_with(Index n, Index other) {
  ScheduledConstraint& one = constraints_[n];
  auto& list = blocks_[one.block].constraints[one.phase];
  std::swap(list[one.position], list[constraints_[other].position]);
  std::swap(one.position, constraints_[other].position);
  mark_constraint(n);
  mark_constraint(other);
}

void ClusterSchedule::join_border(Index n) {
  const ScheduledConstraint& constraint = constraints_[n];
  Block& block = blocks_[constraint.block];
  swap_with(n, block.constraints[constraint.phase][block.border_counts[constraint.phase]++]);
  mark_round(constraint.block, constraint.phase);
}

void ClusterSchedule::leave_border(Index n) {
  const ScheduledConstraint& constraint = constraints_[n];
  Block& block = blocks_[constraint.block];
  swap_with(n, block.constraints[constraint.phase][--block.border_counts[constraint.phase]]);
  mark_round(constraint.block, constraint.phase);
}

}  // namespace pbdsurg::cuda
