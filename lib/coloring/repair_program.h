// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The parallel program behind repair_coloring() and limit_colors(); see team.h for what a team is.

#include <cstdint>

#include "pbdsurg/core/host_device.h"
#include "pbdsurg/core/random.h"
#include "pbdsurg/core/types.h"

#include "coloring/claims.h"
#include "coloring/color_masks.h"
#include "coloring/team.h"

namespace pbdsurg {

/// Moves constraints of colours [limit, ...) below the limit. Where nothing moves any more, the
/// limit rises by one, up to last_limit; what is still above that stays where it is.
template <class Access>
struct RepairProgram {
  Access constraints;
  std::uint64_t seed = 0;
  Index limit = 1;
  Index last_limit = 1;
  ColorMasks masks;                ///< the colouring's
  ClaimTable claims;               ///< of vertices: one slot
  const Index* offsets = nullptr;  ///< [vertex_count + 1] the constraints at each vertex,
  const Index* entries = nullptr;  ///< in any order
  Index* color_of = nullptr;       ///< [constraint_count]
  Index* lists[2] = {};            ///< [constraints above the limit] each
  std::uint64_t* best = nullptr;   ///< [constraints above the limit] zero at first
  Index* counts = nullptr;         ///< [3] zero at first: lengths of the lists by turns

  template <class Team>
  PBDSURG_DEVICE void operator()(Team& team) const {
    for (Index c = team.worker(); c < constraints.count; c += team.worker_count()) {
      if (color_of[c] >= limit) {
        lists[0][team.fetch_add(counts[0], 1)] = c;
      }
    }
    team.barrier();
    ClaimRounds rounds(claims, seed);
    Index top = limit;
    Index mark = counts[0];
    int waited = 0;
    for (int step = 0;; ++step) {
      const Index count = counts[step % 3];
      if (count == 0) {
        return;
      }
      // Swaps are a random walk that ends where there is room: worth it for a few, too slow for
      // many.
      const bool swapping = count <= constraints.count / kSwappingShare;
      // progress is a thirty-second less to do
      if (count <= mark - 1 - mark / 32) {
        mark = count;
        waited = 0;
      } else if (++waited > (swapping ? kPatience : 2)) {
        if (top == last_limit) {
          return;
        }
        ++top;
        mark = count;
        waited = 0;
      }
      rounds.next(team);
      if (team.worker() == 0) {
        counts[(step + 2) % 3] = 0;
      }
      const Index* list = lists[step & 1];
      // tasks judge the plans of a constraint for some colours; the best plan stays
      const Index tasks_each = (top + Team::kColorsPerTask - 1) / Team::kColorsPerTask;
      const std::int64_t tasks = std::int64_t{count} * tasks_each;
      for (std::int64_t task = team.worker(); task < tasks; task += team.worker_count()) {
        const auto at = static_cast<Index>(task / tasks_each);
        const auto part = static_cast<Index>(task - std::int64_t{at} * tasks_each);
        if (color_of[list[at]] >= top) {
          const std::uint64_t key = judge<Team::kColorsPerTask>(
              list[at], part * Team::kColorsPerTask, top, swapping, rounds.round());
          team.fetch_max(best[at], key);
        }
      }
      team.barrier();
      for (Index i = team.worker(); i < count; i += team.worker_count()) {
        if (best[i] != 0) {
          Plan plan{color_of_key(best[i])};
          find_blockers(list[i], plan);
          claim(team, list[i], plan, rounds.key(list[i]));
        }
      }
      team.barrier();
      Index* next = lists[(step + 1) & 1];
      for (Index i = team.worker(); i < count; i += team.worker_count()) {
        const Index left =
            best[i] != 0 ? carry_out(list[i], color_of_key(best[i]), top, rounds) : list[i];
        if (left != kInvalidIndex && color_of[left] >= top) {
          next[team.fetch_add(counts[(step + 1) % 3], 1)] = left;
        }
        best[i] = 0;
      }
      team.barrier();
    }
  }

 private:
  static constexpr int kPatience = 24;  // steps without progress
  static constexpr Index kSwappingShare = 64;

  /// A colour for a constraint, and new colours for those around it that have it.
  struct Plan {
    Index color;
    int blocker_count = 0;
    Index blockers[2] = {};
    Index new_colors[2] = {};
    bool swaps = false;  ///< the one blocker is then above the limit in place of the constraint

    /// Counts up to three: more than two is too many.
    PBDSURG_DEVICE void add_blocker(Index blocker) {
      if (blocker_count > 2 || (blocker_count > 0 && blockers[0] == blocker) ||
          (blocker_count > 1 && blockers[1] == blocker)) {
        return;
      }
      if (blocker_count < 2) {
        blockers[blocker_count] = blocker;
      }
      ++blocker_count;
    }
  };

  // The largest is best: fewest blockers first, swaps last, otherwise at random.
  PBDSURG_DEVICE std::uint64_t plan_key(Index c, const Plan& plan, std::uint32_t round) const {
    const std::uint64_t random =
        random_bits(seed, static_cast<std::uint64_t>(c),
                    (std::uint64_t{round} << 32) | static_cast<std::uint32_t>(plan.color));
    const auto grade = static_cast<std::uint64_t>(plan.swaps ? 0 : 3 - plan.blocker_count);
    return (grade << 62) | ((random >> 34) << 32) | static_cast<std::uint32_t>(plan.color);
  }
  PBDSURG_DEVICE static Index color_of_key(std::uint64_t key) {
    return static_cast<Index>(key & 0xFFFFFFFFu);
  }

  // The key of the best plan for constraint c among kCount colours, zero if there is none.
  template <int kCount>
  PBDSURG_DEVICE std::uint64_t judge(Index c, Index first, Index top, bool swapping,
                                     std::uint32_t round) const {
    Plan plans[kCount];
    for (Index i = 0; i < kCount; ++i) {
      plans[i].color = first + i;
    }
    for (const Index v : constraints[c]) {
      if (kCount == 1 && !masks.has(v, first)) {
        continue;
      }
      for (Index e = offsets[v]; e < offsets[v + 1]; ++e) {
        const Index i = color_of[entries[e]] - first;
        if (i >= 0 && i < kCount) {
          plans[i].add_blocker(entries[e]);
        }
      }
    }
    std::uint64_t best_key = 0;
    for (Index i = 0; i < kCount && first + i < top; ++i) {
      if (plans[i].blocker_count <= 2 && find_new_colors(c, top, round, plans[i]) &&
          (swapping || !plans[i].swaps)) {
        const std::uint64_t key = plan_key(c, plans[i], round);
        best_key = key > best_key ? key : best_key;
      }
    }
    return best_key;
  }

  PBDSURG_DEVICE Index find_blocker(Index vertex, Index color) const {
    if (masks.has(vertex, color)) {
      for (Index e = offsets[vertex]; e < offsets[vertex + 1]; ++e) {
        if (color_of[entries[e]] == color) {
          return entries[e];
        }
      }
    }
    return kInvalidIndex;
  }

  // Who holds the plan's colour around constraint c.
  PBDSURG_DEVICE void find_blockers(Index c, Plan& plan) const {
    for (const Index v : constraints[c]) {
      const Index blocker = find_blocker(v, plan.color);
      if (blocker != kInvalidIndex) {
        plan.add_blocker(blocker);
      }
    }
  }

  // Two blockers share no vertex, as they have one colour, so their new colours are independent.
  PBDSURG_DEVICE bool find_new_colors(Index c, Index top, std::uint32_t round, Plan& plan) const {
    for (int i = 0; i < plan.blocker_count; ++i) {
      const auto ids = constraints[plan.blockers[i]];
      plan.new_colors[i] = draw_color(
          masks.words, [&](int word) { return masks.free_word(ids, word, top); },
          random_bits(seed, static_cast<std::uint64_t>(plan.blockers[i]),
                      (std::uint64_t{round} << 32) | static_cast<std::uint32_t>(c)));
      if (plan.new_colors[i] == kInvalidIndex) {
        plan.swaps = plan.blocker_count == 1 && may_swap(c, plan.blockers[0]);
        plan.new_colors[i] = color_of[c];
        return plan.swaps;
      }
    }
    return true;
  }

  // Whether the colour of c is free for a neighbour once c leaves it.
  PBDSURG_DEVICE bool may_swap(Index c, Index neighbor) const {
    const auto ids = constraints[c];
    for (const Index v : constraints[neighbor]) {
      bool shared = false;
      for (const Index own : ids) {
        shared = shared || own == v;
      }
      if (!shared && masks.has(v, color_of[c])) {
        return false;
      }
    }
    return true;
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
    for (const Index v : constraints[c]) {
      if (claims.at(v, 0) != key) {
        return false;
      }
    }
    return true;
  }

  // Nobody else touches the vertices of a plan whose claims all stand, nor what lies at them.
  // Returns who is then left above the limit in place of c: c, the one it swapped with, or nobody.
  PBDSURG_DEVICE Index carry_out(Index c, Index color, Index top, const ClaimRounds& rounds) const {
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
    find_new_colors(c, top, rounds.round(), plan);
    release(c, color_of[c]);
    for (int i = 0; i < plan.blocker_count; ++i) {
      release(plan.blockers[i], color);
      take(plan.blockers[i], plan.new_colors[i]);
    }
    take(c, color);
    return plan.swaps ? plan.blockers[0] : kInvalidIndex;
  }

  PBDSURG_DEVICE void release(Index c, Index color) const {
    for (const Index v : constraints[c]) {
      masks.word(v, color >> 6) &= ~(std::uint64_t{1} << (color & 63));
    }
  }
  PBDSURG_DEVICE void take(Index c, Index color) const {
    color_of[c] = color;
    for (const Index v : constraints[c]) {
      masks.word(v, color >> 6) |= std::uint64_t{1} << (color & 63);
    }
  }
};

}  // namespace pbdsurg
