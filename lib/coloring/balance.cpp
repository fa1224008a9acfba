// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/balance.h"

#include <utility>
#include <vector>

#include "lib/coloring/balance_program.h"
#include "lib/coloring/chain_balance.h"
#include "lib/coloring/claims.h"
#include "lib/coloring/color_gaps.h"
#include "lib/coloring/color_tables.h"
#include "lib/coloring/constraint_access.h"
#include "lib/coloring/thread_team.h"

namespace pbdsurg {

void balance_coloring(Coloring& coloring, const ConstraintVertices& constraints, std::uint64_t seed,
                      const Executor& executor) {
  ColorTables tables = make_color_tables(coloring, constraints);
  const Index colored = count_from(tables.sizes, 0);
  if (colored == 0) {
    return;
  }
  Coloring given = coloring;
  const auto colors = static_cast<std::size_t>(coloring.color_count);
  std::vector<Index> changes(colors), begins(colors), counts(colors);
  std::vector<std::uint32_t> odds(colors);
  std::vector<Index> volunteers(coloring.color_of.size()), drawn(coloring.color_of.size());
  const int slots = slots_for(coloring.color_count, kBalanceSlots);
  std::vector<std::uint32_t> keys(static_cast<std::size_t>(constraints.vertex_count) * slots);
  std::vector<std::uint64_t> targets(static_cast<std::size_t>(tables.words));
  Unevenness unevenness[3];
  with_arity(constraints, [&](const auto& access) {
    BalanceProgram<std::decay_t<decltype(access)>> program;
    program.constraints = access;
    program.seed = seed;
    program.color_count = coloring.color_count;
    program.colored_count = colored;
    program.masks = {tables.masks.data(), tables.words};
    program.claims = {keys.data(), keys.size(), slots, rank_bits_for(access.count)};
    program.color_of = coloring.color_of.data();
    program.sizes = tables.sizes.data();
    program.changes = changes.data();
    program.odds = odds.data();
    program.begins = begins.data();
    program.counts = counts.data();
    program.volunteers = volunteers.data();
    program.drawn = drawn.data();
    program.targets = targets.data();
    program.unevenness = unevenness;
    run_team(executor, program);
  });
  close_color_gaps(coloring);
  if (!is_even(color_sizes(coloring))) {
    coloring = more_even_coloring(std::move(given), coloring, constraints);
  }
}

}  // namespace pbdsurg
