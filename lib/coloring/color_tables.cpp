// SPDX-License-Identifier: Apache-2.0
#include "coloring/color_tables.h"

#include <numeric>
#include <string>

#include "pbdsurg/core/error.h"

#include "coloring/color_masks.h"
#include "coloring/constraint_access.h"

namespace pbdsurg {
namespace {

[[noreturn]] void refuse_conflict(const Coloring& coloring, const ConstraintVertices& constraints) {
  const auto conflict = find_conflict(coloring, constraints);
  throw InvalidArgument("constraints " + std::to_string(conflict->first) + " and " +
                        std::to_string(conflict->second) + " both have colour " +
                        std::to_string(conflict->color) + " and share vertex " +
                        std::to_string(conflict->vertex) + "; the colouring must be valid");
}

}  // namespace

ColorTables make_color_tables(const Coloring& coloring, const ConstraintVertices& constraints) {
  check_constraints(constraints);
  if (coloring.color_of.size() != static_cast<std::size_t>(constraints.constraint_count())) {
    static_cast<void>(find_conflict(coloring, constraints));  // says so
  }
  ColorTables tables;
  tables.sizes = color_sizes(coloring);
  tables.words = (coloring.color_count + 63) / 64;
  tables.masks.assign(static_cast<std::size_t>(constraints.vertex_count) * tables.words, 0);
  const ColorMasks masks{tables.masks.data(), tables.words};
  with_arity(constraints, [&](const auto& access) {
    for (Index c = 0; c < access.count; ++c) {
      const Index color = coloring.color_of[c];
      if (color == kOverflowColor) {
        continue;
      }
      for (const Index v : access[c]) {
        if (masks.has(v, color)) {
          refuse_conflict(coloring, constraints);
        }
        masks.word(v, color >> 6) |= std::uint64_t{1} << (color & 63);
      }
    }
  });
  return tables;
}

Index count_above(const std::vector<Index>& sizes, Index limit) {
  return std::accumulate(sizes.begin() + limit, sizes.end(), Index{0});
}

}  // namespace pbdsurg
