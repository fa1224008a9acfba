// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/random_disc.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/coloring/color_gaps.h"
#include "lib/coloring/constraint_access.h"
#include "lib/coloring/disc_palette.h"
#include "lib/coloring/random_disc_program.h"
#include "lib/coloring/thread_team.h"

namespace pbdsurg {
namespace {

std::vector<Index> conflict_palettes(const ConstraintVertices& constraints, double shrink) {
  const IndexLists lists = find_vertex_constraints(constraints);
  std::vector<Index> palettes(static_cast<std::size_t>(constraints.constraint_count()));
  with_arity(constraints, [&](const auto& access) {
    for (Index c = 0; c < access.count; ++c) {
      palettes[c] = palette_for(
          count_conflicts(access, c, lists.offsets.data(), lists.entries.data()), shrink);
    }
  });
  return palettes;
}

}  // namespace

void check_disc_options(const RandomDiscOptions& options) {
  if (options.palette != Palette::clique_bound && options.palette != Palette::conflicts) {
    throw InvalidArgument("unknown palette " + std::to_string(static_cast<int>(options.palette)));
  }
  if (!(options.shrink >= 1) || !std::isfinite(options.shrink)) {
    throw InvalidArgument("shrink is " + std::to_string(options.shrink) +
                          "; it must be >= 1 and finite");
  }
  if (options.shrink != RandomDiscOptions{}.shrink && options.palette != Palette::conflicts) {
    throw InvalidArgument("shrink is " + std::to_string(options.shrink) +
                          ", which nothing would read; it needs Palette::conflicts");
  }
}

Coloring color_random_disc(const ConstraintVertices& constraints, std::uint64_t seed,
                           const Executor& executor, const RandomDiscOptions& options) {
  check_disc_options(options);
  const Index bound = clique_bound(constraints);
  const Index count = constraints.constraint_count();
  Coloring coloring;
  coloring.color_of.assign(static_cast<std::size_t>(count), kInvalidIndex);
  if (count == 0) {
    return coloring;
  }

  std::vector<Index> palettes;
  Index largest = std::max(bound, 1);
  if (options.palette == Palette::conflicts) {
    palettes = conflict_palettes(constraints, options.shrink);
    largest = *std::max_element(palettes.begin(), palettes.end());
  }
  const int words = (largest + 63) / 64;
  const int slots = slots_for(largest, kDiscSlots);
  const auto vertex_count = static_cast<std::size_t>(constraints.vertex_count);
  std::vector<std::uint64_t> masks(vertex_count * words);
  std::vector<std::uint32_t> keys(vertex_count * slots);
  std::vector<Index> drawn(count), list(count), other_list(count), pending;
  for (int window = 0; window == 0 || !pending.empty(); ++window) {
    std::fill(masks.begin(), masks.end(), 0);
    std::fill(keys.begin(), keys.end(), 0);
    Index more[3] = {};
    with_arity(constraints, [&](const auto& access) {
      RandomDiscProgram<std::decay_t<decltype(access)>> program;
      program.constraints = access;
      program.pending = window == 0 ? nullptr : pending.data();
      program.pending_count = window == 0 ? count : static_cast<Index>(pending.size());
      program.seed = window_seed(seed, window);
      program.window = 64 * words * window;
      program.palettes = window == 0 && !palettes.empty() ? palettes.data() : nullptr;
      program.palette = window == 0 ? largest : 1;
      program.masks = {masks.data(), words};
      program.claims = {keys.data(), keys.size(), slots, rank_bits_for(count)};
      program.color_of = coloring.color_of.data();
      program.drawn = drawn.data();
      program.lists[0] = list.data();
      program.lists[1] = other_list.data();
      program.more = more;
      run_team(executor, program);
    });
    pending.clear();
    for (Index c = 0; c < count; ++c) {
      if (coloring.color_of[c] == kInvalidIndex) {
        pending.push_back(c);
      }
    }
  }
  close_color_gaps(coloring);
  return coloring;
}

}  // namespace pbdsurg
