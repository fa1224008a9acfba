// SPDX-License-Identifier: Apache-2.0
#include "bench/table1/colorings.h"

#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg::bench {
namespace {

// Of Vivace's palettes: on a mesh whose edges take 31 colours, divisors of 2.0 to 2.5 gave the
// shares of the paper's "random disc".
constexpr double kPaletteShrink = 2.2;

}  // namespace

const char* name_of(Palette palette) noexcept {
  return palette == Palette::clique_bound ? "clique_bound" : "conflicts";
}

std::vector<ColoringOptions> table1_colorings() {
  std::vector<ColoringOptions> colorings;
  for (const GreedyOrder order : {GreedyOrder::natural, GreedyOrder::largest_valence,
                                  GreedyOrder::smallest_last, GreedyOrder::saturation}) {
    colorings.push_back({.order = order});
  }
  colorings.push_back({.algorithm = ColoringAlgorithm::luby});
  colorings.push_back({.algorithm = ColoringAlgorithm::jones_plassmann});
  colorings.push_back(
      {.algorithm = ColoringAlgorithm::random_disc, .disc = {Palette::conflicts, kPaletteShrink}});
  colorings.push_back({.algorithm = ColoringAlgorithm::random_disc});
  for (const ColoringAlgorithm algorithm :
       {ColoringAlgorithm::greedy, ColoringAlgorithm::random_disc}) {
    colorings.push_back({.algorithm = algorithm, .repair = true, .balance = true});
  }
  return colorings;
}

Coloring color_validly(const ConstraintVertices& constraints, const ColoringOptions& options) {
  Coloring coloring = color_constraints(constraints, options);
  if (const auto conflict = find_conflict(coloring, constraints)) {
    throw Error(std::string(name_of(options.algorithm)) + ": constraints " +
                std::to_string(conflict->first) + " and " + std::to_string(conflict->second) +
                " of colour " + std::to_string(conflict->color) + " share vertex " +
                std::to_string(conflict->vertex));
  }
  return coloring;
}

}  // namespace pbdsurg::bench
