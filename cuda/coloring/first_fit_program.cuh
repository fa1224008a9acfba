// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// First fit in a given order, as parallel as the order allows (Jones, Plassmann 1993).

#include <cstdint>

#include "pbdsurg/base/types.h"

#include "lib/coloring/color_masks.h"

namespace pbdsurg::cuda {

/// A constraint is coloured when it is the first of those left at each of its vertices. Colours are
/// those of one window; what finds none free stays uncoloured, and what has a colour is passed
/// over.
template <class Access>
struct FirstFitProgram {
  Access constraints;
  Index vertex_count = 0;
  Index window = 0;
  const Index* offsets = nullptr;  ///< [vertex_count + 1] the constraints at each vertex,
  const Index* entries = nullptr;  ///< in the order of colouring
  ColorMasks masks;                ///< zero at first
  Index* color_of = nullptr;       ///< [constraint_count] kInvalidIndex where not coloured yet
  Index* next = nullptr;           ///< [vertex_count] the first entry that is left; zero at first
  Index* ready = nullptr;   ///< [constraint_count] vertices at which it is the first; zero at first
  Index* queue = nullptr;   ///< [constraint_count]
  Index* pushed = nullptr;  ///< [3] zero at first

  template <class Team>
  __device__ void operator()(Team& team) const {
    for (Index v = team.worker(); v < vertex_count; v += team.worker_count()) {
      announce(team, v, 0, 0);
    }
    for (Index c = team.worker(); c < constraints.count; c += team.worker_count()) {
      if (constraints[c].size() == 0) {
        queue[team.fetch_add(pushed[0], 1)] = c;
      }
    }
    team.barrier();
    Index begin = 0;
    Index end = pushed[0];
    for (int round = 1; begin < end; ++round) {
      if (team.worker() == 0) {
        pushed[(round + 1) % 3] = 0;
      }
      for (Index i = begin + team.worker(); i < end; i += team.worker_count()) {
        const Index c = queue[i];
        const auto ids = constraints[c];
        if (color_of[c] == kInvalidIndex) {
          take_lowest(c, ids);
        }
        for (const Index v : ids) {
          announce(team, v, round, end);
        }
      }
      team.barrier();
      begin = end;
      end += pushed[round % 3];
    }
  }

 private:
  // The next constraint at a vertex has become its first. Only the one before it comes here.
  template <class Team>
  __device__ void announce(Team& team, Index v, int round, Index queue_end) const {
    const Index entry = offsets[v] + next[v]++;
    if (entry < offsets[v + 1]) {
      const Index c = entries[entry];
      if (team.fetch_add(ready[c], 1) + 1 == constraints[c].size()) {
        queue[queue_end + team.fetch_add(pushed[round % 3], 1)] = c;
      }
    }
  }

  template <class Ids>
  __device__ void take_lowest(Index c, const Ids& ids) const {
    for (int i = 0; i < masks.words; ++i) {
      const std::uint64_t word = masks.free_word(ids, i, 64 * masks.words);
      if (word != 0) {
        const int bit = lowest_bit(word);
        color_of[c] = window + 64 * i + bit;
        for (const Index v : ids) {
          masks.word(v, i) |= std::uint64_t{1} << bit;
        }
        return;
      }
    }
  }
};

}  // namespace pbdsurg::cuda
