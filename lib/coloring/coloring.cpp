// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/coloring.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

void check_size(const Coloring& coloring, const ConstraintVertices& constraints) {
  if (coloring.color_of.size() != static_cast<std::size_t>(constraints.constraint_count())) {
    throw InvalidArgument("a colouring of " + std::to_string(coloring.color_of.size()) +
                          " constraints does not fit " +
                          std::to_string(constraints.constraint_count()) + " constraints");
  }
}

}  // namespace

std::vector<Index> color_sizes(const Coloring& coloring) {
  if (coloring.color_count < 0) {
    throw InvalidArgument("a colouring has " + std::to_string(coloring.color_count) + " colours");
  }
  std::vector<Index> sizes(static_cast<std::size_t>(coloring.color_count), 0);
  for (std::size_t c = 0; c < coloring.color_of.size(); ++c) {
    const Index color = coloring.color_of[c];
    if (color == kOverflowColor) {
      continue;
    }
    if (color < 0 || color >= coloring.color_count) {
      throw InvalidArgument("constraint " + std::to_string(c) + " has colour " +
                            std::to_string(color) + "; colours must be in [0, " +
                            std::to_string(coloring.color_count) + ")");
    }
    ++sizes[color];
  }
  return sizes;
}

std::optional<ColorConflict> find_conflict(const Coloring& coloring,
                                           const ConstraintVertices& constraints) {
  check_constraints(constraints);
  check_size(coloring, constraints);
  // constraints of each colour in ascending order, then the last one seen at each vertex
  const std::vector<Index> sizes = color_sizes(coloring);
  std::vector<Index> begin(sizes.size() + 1, 0);
  std::partial_sum(sizes.begin(), sizes.end(), begin.begin() + 1);
  std::vector<Index> members(static_cast<std::size_t>(begin.back()));
  std::vector<Index> next(begin.begin(), begin.end() - 1);
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    if (coloring.color_of[c] != kOverflowColor) {
      members[next[coloring.color_of[c]]++] = c;
    }
  }
  struct Visit {
    Index color = kInvalidIndex;
    Index constraint = kInvalidIndex;
  };
  std::vector<Visit> last(static_cast<std::size_t>(constraints.vertex_count));
  for (const Index c : members) {
    const Index color = coloring.color_of[c];
    for (const Index v : constraints[c]) {
      if (last[v].color == color) {
        return ColorConflict{color, last[v].constraint, c, v};
      }
      last[v] = {color, c};
    }
  }
  return std::nullopt;
}

ColoringStatistics measure_coloring(const Coloring& coloring,
                                    const ConstraintVertices& constraints) {
  ColoringStatistics result;
  result.clique_bound = clique_bound(constraints);
  check_size(coloring, constraints);
  std::vector<Index> sizes = color_sizes(coloring);
  result.constraints = constraints.constraint_count();
  result.colors = coloring.color_count;
  const auto colored = std::accumulate(sizes.begin(), sizes.end(), Index{0});
  result.overflow = result.constraints - colored;
  if (colored == 0) {
    return result;
  }
  const auto count = static_cast<double>(sizes.size());
  const double mean = colored / count;
  double squares = 0;
  for (const Index size : sizes) {
    squares += (size - mean) * (size - mean);
  }
  result.relative_deviation = std::sqrt(squares / count) / mean;
  std::sort(sizes.begin(), sizes.end(), std::greater<>());
  result.max_over_mean = sizes.front() / mean;
  const auto tenth = static_cast<std::ptrdiff_t>((sizes.size() + 9) / 10);
  const auto total = static_cast<std::ptrdiff_t>(sizes.size());
  const std::ptrdiff_t last = std::min(tenth, total - tenth);  // one colour is its own tenth
  const auto share = [&](std::ptrdiff_t from, std::ptrdiff_t to) {
    return std::accumulate(sizes.begin() + from, sizes.begin() + to, 0.0) / colored;
  };
  result.top10 = share(0, tenth);
  result.last10 = share(total - last, total);
  result.mid80 = share(tenth, total - last);
  return result;
}

}  // namespace pbdsurg
