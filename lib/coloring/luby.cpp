// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/luby.h"

#include <algorithm>
#include <vector>

#include "lib/coloring/constraint_access.h"
#include "lib/coloring/luby_program.h"
#include "lib/coloring/thread_team.h"

namespace pbdsurg {

Coloring color_luby(const ConstraintVertices& constraints, std::uint64_t seed,
                    const Executor& executor) {
  check_constraints(constraints);
  const Index count = constraints.constraint_count();
  Coloring coloring;
  coloring.color_of.assign(static_cast<std::size_t>(count), kInvalidIndex);
  if (count == 0) {
    return coloring;
  }
  std::vector<std::uint32_t> keys(static_cast<std::size_t>(constraints.vertex_count));
  std::vector<Index> last_color(keys.size(), kInvalidIndex);
  std::vector<Index> lists(static_cast<std::size_t>(count) * 4);
  Index more[6] = {};
  with_arity(constraints, [&](const auto& access) {
    LubyProgram<std::decay_t<decltype(access)>> program;
    program.constraints = access;
    program.seed = seed;
    program.claims = {keys.data(), keys.size(), 1, rank_bits_for(count)};
    program.last_color = last_color.data();
    program.color_of = coloring.color_of.data();
    for (int i = 0; i < 2; ++i) {
      program.candidates[i] = lists.data() + static_cast<std::size_t>(count) * i;
      program.waiting[i] = lists.data() + static_cast<std::size_t>(count) * (2 + i);
    }
    program.more_rounds = more;
    program.more_colors = more + 3;
    run_team(executor, program);
  });
  coloring.color_count = 1 + *std::max_element(coloring.color_of.begin(), coloring.color_of.end());
  return coloring;
}

}  // namespace pbdsurg
