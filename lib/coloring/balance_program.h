// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind balance_coloring(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/random.h"
#include "pbdsurg/core/types.h"

#include "coloring/color_masks.h"

namespace pbdsurg {

/// How far the sizes of colours are from their mean.
struct Unevenness {
  std::uint64_t squares = 0;  ///< sum of squared distances from [floor, ceiling] of the mean
  Index largest = 0;
};

/// Sweeps over the colours above the mean. Those of one colour share no vertex, so its volunteers
/// move all at once, each to any colour that is free for it, and cannot clash: one phase a colour.
template <class Access>
struct BalanceProgram {
  Access constraints;
  std::uint64_t seed = 0;
  Index color_count = 0;             ///< >= 1
  Index colored_count = 0;           ///< constraints that are not overflow
  ColorMasks masks;                  ///< the colouring's
  Index* color_of = nullptr;         ///< [constraint_count]
  Index* sizes = nullptr;            ///< [color_count]
  Index* changes = nullptr;          ///< [color_count] zero at first: of sizes, in this sweep
  std::uint32_t* odds = nullptr;     ///< [color_count] of leaving, of 2^32
  Index* begins = nullptr;           ///< [color_count] into volunteers
  Index* counts = nullptr;           ///< [color_count] volunteers of each colour
  Index* volunteers = nullptr;       ///< [constraint_count]
  std::uint64_t* targets = nullptr;  ///< [masks.words] colours below the mean
  Unevenness* unevenness = nullptr;  ///< [3] zero at first

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    const Index floor = colored_count / color_count;
    const Index ceiling = floor + (colored_count % color_count != 0 ? 1 : 0);
    const Index tolerance = floor / kToleranceDivisor;
    const std::uint64_t even_enough =
        static_cast<std::uint64_t>(tolerance) * tolerance * static_cast<std::uint64_t>(color_count);
    for (std::uint32_t sweep = 0; sweep < kMaxSweeps; ++sweep) {
      Unevenness& uneven = unevenness[sweep % 3];
      for (Index color = team.worker(); color < color_count; color += team.worker_count()) {
        sizes[color] += changes[color];
        changes[color] = 0;
        counts[color] = 0;
        const Index off = sizes[color] > ceiling ? sizes[color] - ceiling
                          : sizes[color] < floor ? floor - sizes[color]
                                                 : 0;
        team.fetch_add(uneven.squares, static_cast<std::uint64_t>(std::int64_t{off} * off));
        team.fetch_max(uneven.largest, sizes[color]);
      }
      for (Index word = team.worker(); word < masks.words; word += team.worker_count()) {
        targets[word] = 0;
      }
      team.barrier();
      if (uneven.squares <= even_enough && uneven.largest <= ceiling + tolerance) {
        return;
      }
      const std::uint64_t sweep_seed = random_bits(seed, sweep);
      // Down to the ceiling and up to the floor by turns, until all lie between the two.
      const Index level = (sweep & 1) == 0 ? ceiling : floor;
      for (Index color = team.worker(); color < color_count; color += team.worker_count()) {
        // as many of a colour as it has too many, on average
        const std::int64_t surplus = sizes[color] > level ? sizes[color] - level : 0;
        odds[color] = surplus == 0 ? 0 : static_cast<std::uint32_t>((surplus << 32) / sizes[color]);
        begins[color] = 0;
        for (Index lower = 0; lower < color; ++lower) {
          begins[color] += sizes[lower] > level ? sizes[lower] : 0;
        }
        if (sizes[color] < level) {
          team.fetch_or(targets[color >> 6], std::uint64_t{1} << (color & 63));
        }
      }
      if (team.worker() == 0) {
        unevenness[(sweep + 1) % 3] = {};
      }
      team.barrier();
      for (Index c = team.worker(); c < constraints.count; c += team.worker_count()) {
        const Index color = color_of[c];
        if (color >= 0 && random_for(c, sweep_seed) >> 32 < odds[color]) {
          volunteers[begins[color] + team.fetch_add(counts[color], 1)] = c;
        }
      }
      team.barrier();
      for (Index color = 0; color < color_count; ++color) {
        // not by sizes, which the fastest may be changing for the next sweep
        if (odds[color] == 0) {
          continue;
        }
        for (Index i = team.worker(); i < counts[color]; i += team.worker_count()) {
          move(team, volunteers[begins[color] + i], color, level, sweep_seed);
        }
        team.barrier();
      }
    }
  }

 private:
  static constexpr std::uint32_t kMaxSweeps = 32;
  static constexpr Index kToleranceDivisor = 128;  // 0.8 % of the mean
  static constexpr int kRedraws = 7;

  // One mix: this runs over all constraints in every sweep.
  PBDSURG_DEVICE static std::uint64_t random_for(Index c, std::uint64_t sweep_seed) {
    return detail::mix_bits(sweep_seed, static_cast<std::uint64_t>(c));
  }

  template <class Team>
  PBDSURG_DEVICE void move(Team& team, Index c, Index color, Index level,
                           std::uint64_t sweep_seed) const {
    const auto ids = constraints[c];
    const Index target = draw_target(ids, level, next_random(random_for(c, sweep_seed)));
    if (target == kInvalidIndex) {
      return;
    }
    color_of[c] = target;
    for (const Index v : ids) {
      masks.word(v, color >> 6) &= ~(std::uint64_t{1} << (color & 63));
      masks.word(v, target >> 6) |= std::uint64_t{1} << (target & 63);
    }
    team.fetch_add(changes[color], -1);
    team.fetch_add(changes[target], 1);
  }

  // A free colour below the level, preferably one that lacks much.
  template <class Ids>
  PBDSURG_DEVICE Index draw_target(const Ids& ids, Index level, std::uint64_t random) const {
    const auto free_word = [&](int word) {
      return masks.free_word(ids, word, color_count) & targets[word];
    };
    const ColorDraw colors(masks.words, free_word);
    if (colors.empty()) {
      return kInvalidIndex;
    }
    Index target = colors.draw(random);
    for (int i = 0; i < kRedraws; ++i) {
      random = next_random(random);
      if (((random >> 32) * static_cast<std::uint64_t>(level)) >> 32 <
          static_cast<std::uint64_t>(level - sizes[target])) {
        break;
      }
      random = next_random(random);
      target = colors.draw(random);
    }
    return target;
  }

  // Knuth's linear congruential generator, whose upper half is used
  PBDSURG_DEVICE static std::uint64_t next_random(std::uint64_t random) {
    return random * 6364136223846793005u + 1442695040888963407u;
  }
};

}  // namespace pbdsurg
