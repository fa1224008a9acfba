// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind repair_coloring() and limit_colors(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"

#include "lib/coloring/claims.h"
#include "lib/coloring/color_holders.h"
#include "lib/coloring/color_masks.h"
#include "lib/coloring/team.h"

namespace pbdsurg {

/// Empties the highest colours, level by level: as many at once as hold few constraints, but at
/// least one. Where a level cannot be emptied, what is left of it takes as many colours more as it
/// needs, and that is the end.
template <class Access>
struct RepairProgram {
  Access constraints;
  std::uint64_t seed = 0;
  Index color_count = 0;          ///< more than the target
  Index target = 1;               ///< the end is at so many colours; >= 1
  bool gives_up = false;          ///< one level, down to the target; what is left of it stays
  bool swaps_with_two = false;    ///< RepairSwaps::with_two
  ColorMasks masks;               ///< the colouring's
  ClaimTable claims;              ///< of vertices: one slot
  ColorHolders holders;           ///< the colouring's
  Index* color_of = nullptr;      ///< [constraint_count]
  Index* sizes = nullptr;         ///< [color_count]
  Index* lists[2] = {};           ///< [constraint_count] each: those above the limit
  std::uint64_t* best = nullptr;  ///< [constraint_count] zero at first
  Index* counts = nullptr;        ///< [3] zero at first: lengths of the lists by turns

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    ClaimRounds rounds(claims, seed);
    int step = 0;
    for (Index top = color_count; top > target; ++step) {
      top = gives_up ? target : next_limit(top);
      for (Index c = team.worker(); c < constraints.count; c += team.worker_count()) {
        if (color_of[c] >= top) {
          lists[step & 1][team.fetch_add(counts[step % 3], 1)] = c;
        }
      }
      team.barrier();
      if (!empty_level(team, rounds, top, step)) {
        return;
      }
    }
  }

 private:
  static constexpr int kPatience = 16;         // steps without progress
  static constexpr Index kSwappingShare = 32;  // of all constraints
  static constexpr Index kLevelShare = 64;

  // The lowest limit above which there are few constraints.
  PBDSURG_DEVICE Index next_limit(Index top) const {
    Index limit = top - 1;
    Index above = sizes[limit];
    while (limit > target && above + sizes[limit - 1] <= constraints.count / kLevelShare) {
      --limit;
      above += sizes[limit];
    }
    return limit;
  }

  // Moves all that is listed below the limit. If that fails, the limit rises until it succeeds, or
  // what is left stays.
  // @return whether the limit held
  template <class Team>
  PBDSURG_DEVICE bool empty_level(Team& team, ClaimRounds& rounds, Index limit, int& step) const {
    Index top = limit;
    Index mark = counts[step % 3];
    int waited = 0;
    bool with_two = false;  // only where all else is stuck
    for (;; ++step) {
      const Index count = counts[step % 3];
      if (team.worker() == 0) {
        counts[(step + 2) % 3] = 0;
      }
      if (count == 0) {
        return top == limit;
      }
      // Swaps are a random walk that ends where there is room: worth it for a few, too slow for
      // many.
      const bool swapping = count <= constraints.count / kSwappingShare;
      // progress is a thirty-second less to do
      if (count <= mark - 1 - mark / 32) {
        mark = count;
        waited = 0;
      } else if (++waited > (swapping ? kPatience : 2)) {
        if (gives_up) {
          return false;
        }
        if (swaps_with_two && swapping && !with_two) {
          with_two = true;
        } else {
          ++top;
        }
        mark = count;
        waited = 0;
      }
      rounds.next(team);
      Index* list = lists[step & 1];
      // every pair of a constraint and a colour judges one plan; the best stays
      const std::int64_t pairs = std::int64_t{count} * top;
      for (std::int64_t i = team.worker(); i < pairs; i += team.worker_count()) {
        const auto at = static_cast<Index>(i / top);
        const Index c = list[at];
        Plan plan{static_cast<Index>(i - std::int64_t{at} * top)};
        // what is of a lower grade than one that is there need not be worked out
        if (color_of[c] >= top && find_blockers(c, plan) &&
            grade(plan) >= grade_of_key(team.peek(best[at])) &&
            find_new_colors(c, top, rounds.round(), with_two, plan) && (swapping || !plan.swaps)) {
          team.fetch_max(best[at], plan_key(c, plan, rounds.round()));
        }
      }
      team.barrier();
      for (Index i = team.worker(); i < count; i += team.worker_count()) {
        if (color_of[list[i]] < top) {
          // Done since the limit rose. It goes now: a swap may lift it above the limit again, and
          // then whoever does that lists it.
          list[i] = kInvalidIndex;
        } else if (best[i] != 0) {
          Plan plan{color_of_key(best[i])};
          find_blockers(list[i], plan);
          claim(team, list[i], plan, rounds.key(list[i]));
        }
      }
      team.barrier();
      Index* next = lists[(step + 1) & 1];
      for (Index i = team.worker(); i < count; i += team.worker_count()) {
        Index left = list[i];
        if (best[i] != 0) {
          left = carry_out(team, left, color_of_key(best[i]), top, with_two, rounds);
          best[i] = 0;
        }
        if (left != kInvalidIndex) {
          next[team.fetch_add(counts[(step + 1) % 3], 1)] = left;
        }
      }
      team.barrier();
    }
  }

  /// A colour for a constraint, and new colours for those around it that have it.
  struct Plan {
    Index color;
    int blocker_count = 0;
    Index blockers[2] = {};
    Index new_colors[2] = {};
    bool swaps = false;
    int swapped = 0;  ///< the blocker that is then above the limit in place of the constraint
  };

  // Fewest blockers first, swaps last.
  PBDSURG_DEVICE static std::uint64_t grade(const Plan& plan) {
    return static_cast<std::uint64_t>(plan.swaps ? 0 : 3 - plan.blocker_count);
  }

  // The largest is best: by grade, then at random.
  PBDSURG_DEVICE std::uint64_t plan_key(Index c, const Plan& plan, std::uint32_t round) const {
    const std::uint64_t random =
        random_bits(seed, static_cast<std::uint64_t>(c),
                    (std::uint64_t{round} << 32) | static_cast<std::uint32_t>(plan.color));
    return (grade(plan) << 62) | ((random >> 34) << 32) | static_cast<std::uint32_t>(plan.color);
  }
  PBDSURG_DEVICE static std::uint64_t grade_of_key(std::uint64_t key) { return key >> 62; }
  PBDSURG_DEVICE static Index color_of_key(std::uint64_t key) {
    return static_cast<Index>(key & 0xFFFFFFFFu);
  }

  // Who holds the plan's colour around constraint c; false if they are more than two.
  PBDSURG_DEVICE bool find_blockers(Index c, Plan& plan) const {
    const auto ids = constraints[c];
    constexpr int kBatch = 4;
    for (int first = 0; first < ids.size(); first += kBatch) {
      Index found[kBatch];
      for (int i = 0; i < kBatch; ++i) {
        found[i] = first + i < ids.size()
                       ? holders.find(ids[first + i], plan.color,
                                      masks.has(ids[first + i], plan.color), color_of)
                       : kInvalidIndex;
      }
      for (const Index blocker : found) {
        if (blocker == kInvalidIndex || (plan.blocker_count > 0 && plan.blockers[0] == blocker) ||
            (plan.blocker_count > 1 && plan.blockers[1] == blocker)) {
          continue;
        }
        if (plan.blocker_count == 2) {
          return false;
        }
        plan.blockers[plan.blocker_count++] = blocker;
      }
    }
    return true;
  }

  // Two blockers share no vertex, as they have one colour, so their new colours are independent.
  // One of them may swap with the constraint: the only one, or with_two either.
  PBDSURG_DEVICE bool find_new_colors(Index c, Index top, std::uint32_t round, bool with_two,
                                      Plan& plan) const {
    for (int i = 0; i < plan.blocker_count; ++i) {
      const auto ids = constraints[plan.blockers[i]];
      plan.new_colors[i] = draw_color(
          masks.words, [&](int word) { return masks.free_word(ids, word, top); },
          random_bits(seed, static_cast<std::uint64_t>(plan.blockers[i]),
                      (std::uint64_t{round} << 32) | static_cast<std::uint32_t>(c)));
      if (plan.new_colors[i] == kInvalidIndex) {
        if (plan.swaps || (plan.blocker_count > 1 && !with_two) || !may_swap(c, plan.blockers[i])) {
          return false;
        }
        plan.swaps = true;
        plan.swapped = i;
        plan.new_colors[i] = color_of[c];
      }
    }
    return true;
  }

  // Whether the colour of c is free for a neighbour once c leaves it.
  PBDSURG_DEVICE bool may_swap(Index c, Index neighbor) const {
    const auto ids = constraints[c];
    const Index color = color_of[c];
    bool free = true;
    for (const Index v : constraints[neighbor]) {
      bool shared = false;
      for (const Index own : ids) {
        shared = shared || own == v;
      }
      const bool has_color = masks.has(v, color);
      free = free && (shared || !has_color);
    }
    return free;
  }

  template <class Team>
  PBDSURG_DEVICE void claim(Team& team, Index c, const Plan& plan, std::uint32_t key) const {
    for (const Index v : constraints[c]) {
      team.fetch_max(claims.at(v, 0), key);
    }
    for (int i = 0; i < plan.blocker_count; ++i) {
      for (const Index v : constraints[plan.blockers[i]]) {
        team.fetch_max(claims.at(v, 0), key);
      }
    }
  }

  PBDSURG_DEVICE bool holds(Index c, std::uint32_t key) const {
    bool all = true;
    for (const Index v : constraints[c]) {
      const std::uint32_t largest = claims.at(v, 0);
      all = all && largest == key;
    }
    return all;
  }

  // Nobody else touches the vertices of a plan whose claims all stand, nor what lies at them.
  // Returns who is then left above the limit in place of c: c, the one it swapped with, or nobody.
  template <class Team>
  PBDSURG_DEVICE Index carry_out(Team& team, Index c, Index color, Index top, bool with_two,
                                 const ClaimRounds& rounds) const {
    const std::uint32_t key = rounds.key(c);
    if (!holds(c, key)) {
      return c;
    }
    Plan plan{color};
    find_blockers(c, plan);
    for (int i = 0; i < plan.blocker_count; ++i) {
      if (!holds(plan.blockers[i], key)) {
        return c;
      }
    }
    find_new_colors(c, top, rounds.round(), with_two, plan);
    // all leave before any arrives, as a swap hands over the same colour
    release(team, c, color_of[c]);
    for (int i = 0; i < plan.blocker_count; ++i) {
      release(team, plan.blockers[i], color);
      take(team, plan.blockers[i], plan.new_colors[i]);
    }
    take(team, c, color);
    return plan.swaps ? plan.blockers[plan.swapped] : kInvalidIndex;
  }

  // Nobody contends for these words, but a device need not wait for an atomic without a result.
  template <class Team>
  PBDSURG_DEVICE void release(Team& team, Index c, Index color) const {
    team.fetch_add(sizes[color], -1);
    for (const Index v : constraints[c]) {
      team.fetch_and(masks.word(v, color >> 6), ~(std::uint64_t{1} << (color & 63)));
    }
  }
  template <class Team>
  PBDSURG_DEVICE void take(Team& team, Index c, Index color) const {
    color_of[c] = color;
    team.fetch_add(sizes[color], 1);
    for (const Index v : constraints[c]) {
      team.fetch_or(masks.word(v, color >> 6), std::uint64_t{1} << (color & 63));
      if (holders.table != nullptr) {
        holders.at(v, color) = c;
      }
    }
  }
};

}  // namespace pbdsurg
