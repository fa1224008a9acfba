// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind color_random_disc(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

#include "lib/coloring/claims.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/team.h"

namespace pbdsurg {

/// Colours constraints with colours [window, window + 64 * masks.words). Those for which all of
/// these are taken stay uncoloured, for another run with the next window.
template <class Access>
struct RandomDiscProgram {
  Access constraints;
  const Index* pending = nullptr;  ///< [pending_count] what to colour, nullptr for all
  Index pending_count = 0;
  std::uint64_t seed = 0;
  Index window = 0;
  const Index* palettes = nullptr;  ///< [constraint_count] colours to start with, or nullptr
  Index palette = 1;                ///< the same for all, where there are no palettes
  ColorMasks masks;                 ///< zero at first
  ClaimTable claims;                ///< of colours
  Index* color_of = nullptr;        ///< [constraint_count] kInvalidIndex where not coloured yet
  Index* drawn = nullptr;           ///< [constraint_count]
  Index* lists[2] = {};             ///< [pending_count] each
  Index* more = nullptr;            ///< [3] zero at first

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    const auto begin =
        static_cast<Index>(std::int64_t{pending_count} * team.group() / team.group_count());
    const auto end =
        static_cast<Index>(std::int64_t{pending_count} * (team.group() + 1) / team.group_count());
    Index count = end - begin;
    ClaimRounds rounds(claims, seed);
    for (bool first = true;; first = false) {
      rounds.next(team);
      const Index* list = lists[rounds.round() & 1] + begin;
      const auto item = [&](Index i) {
        return first ? (pending == nullptr ? begin + i : pending[begin + i]) : list[i];
      };
      for (Index i = team.lane(); i < count; i += team.lane_count()) {
        const Index c = item(i);
        const auto ids = constraints[c];
        const Index color = draw(ids, c, rounds.round());
        drawn[c] = color;
        if (color != kInvalidIndex) {
          const std::uint32_t key = rounds.key(c);
          for (const Index v : ids) {
            team.fetch_max(claims.at(v, color), key);
          }
        }
      }
      team.barrier();
      const auto losers = team.split(
          count,
          [&](Index i) {
            const Index c = item(i);
            const bool lost = drawn[c] != kInvalidIndex && !settle(team, c, rounds.key(c));
            return Sorted{lost ? Place::one : Place::nowhere, c};
          },
          lists[(rounds.round() + 1) & 1] + begin);
      count = losers.one;
      if (team.lane() == 0 && count > 0) {
        team.raise(more[rounds.round() % 3]);
      }
      if (team.worker() == 0) {
        more[(rounds.round() + 1) % 3] = 0;
      }
      team.barrier();
      if (more[rounds.round() % 3] == 0) {
        return;
      }
    }
  }

 private:
  // From the palette while it has a free colour; otherwise it grows up to the lowest that is free.
  template <class Ids>
  PBDSURG_DEVICE Index draw(const Ids& ids, Index c, std::uint32_t round) const {
    const Index size = palettes == nullptr ? palette : palettes[c];
    const Index color = draw_color(
        masks.words, [&](int i) { return masks.free_word(ids, i, size); },
        random_bits(seed, static_cast<std::uint64_t>(c), round));
    if (color != kInvalidIndex) {
      return color;
    }
    for (int i = 0; i < masks.words; ++i) {
      const std::uint64_t word = masks.free_word(ids, i, 64 * masks.words);
      if (word != 0) {
        return 64 * i + lowest_bit(word);
      }
    }
    return kInvalidIndex;
  }

  template <class Team>
  PBDSURG_DEVICE bool settle(Team& team, Index c, std::uint32_t key) const {
    const auto ids = constraints[c];
    const Index color = drawn[c];
    for (const Index v : ids) {
      if (claims.at(v, color) != key) {
        return false;
      }
    }
    color_of[c] = window + color;
    for (const Index v : ids) {
      team.fetch_or(masks.word(v, color >> 6), std::uint64_t{1} << (color & 63));
    }
    return true;
  }
};

}  // namespace pbdsurg
