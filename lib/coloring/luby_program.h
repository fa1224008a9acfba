// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind color_luby(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

#include "lib/coloring/claims.h"
#include "lib/coloring/team.h"

namespace pbdsurg {

template <class Access>
struct LubyProgram {
  Access constraints;
  std::uint64_t seed = 0;
  ClaimTable claims;             ///< of vertices: one slot
  Index* last_color = nullptr;   ///< [vertex_count] kInvalidIndex at first
  Index* color_of = nullptr;     ///< [constraint_count] kInvalidIndex at first
  Index* candidates[2] = {};     ///< [constraint_count] each: who may still join this colour
  Index* waiting[2] = {};        ///< [constraint_count] each: who must wait for the next
  Index* more_rounds = nullptr;  ///< [3] zero at first
  Index* more_colors = nullptr;  ///< [3] zero at first

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    const auto begin =
        static_cast<Index>(std::int64_t{constraints.count} * team.group() / team.group_count());
    const auto end = static_cast<Index>(std::int64_t{constraints.count} * (team.group() + 1) /
                                        team.group_count());
    ClaimRounds rounds(claims, seed);
    Index start_count = end - begin;
    for (Index color = 0;; ++color) {
      if (team.worker() == 0) {
        more_colors[(color + 1) % 3] = 0;
      }
      Index count = start_count;
      Index waiting_count = 0;
      for (bool first = true;; first = false) {
        rounds.next(team);
        const Index* list = candidates[rounds.round() & 1] + begin;
        Index* claimants = candidates[(rounds.round() + 1) & 1] + begin;
        const auto counts = team.split(
            count,
            [&](Index i) {
              const Index c = !first       ? list[i]
                              : color == 0 ? begin + i
                                           : waiting[color & 1][begin + i];
              if (color_of[c] != kInvalidIndex) {
                return Sorted{Place::nowhere, c};
              }
              return Sorted{claim(team, c, color, rounds.key(c)) ? Place::one : Place::two, c};
            },
            claimants, waiting[(color + 1) & 1] + begin + waiting_count);
        count = counts.one;
        waiting_count += counts.two;
        if (team.worker() == 0) {
          more_rounds[(rounds.round() + 1) % 3] = 0;
        }
        team.barrier();
        for (Index i = team.lane(); i < count; i += team.lane_count()) {
          if (!settle(claimants[i], color, rounds.key(claimants[i]))) {
            team.raise(more_rounds[rounds.round() % 3]);
          }
        }
        if (team.lane() == 0 && waiting_count > 0) {
          team.raise(more_colors[color % 3]);
        }
        team.barrier();
        if (more_rounds[rounds.round() % 3] == 0) {
          break;
        }
      }
      if (more_colors[color % 3] == 0) {
        return;
      }
      start_count = waiting_count;
    }
  }

 private:
  // Unless a neighbour joined this colour.
  template <class Team>
  PBDSURG_DEVICE bool claim(Team& team, Index c, Index color, std::uint32_t key) const {
    const auto ids = constraints[c];
    for (const Index v : ids) {
      if (last_color[v] == color) {
        return false;
      }
    }
    for (const Index v : ids) {
      team.fetch_max(claims.at(v, 0), key);
    }
    return true;
  }

  PBDSURG_DEVICE bool settle(Index c, Index color, std::uint32_t key) const {
    const auto ids = constraints[c];
    for (const Index v : ids) {
      if (claims.at(v, 0) != key) {
        return false;
      }
    }
    color_of[c] = color;
    for (const Index v : ids) {
      last_color[v] = color;
    }
    return true;
  }
};

}  // namespace pbdsurg
