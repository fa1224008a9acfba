// SPDX-License-Identifier: Apache-2.0
#include "lib/coloring/color_tables.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "pbdsurg/base/error.h"

#include "lib/coloring/color_masks.h"
#include "lib/coloring/constraint_access.h"

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
  tables.words = coloring.color_count / 64 + (coloring.color_count % 64 != 0 ? 1 : 0);
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

HolderTable::HolderTable(const Coloring& coloring, const ConstraintVertices& constraints)
    : width_(coloring.color_count) {
  if (!ColorHolders::fits(constraints.vertex_count, width_, constraints.vertices.size())) {
    lists_ = find_vertex_constraints(constraints);
    return;
  }
  table_.resize(static_cast<std::size_t>(constraints.vertex_count) * width_);
  const ColorHolders holders = view();
  with_arity(constraints, [&](const auto& access) {
    for (Index c = 0; c < access.count; ++c) {
      for (const Index v : access[c]) {
        if (coloring.color_of[c] != kOverflowColor) {
          holders.at(v, coloring.color_of[c]) = c;
        }
      }
    }
  });
}

ColorHolders HolderTable::view() {
  return {table_.empty() ? nullptr : table_.data(), width_, lists_.offsets.data(),
          lists_.entries.data()};
}

Index count_from(const std::vector<Index>& sizes, Index first) {
  return std::accumulate(sizes.begin() + first, sizes.end(), Index{0});
}

std::vector<Index> numbers_by_size(const std::vector<Index>& sizes) {
  std::vector<Index> order(sizes.size());
  std::iota(order.begin(), order.end(), Index{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return sizes[a] > sizes[b]; });
  std::vector<Index> number(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) {
    number[order[i]] = static_cast<Index>(i);
  }
  return number;
}

}  // namespace pbdsurg
