// SPDX-License-Identifier: Apache-2.0
#include "solver/cluster_schedule.h"

#include <algorithm>

namespace pbdsurg::cuda {
namespace {

/// Where a vertex was last seen, while phases are gone through.
struct Passage {
  Index block = kInvalidIndex;  // of its last constraint
  std::size_t visit = 0;        // of its last constraint
  Index home = kInvalidIndex;   // block of its first
};

}  // namespace

ClusterSchedule::ClusterSchedule(std::span<const std::vector<SweepConstraint>> phases,
                                 Index place_count, int block_count)
    : blocks_(static_cast<std::size_t>(block_count)) {
  const auto phase_count = static_cast<Index>(phases.size());
  const auto part_of = [&](Index place) {
    return static_cast<Index>(static_cast<std::int64_t>(place) * block_count / place_count);
  };
  for (ScheduledBlock& block : blocks_) {
    block.constraints.resize(phases.size());
    block.arrivals.assign(phases.size() + 1, 0);
  }

  // who projects what: the block in whose part most of its vertices lie
  std::vector<std::vector<Index>> block_of(phases.size());
  for (Index phase = 0; phase < phase_count; ++phase) {
    std::vector<Index> load(blocks_.size(), 0);
    for (std::size_t c = 0; c < phases[phase].size(); ++c) {
      const auto& places = phases[phase][c].places;
      Index best = kInvalidIndex;
      std::ptrdiff_t best_votes = 0;
      for (const Index place : places) {
        if (place == kInvalidIndex) {
          break;
        }
        const Index part = part_of(place);
        const auto votes = std::count_if(places.begin(), places.end(), [&](Index other) {
          return other != kInvalidIndex && part_of(other) == part;
        });
        if (votes > best_votes || (votes == best_votes && load[part] < load[best])) {
          best = part;
          best_votes = votes;
        }
      }
      ++load[best];
      block_of[phase].push_back(best);
      blocks_[best].constraints[phase].push_back(static_cast<Index>(c));
    }
  }

  std::vector<Passage> passages(static_cast<std::size_t>(place_count));
  for (Index phase = 0; phase < phase_count; ++phase) {
    for (std::size_t c = 0; c < phases[phase].size(); ++c) {
      for (const Index place : phases[phase][c].places) {
        if (place != kInvalidIndex && passages[place].home == kInvalidIndex) {
          passages[place].home = block_of[phase][c];
        }
      }
    }
  }
  // slots: those at home first
  std::vector<std::vector<Index>> slot_of(blocks_.size(),
                                          std::vector<Index>(passages.size(), kInvalidIndex));
  const auto slot_at = [&](Index block, Index place) {
    Index& slot = slot_of[block][place];
    if (slot == kInvalidIndex) {
      slot = static_cast<Index>(blocks_[block].places.size());
      blocks_[block].places.push_back(place);
    }
    return slot;
  };
  for (Index place = 0; place < place_count; ++place) {
    Index& home = passages[place].home;
    home = home == kInvalidIndex ? part_of(place) : home;
    slot_at(home, place);
    ++blocks_[home].home_count;
  }

  const auto send = [&](std::size_t visit, Index block, Index place, Index phase) {
    visits_[visit].target = {static_cast<std::uint16_t>(block),
                             static_cast<std::uint16_t>(slot_at(block, place)),
                             static_cast<std::uint16_t>(phase)};
  };
  for (Index phase = 0; phase < phase_count; ++phase) {
    first_visit_.push_back(visits_.size());
    for (std::size_t c = 0; c < phases[phase].size(); ++c) {
      const Index block = block_of[phase][c];
      for (const Index place : phases[phase][c].places) {
        visits_.push_back({});
        if (place == kInvalidIndex) {
          continue;
        }
        Passage& passage = passages[place];
        if (passage.block != kInvalidIndex) {
          send(passage.visit, block, place, phase);
          if (passage.block != block) {
            ++blocks_[block].arrivals[phase];
            visits_.back().is_border = visits_[passage.visit].is_border = true;
          }
        }
        visits_.back().slot = slot_at(block, place);
        passage.block = block;
        passage.visit = visits_.size() - 1;
      }
    }
  }
  for (Index place = 0; place < place_count; ++place) {
    const Passage& passage = passages[place];
    if (passage.block != kInvalidIndex) {
      send(passage.visit, passage.home, place, phase_count);
      if (passage.block != passage.home) {
        ++blocks_[passage.home].arrivals[phase_count];
        visits_[passage.visit].is_border = true;
      }
    }
  }
  for (ScheduledBlock& block : blocks_) {
    for (Index phase = 0; phase < phase_count; ++phase) {
      auto& list = block.constraints[phase];
      const auto interior = std::stable_partition(list.begin(), list.end(), [&](Index c) {
        const Visit* const visits = &visits_[first_visit_[phase] + 4 * static_cast<std::size_t>(c)];
        return std::any_of(visits, visits + 4, [](const Visit& visit) { return visit.is_border; });
      });
      block.border_counts.push_back(static_cast<Index>(interior - list.begin()));
    }
  }
}

}  // namespace pbdsurg::cuda
