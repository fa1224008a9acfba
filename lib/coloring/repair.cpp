// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/repair.h"

#include <algorithm>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/coloring/color_gaps.h"
#include "lib/coloring/color_tables.h"
#include "lib/coloring/constraint_access.h"
#include "lib/coloring/repair_program.h"
#include "lib/coloring/thread_team.h"

namespace pbdsurg {
namespace {

// Down to the target or as near as it gets; with gives_up, what does not fit stays above it.
void lower_colors(Coloring& coloring, const ConstraintVertices& constraints, ColorTables& tables,
                  Index target, bool gives_up, RepairSwaps swaps, std::uint64_t seed,
                  const Executor& executor) {
  HolderTable holders(coloring, constraints);
  const std::size_t count = coloring.color_of.size();
  std::vector<std::uint32_t> keys(static_cast<std::size_t>(constraints.vertex_count));
  std::vector<Index> list(count), other_list(count);
  std::vector<std::uint64_t> best(count);
  Index counts[3] = {};
  with_arity(constraints, [&](const auto& access) {
    RepairProgram<std::decay_t<decltype(access)>> program;
    program.constraints = access;
    program.seed = seed;
    program.color_count = coloring.color_count;
    program.target = target;
    program.gives_up = gives_up;
    program.swaps_with_two = swaps == RepairSwaps::with_two;
    program.masks = {tables.masks.data(), tables.words};
    program.claims = {keys.data(), keys.size(), 1, rank_bits_for(access.count)};
    program.holders = holders.view();
    program.color_of = coloring.color_of.data();
    program.sizes = tables.sizes.data();
    program.lists[0] = list.data();
    program.lists[1] = other_list.data();
    program.best = best.data();
    program.counts = counts;
    run_team(executor, program);
  });
}

void sort_colors(Coloring& coloring, ColorTables& tables, const ConstraintVertices& constraints) {
  const std::vector<Index> number = numbers_by_size(tables.sizes);
  for (Index& color : coloring.color_of) {
    color = color == kOverflowColor ? kOverflowColor : number[color];
  }
  tables = make_color_tables(coloring, constraints);
}

}  // namespace

void repair_coloring(Coloring& coloring, const ConstraintVertices& constraints, std::uint64_t seed,
                     const Executor& executor, RepairSwaps swaps) {
  ColorTables tables = make_color_tables(coloring, constraints);
  const Index bound = clique_bound(constraints);
  if (coloring.color_count > bound) {
    lower_colors(coloring, constraints, tables, std::max(bound, 1), false, swaps, seed, executor);
  }
  close_color_gaps(coloring);
}

void limit_colors(Coloring& coloring, const ConstraintVertices& constraints, Index max_colors,
                  std::uint64_t seed, const Executor& executor) {
  if (max_colors < 1) {
    throw InvalidArgument("max_colors is " + std::to_string(max_colors) + "; it must be >= 1");
  }
  ColorTables tables = make_color_tables(coloring, constraints);
  if (coloring.color_count <= max_colors) {
    return;
  }
  sort_colors(coloring, tables, constraints);
  lower_colors(coloring, constraints, tables, max_colors, true, RepairSwaps::with_one, seed,
               executor);
  for (Index& color : coloring.color_of) {
    color = color >= max_colors ? kOverflowColor : color;
  }
  close_color_gaps(coloring);
}

}  // namespace pbdsurg
