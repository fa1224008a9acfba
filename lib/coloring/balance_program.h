// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind balance_coloring(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

#include "lib/coloring/claims.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/team.h"

namespace pbdsurg {

/// How far the sizes of colours are from their mean.
struct Unevenness {
  std::uint64_t squares = 0;  ///< sum of squared distances from [floor, ceiling] of the mean
  std::uint64_t surplus = 0;  ///< constraints above the ceiling of the mean
  Index largest = 0;
};

/// Sweeps in which some constraints of each colour above the mean volunteer to move to a free
/// colour below it.
///
/// Volunteers of one colour share no vertex, so they move at once without a clash: one phase a
/// colour, for as long as they are many. When few are left, those of all colours draw and claim at
/// once, and the rare ones that clash stay.
template <class Access>
struct BalanceProgram {
  Access constraints;
  std::uint64_t seed = 0;
  Index color_count = 0;             ///< >= 1
  Index colored_count = 0;           ///< constraints that are not overflow
  ColorMasks masks;                  ///< the colouring's
  ClaimTable claims;                 ///< of colours
  Index* color_of = nullptr;         ///< [constraint_count]
  Index* sizes = nullptr;            ///< [color_count]
  Index* changes = nullptr;          ///< [color_count] zero at first: of sizes, in this sweep
  std::uint32_t* odds = nullptr;     ///< [color_count] of leaving, of 2^32
  Index* begins = nullptr;           ///< [color_count] into volunteers
  Index* counts = nullptr;           ///< [color_count] volunteers of each colour
  Index* volunteers = nullptr;       ///< [constraint_count]
  Index* drawn = nullptr;            ///< [constraint_count]
  std::uint64_t* targets = nullptr;  ///< [masks.words] colours below the mean
  Unevenness* unevenness = nullptr;  ///< [3] zero at first

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    const Index floor = colored_count / color_count;
    const Index ceiling = floor + (colored_count % color_count != 0 ? 1 : 0);
    const Index tolerance = floor / kToleranceDivisor;
    const std::uint64_t even_enough =
        static_cast<std::uint64_t>(tolerance) * tolerance * static_cast<std::uint64_t>(color_count);
    ClaimRounds rounds(claims, seed);
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
        team.fetch_add(uneven.surplus, static_cast<std::uint64_t>(
                                           sizes[color] > ceiling ? sizes[color] - ceiling : 0));
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
      if (uneven.surplus > static_cast<std::uint64_t>(colored_count / kCrowd)) {
        move_color_by_color(team, level, sweep_seed);
      } else {
        move_at_once(team, rounds, level, sweep_seed);
      }
    }
  }

 private:
  static constexpr std::uint32_t kMaxSweeps = 32;
  static constexpr Index kToleranceDivisor = 64;  // 1.6 % of the mean
  static constexpr int kRedraws = 7;
  static constexpr Index kCrowd = 8;  // at most one in so many volunteers at once

  template <class Team>
  PBDSURG_DEVICE void move_color_by_color(Team& team, Index level, std::uint64_t sweep_seed) const {
    for (Index c = team.worker(); c < constraints.count; c += team.worker_count()) {
      if (volunteers_now(c, sweep_seed)) {
        const Index color = color_of[c];
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
        const Index c = volunteers[begins[color] + i];
        const auto ids = constraints[c];
        const Index target = draw_target(ids, level, random_for(c, sweep_seed));
        if (target != kInvalidIndex) {
          move(team, c, ids, target);
        }
      }
      team.barrier();
    }
  }

  template <class Team>
  PBDSURG_DEVICE void move_at_once(Team& team, ClaimRounds& rounds, Index level,
                                   std::uint64_t sweep_seed) const {
    rounds.next(team);
    const auto begin =
        static_cast<Index>(std::int64_t{constraints.count} * team.group() / team.group_count());
    const auto end = static_cast<Index>(std::int64_t{constraints.count} * (team.group() + 1) /
                                        team.group_count());
    const auto claimants = team.split(
        end - begin,
        [&](Index i) {
          const Index c = begin + i;
          const bool moves =
              volunteers_now(c, sweep_seed) && claim(team, c, level, sweep_seed, rounds.key(c));
          return Sorted{moves ? Place::one : Place::nowhere, c};
        },
        volunteers + begin);
    team.barrier();
    for (Index i = team.lane(); i < claimants.one; i += team.lane_count()) {
      const Index c = volunteers[begin + i];
      const auto ids = constraints[c];
      if (holds(ids, drawn[c], rounds.key(c))) {
        move(team, c, ids, drawn[c]);
      }
    }
    team.barrier();
  }

  PBDSURG_DEVICE bool volunteers_now(Index c, std::uint64_t sweep_seed) const {
    const Index color = color_of[c];
    return color >= 0 && random_for(c, sweep_seed) >> 32 < odds[color];
  }

  // One mix: this runs over all constraints in every sweep.
  PBDSURG_DEVICE static std::uint64_t random_for(Index c, std::uint64_t sweep_seed) {
    return detail::mix_bits(sweep_seed, static_cast<std::uint64_t>(c));
  }

  template <class Team>
  PBDSURG_DEVICE bool claim(Team& team, Index c, Index level, std::uint64_t sweep_seed,
                            std::uint32_t key) const {
    const auto ids = constraints[c];
    drawn[c] = draw_target(ids, level, random_for(c, sweep_seed));
    if (drawn[c] == kInvalidIndex) {
      return false;
    }
    for (const Index v : ids) {
      team.fetch_max(claims.at(v, drawn[c]), key);
    }
    return true;
  }

  template <class Ids>
  PBDSURG_DEVICE bool holds(const Ids& ids, Index target, std::uint32_t key) const {
    for (const Index v : ids) {
      if (claims.at(v, target) != key) {
        return false;
      }
    }
    return true;
  }

  template <class Team, class Ids>
  PBDSURG_DEVICE void move(Team& team, Index c, const Ids& ids, Index target) const {
    const Index color = color_of[c];
    color_of[c] = target;
    for (const Index v : ids) {
      team.fetch_and(masks.word(v, color >> 6), ~(std::uint64_t{1} << (color & 63)));
      team.fetch_or(masks.word(v, target >> 6), std::uint64_t{1} << (target & 63));
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
    // the upper half of `random` has decided who volunteers
    random = next_random(random);
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
