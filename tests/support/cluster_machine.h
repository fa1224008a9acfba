// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A cluster of blocks on the host: executes the image of a program as the kernel does, one warp or
/// message at a time, in any order that its barriers allow.

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"

#include "lib/device/cluster_layout.h"
#include "lib/device/cluster_shapes.h"
#include "tests/support/toy_sweep.h"

namespace pbdsurg::cuda::testing {

class ClusterMachine {
 public:
  ClusterMachine(const ClusterSizes& sizes, std::span<const std::uint32_t> image, bool is_damped)
      : sizes_(sizes), sections_(sizes), image_(image), is_damped_(is_damped) {}

  /// Sweeps over the values of all places.
  /// @param seed  of the order
  /// @return      what went wrong, or nothing
  std::string sweep(std::vector<ToyValue>& values, int sweep_count, std::uint64_t seed) {
    try {
      start(values);
      check_layout();
      run(sweep_count, seed);
      finish(values, sweep_count);
    } catch (const Failure& failure) {
      return failure.what;
    }
    return {};
  }

 private:
  struct Failure {
    std::string what;
  };
  struct Slot {
    bool is_full = false;
    Index place = kInvalidIndex;
    ToyValue value = 0;
  };
  struct Barrier {
    int completed = 0;
    bool is_armed = false;
    std::int64_t pending = 0;  // bytes; less than none before it is armed

    void arm(std::uint32_t bytes) {
      is_armed = true;
      pending += bytes;
      complete();
    }
    void arrive() {
      pending -= 16;
      complete();
    }
    void complete() {
      if (is_armed && pending == 0) {
        is_armed = false;
        ++completed;
      }
    }
  };
  struct Block {
    ClusterBlock header;
    std::vector<Slot> slots;
    std::vector<Barrier> barriers;
    std::vector<ClusterRound> rounds;
    int sweep = 0;
    std::size_t round = 0;
    std::vector<std::uint32_t> warps;  // of the round, that have not projected yet: first threads
  };
  struct Message {
    std::uint32_t target;
    Slot slot;
  };

  static void require(bool condition, const std::string& what) {
    if (!condition) {
      throw Failure{what};
    }
  }
  template <class T>
  [[nodiscard]] T read(std::size_t at) const {
    std::array<std::uint32_t, sizeof(T) / 4> numbers;
    require(at + numbers.size() <= image_.size(), "what is read lies in the image");
    std::copy_n(image_.begin() + static_cast<std::ptrdiff_t>(at), numbers.size(), numbers.begin());
    return std::bit_cast<T>(numbers);
  }
  [[nodiscard]] Index place_at(std::size_t block, std::uint32_t slot) const {
    return read<Index>(sections_.places + blocks_[block].header.first_place + slot);
  }

  void start(const std::vector<ToyValue>& values) {
    blocks_.assign(static_cast<std::size_t>(sizes_.block_count), {});
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      Block& block = blocks_[b];
      block.header = read<ClusterBlock>(sections_.blocks + b * sizeof(ClusterBlock) / 4);
      const auto& header = block.header;
      require(header.home_count <= header.slot_count &&
                  header.slot_count <= static_cast<std::uint32_t>(sizes_.slot_room) &&
                  header.round_count <= static_cast<std::uint32_t>(sizes_.round_room),
              "a block's memory suffices");
      block.slots.resize(header.slot_count);
      block.barriers.resize(static_cast<std::size_t>(sizes_.phase_count) + 1);
      for (std::uint32_t slot = 0; slot < header.slot_count; ++slot) {
        const Index place = place_at(b, slot);
        require(place >= 0 && static_cast<std::size_t>(place) < values.size(),
                "each slot is some vertex's");
        if (slot < header.home_count) {
          block.slots[slot] = {true, place, values[static_cast<std::size_t>(place)]};
          require(read<std::uint32_t>(sections_.homes + static_cast<std::size_t>(place)) ==
                      (static_cast<std::uint32_t>(b) << 16 | slot),
                  "homes are known");
        }
      }
      for (std::uint32_t r = 0; r < header.round_count; ++r) {
        block.rounds.push_back(read<ClusterRound>(sections_.rounds + 4 * (header.first_round + r)));
      }
    }
  }

  // No two rounds share words or multipliers, and each is as large as a block has room for.
  void check_layout() const {
    std::map<std::size_t, std::size_t> words;
    std::map<std::size_t, std::size_t> multipliers;
    const auto take = [](auto& ranges, std::size_t first, std::size_t count, std::size_t room) {
      if (count > 0) {
        const auto next = ranges.lower_bound(first);
        require(next == ranges.end() || first + count <= next->first, "rounds lie apart");
        require(next == ranges.begin() || std::prev(next)->second <= first, "rounds lie apart");
        require(first + count <= room, "rounds lie in the image");
        ranges[first] = first + count;
      }
    };
    for (const Block& block : blocks_) {
      for (const ClusterRound& round : block.rounds) {
        const std::size_t count = std::size_t{round.count} * round.words + round.border;
        require(round.count > 0 || round.phase == 0, "no round is without constraints");
        require(round.border <= round.count && round.count <= sizes_.thread_count &&
                    count <= static_cast<std::size_t>(sizes_.round_words),
                "a round fits");
        take(words, round.first, count, sizes_.word_room);
        const auto* const shape = shape_of(static_cast<PhaseKind>(round.kind));
        require(shape->words(is_damped_) == round.words, "words are as many as the kernel's");
        take(multipliers, round.first_multiplier,
             static_cast<std::size_t>(round.count * shape->multiplier_count),
             sizes_.multiplier_room);
      }
    }
  }

  void run(int sweep_count, std::uint64_t seed) {
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      start_sweep(b);
    }
    std::uint64_t draw = 0;
    for (;;) {
      // what can be done now: a warp of a block, a block that goes on, or a message
      std::vector<std::pair<std::size_t, std::size_t>> actions;
      for (std::size_t b = 0; b < blocks_.size(); ++b) {
        Block& block = blocks_[b];
        if (block.sweep == sweep_count) {
          continue;
        }
        if (block.round == block.rounds.size()) {
          if (block.barriers.back().completed == block.sweep + 1) {
            actions.emplace_back(b, kGoOn);
          }
          continue;
        }
        const ClusterRound& round = block.rounds[block.round];
        for (std::size_t i = 0; i < block.warps.size(); ++i) {
          if (block.warps[i] >= round.border ||
              block.barriers[round.phase].completed == block.sweep + 1) {
            actions.emplace_back(b, i);
          }
        }
      }
      const std::size_t count = actions.size() + messages_.size();
      if (count == 0) {
        break;
      }
      const auto choice =
          static_cast<std::size_t>(random_unit(seed, ++draw, 0) * static_cast<double>(count));
      if (choice >= actions.size()) {
        deliver(choice - actions.size());
      } else if (const auto [b, what] = actions[choice]; what == kGoOn) {
        ++blocks_[b].sweep;
        if (blocks_[b].sweep < sweep_count) {
          start_sweep(b);
        }
      } else {
        project_warp(b, what);
      }
    }
    for (const Block& block : blocks_) {
      require(block.sweep == sweep_count, "all blocks come to the end");
    }
  }

  void start_sweep(std::size_t b) {
    Block& block = blocks_[b];
    for (std::size_t phase = 0; phase < block.barriers.size(); ++phase) {
      require(block.barriers[phase].completed == block.sweep, "barriers complete once a sweep");
      block.barriers[phase].arm(
          read<std::uint32_t>(sections_.arrivals + b * block.barriers.size() + phase));
    }
    block.round = 0;
    start_round(block);
  }

  static void start_round(Block& block) {
    for (; block.round < block.rounds.size(); ++block.round) {
      for (std::uint32_t first = 0; first < block.rounds[block.round].count; first += 32) {
        block.warps.push_back(first);
      }
      if (!block.warps.empty()) {
        break;
      }
    }
  }

  void project_warp(std::size_t b, std::size_t warp) {
    Block& block = blocks_[b];
    const std::uint32_t first = block.warps[warp];
    block.warps.erase(block.warps.begin() + static_cast<std::ptrdiff_t>(warp));
    const ClusterRound& round = block.rounds[block.round];
    for (std::uint32_t lane = first; lane < std::min<std::uint32_t>(first + 32, round.count);
         ++lane) {
      project(b, round, lane);
    }
    if (block.warps.empty()) {
      ++block.round;
      start_round(block);
    }
  }

  void project(std::size_t b, const ClusterRound& round, std::uint32_t lane) {
    Block& block = blocks_[b];
    const ClusterShape& shape = *shape_of(static_cast<PhaseKind>(round.kind));
    const auto word = [&](std::uint32_t w) {
      return read<std::array<std::uint32_t, 4>>(sections_.words +
                                                4 * (round.first + w * round.count + lane));
    };
    std::vector<std::uint32_t> numbers;
    for (std::uint32_t w = 0; w < round.words; ++w) {
      const auto part = word(w);
      numbers.insert(numbers.end(), part.begin(), part.end());
    }
    const auto corners = static_cast<std::size_t>(shape.corner_count);
    std::vector<std::uint32_t> halves;
    std::vector<ToyValue> values;
    std::vector<Index> places;
    for (std::size_t k = 0; k < corners; ++k) {
      halves.push_back(numbers[k / 2] >> (16 * (k % 2)) & 0xffff);
      const std::uint32_t at = halves[k] & kSlotMask;
      require(at < block.slots.size(), "a corner's slot is the block's");
      Slot& slot = block.slots[at];
      require(slot.is_full, "a vertex is there when it is read");
      require(slot.place == place_at(b, at), "a vertex is in its slot");
      slot.is_full = false;
      values.push_back(slot.value);
      places.push_back(slot.place);
    }
    if (numbers[2] != kRemovedConstraint) {
      std::vector<std::uint32_t> parameters(
          numbers.begin() + 2, numbers.begin() + 2 + shape.packed_parameters(is_damped_));
      if (shape.kind == PhaseKind::distance) {
        parameters.push_back(numbers[1]);
      }
      project_toy(values, parameters);
    }
    for (std::size_t k = 0; k < corners; ++k) {
      const Slot moved{true, places[k], values[k]};
      if ((halves[k] & kLeaves) == 0) {
        block.slots[halves[k] & kSlotMask] = moved;
      } else {
        require(lane < round.border, "what leaves has a target");
        const std::uint32_t target = word(round.words)[k];
        require(target >> 28 != b, "what leaves goes to another block");
        messages_.push_back({target, moved});
      }
    }
  }

  void deliver(std::size_t message) {
    const auto [target, slot] = messages_[message];
    messages_.erase(messages_.begin() + static_cast<std::ptrdiff_t>(message));
    require(target >> 28 < blocks_.size(), "a target's block is of the cluster");
    Block& there = blocks_[target >> 28];
    const std::uint32_t at = target & 0xffff;
    const std::uint32_t phase = target >> 16 & 0xfff;
    require(at < there.slots.size() && phase < there.barriers.size(), "a target is the block's");
    require(!there.slots[at].is_full, "what a slot held was read before the next comes");
    there.slots[at] = slot;
    there.barriers[phase].arrive();
  }

  void finish(std::vector<ToyValue>& values, int sweep_count) const {
    std::vector<int> stored(values.size(), 0);
    for (std::size_t b = 0; b < blocks_.size(); ++b) {
      const Block& block = blocks_[b];
      for (const Barrier& barrier : block.barriers) {
        require(barrier.completed == sweep_count && !barrier.is_armed && barrier.pending == 0,
                "as much arrives as is waited for");
      }
      for (std::uint32_t slot = 0; slot < block.header.slot_count; ++slot) {
        const bool is_home = slot < block.header.home_count;
        require(block.slots[slot].is_full == is_home, "all vertices come home");
        if (is_home) {
          const auto place = static_cast<std::size_t>(place_at(b, slot));
          values[place] = block.slots[slot].value;
          ++stored[place];
        }
      }
    }
    require(std::ranges::all_of(stored, [](int times) { return times == 1; }),
            "each vertex has one home");
  }

  static constexpr std::size_t kGoOn = ~std::size_t{0};

  ClusterSizes sizes_;
  ClusterSections sections_;
  std::span<const std::uint32_t> image_;
  bool is_damped_;
  std::vector<Block> blocks_;
  std::vector<Message> messages_;
};

}  // namespace pbdsurg::cuda::testing
