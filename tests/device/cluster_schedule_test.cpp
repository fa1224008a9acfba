// SPDX-License-Identifier: Apache-2.0
// Schedules are made, and followed, on the host: what is here needs no device.
#include "lib/device/cluster_schedule.h"

#include <algorithm>
#include <map>
#include <vector>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace pbdsurg::cuda {
namespace {

// Phases of pairs and quadruples of near places that share none within a phase.
std::vector<std::vector<SweepConstraint>> make_phases(Index place_count, int phase_count,
                                                      std::uint64_t seed) {
  std::vector<std::vector<SweepConstraint>> phases(static_cast<std::size_t>(phase_count));
  std::uint64_t draw = 0;
  for (std::size_t p = 0; p < phases.size(); ++p) {
    std::vector<bool> used(static_cast<std::size_t>(place_count), false);
    const int corners = p % 2 == 0 ? 2 : 4;
    for (Index i = 0; i < place_count; ++i) {
      const auto base = static_cast<Index>(random_unit(seed, ++draw, p) * place_count);
      SweepConstraint constraint;
      constraint.places.fill(kInvalidIndex);
      bool fits = true;
      for (int k = 0; k < corners; ++k) {
        const auto offset = static_cast<Index>(random_unit(seed, ++draw, p) * 40);
        const Index place = (base + offset) % place_count;
        fits = fits && !used[place] &&
               std::ranges::find(constraint.places, place) == constraint.places.end();
        constraint.places[k] = place;
      }
      if (fits) {
        for (int k = 0; k < corners; ++k) {
          used[constraint.places[k]] = true;
        }
        phases[p].push_back(constraint);
      }
    }
  }
  return phases;
}

}  // namespace

// Would catch a vertex sent to the wrong block, slot or phase, one that is read where it is not, a
// constraint that nobody or two project, and an arrival that nobody or one too many waits for.
TEST_CASE("cluster schedule: each constraint finds its vertices where they were sent") {
  const Index place_count = GENERATE(60, 1000);
  const int block_count = GENERATE(1, 3, 16);
  const auto phases = make_phases(place_count, 11, 5);
  const ClusterSchedule schedule(phases, place_count, std::vector<PlaceRun>{{0, place_count}},
                                 block_count);
  REQUIRE(schedule.block_count() == block_count);

  std::vector<std::map<Index, Index>> held(static_cast<std::size_t>(block_count));  // slot -> place
  std::size_t homes = 0;
  for (std::size_t b = 0; b < held.size(); ++b) {
    const auto block = static_cast<Index>(b);
    const ClusterSlots& slots = schedule.slots();
    homes += static_cast<std::size_t>(slots.home_count(block));
    for (Index slot = 0; slot < slots.home_count(block); ++slot) {
      held[b][slot] = slots.places(block)[slot];
    }
  }
  CHECK(homes == static_cast<std::size_t>(place_count));
  const auto start = held;
  const auto phase_count = static_cast<Index>(phases.size());
  std::vector<std::vector<Index>> arrivals(held.size(), std::vector<Index>(phases.size() + 1, 0));
  for (Index phase = 0; phase < phase_count; ++phase) {
    std::vector<int> projected(phases[phase].size(), 0);
    auto after = held;
    for (std::size_t b = 0; b < held.size(); ++b) {
      const auto block = static_cast<Index>(b);
      for (std::size_t i = 0; i < schedule.constraints(block, phase).size(); ++i) {
        const Index n = schedule.constraints(block, phase)[i];
        const Index c = n - schedule.number(phase, 0);
        ++projected[c];
        for (int k = 0; k < 4; ++k) {
          const Index place = phases[phase][c].places[k];
          if (place == kInvalidIndex) {
            break;
          }
          const Index slot = Index{schedule.constraint(n).slots[static_cast<std::size_t>(k)]};
          REQUIRE(held[b].contains(slot));
          REQUIRE(held[b][slot] == place);
          CHECK(schedule.slots().places(block)[slot] == place);
          const VertexTarget& target = schedule.constraint(n).targets[static_cast<std::size_t>(k)];
          const bool leaves = target.block != b;
          CHECK((!leaves || static_cast<Index>(i) < schedule.border_count(block, phase)));
          after[b].erase(slot);
          after[target.block][target.slot] = place;
          arrivals[target.block][target.phase] += leaves;
          CHECK(target.phase > phase);
        }
      }
    }
    CHECK(std::ranges::all_of(projected, [](int times) { return times == 1; }));
    held = after;
  }
  CHECK(held == start);  // all are home again
  for (std::size_t b = 0; b < held.size(); ++b) {
    for (Index phase = 0; phase <= phase_count; ++phase) {
      CHECK(schedule.arrivals(static_cast<Index>(b), phase) == arrivals[b][phase]);
    }
  }
}

// What comes from another block is waited for by the warps that hold border constraints alone.
TEST_CASE("cluster schedule: a constraint that receives is among those of the border") {
  const auto phases = make_phases(800, 9, 2);
  const ClusterSchedule schedule(phases, 800, std::vector<PlaceRun>{{0, 800}}, 8);
  std::vector<std::map<std::pair<Index, Index>, bool>> receives(8);  // phase, slot
  for (std::size_t b = 0; b < 8; ++b) {
    for (Index phase = 0; phase < 9; ++phase) {
      for (const Index n : schedule.constraints(static_cast<Index>(b), phase)) {
        const Index c = n - schedule.number(phase, 0);
        for (int k = 0; k < 4 && phases[phase][c].places[k] != kInvalidIndex; ++k) {
          const VertexTarget& target = schedule.constraint(n).targets[static_cast<std::size_t>(k)];
          if (target.block != b) {
            receives[target.block][{target.phase, target.slot}] = true;
          }
        }
      }
    }
  }
  std::size_t received = 0;
  for (std::size_t b = 0; b < 8; ++b) {
    const auto block = static_cast<Index>(b);
    for (Index phase = 0; phase < 9; ++phase) {
      for (std::size_t i = 0; i < schedule.constraints(block, phase).size(); ++i) {
        const Index n = schedule.constraints(block, phase)[i];
        const Index c = n - schedule.number(phase, 0);
        for (int k = 0; k < 4 && phases[phase][c].places[k] != kInvalidIndex; ++k) {
          if (receives[b].contains(
                  {phase, Index{schedule.constraint(n).slots[static_cast<std::size_t>(k)]}})) {
            ++received;
            CHECK(static_cast<Index>(i) < schedule.border_count(block, phase));
          }
        }
      }
    }
  }
  CHECK(received > 100);
}

// Would catch a body that came later, and that nothing joins to others, in one block alone; and a
// vertex of a cut away from its neighbours.
TEST_CASE("cluster schedule: what came later is shared out, too") {
  constexpr Index kFirst = 400, kGuest = 200, kBlocks = 8;
  std::vector<std::vector<SweepConstraint>> phases(2);
  for (Index place = 0; place + 1 < kFirst + kGuest; ++place) {
    if (place + 1 != kFirst) {
      phases[place % 2].push_back({{place, place + 1, kInvalidIndex, kInvalidIndex}});
    }
  }
  const Index cut = kFirst + kGuest;  // between others of one block
  phases[1].push_back({{10, cut, kInvalidIndex, kInvalidIndex}});
  std::erase_if(phases[1], [](const SweepConstraint& constraint) {
    return constraint.places[0] == 9 && constraint.places[1] == 10;
  });
  const ClusterSchedule schedule(phases, cut + 1,
                                 std::vector<PlaceRun>{{0, kFirst}, {kFirst, kGuest}}, kBlocks);
  for (Index block = 0; block < kBlocks; ++block) {
    CHECK(schedule.slots().home_count(block) < 2 * (kFirst + kGuest) / kBlocks);
  }
  CHECK(schedule.slots().home(cut) == schedule.slots().home(10));
}

// Would catch constraints that come one after another to the block that they are nearest to, until
// that has no slots left, although others have.
TEST_CASE("cluster schedule: what comes goes elsewhere before a block is out of slots") {
  constexpr Index kPlaces = 400, kBlocks = 4, kNew = 300;
  std::vector<std::vector<SweepConstraint>> phases(2);
  for (Index place = 0; place + 1 < kPlaces; ++place) {
    phases[place % 2].push_back({{place, place + 1, kInvalidIndex, kInvalidIndex}});
  }
  phases.emplace_back();
  ClusterSchedule schedule(phases, kPlaces, std::vector<PlaceRun>{{0, kPlaces}}, kBlocks);
  constexpr Index kSlotRoom = 200;
  for (Index i = 0; i < kNew; ++i) {  // a vertex that hangs from one of the first block
    const Index place = kPlaces + i;
    const Index n = schedule.add(i < 50 ? 2 : i % 2);
    const Index from = i < 50 ? i : place - 1;
    const ClusterSchedule::Placement placement{n, {{from, place, kInvalidIndex, kInvalidIndex}}};
    REQUIRE(schedule.follow({&placement, 1}, place + 1, 100, kSlotRoom));
  }
  for (Index block = 0; block < kBlocks; ++block) {
    CHECK(static_cast<Index>(schedule.slots().places(block).size()) <= kSlotRoom);
  }
}

}  // namespace pbdsurg::cuda
