// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/color.h"

#include <string>

#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/balance.h"
#include "pbdsurg/coloring/jones_plassmann.h"
#include "pbdsurg/coloring/luby.h"
#include "pbdsurg/coloring/repair.h"

#include "lib/base/executor_state.h"
#include "lib/coloring/coloring_device.h"
#include "lib/coloring/coloring_options.h"
#include "lib/coloring/disc_palette.h"

namespace pbdsurg {
namespace {

Coloring color_by_name(const ConstraintVertices& constraints, const ColoringOptions& options) {
  switch (options.algorithm) {
    case ColoringAlgorithm::greedy:
      return color_greedy(constraints, options.order);
    case ColoringAlgorithm::luby:
      return color_luby(constraints, options.seed, options.executor);
    case ColoringAlgorithm::jones_plassmann:
      return color_jones_plassmann(constraints, options.seed);
    case ColoringAlgorithm::random_disc:
      return color_random_disc(constraints, options.seed, options.executor, options.disc);
  }
  return {};  // checked before
}

// Null where the host is to colour.
ColoringDevice* find_device(const ColoringOptions& options) {
  const ExecutorState* const state = options.executor.state();
  const bool is_sequential =
      options.algorithm == ColoringAlgorithm::greedy &&
      (options.order == GreedyOrder::smallest_last || options.order == GreedyOrder::saturation);
  if (state == nullptr || is_sequential) {
    return nullptr;
  }
  return dynamic_cast<ColoringDevice*>(state->device());
}

}  // namespace

void check_coloring_options(const ColoringOptions& options) {
  switch (options.algorithm) {
    case ColoringAlgorithm::greedy:
    case ColoringAlgorithm::luby:
    case ColoringAlgorithm::jones_plassmann:
    case ColoringAlgorithm::random_disc:
      break;
    default:
      throw InvalidArgument("unknown colouring algorithm " +
                            std::to_string(static_cast<int>(options.algorithm)));
  }
  switch (options.order) {
    case GreedyOrder::natural:
    case GreedyOrder::largest_valence:
    case GreedyOrder::smallest_last:
    case GreedyOrder::saturation:
      break;
    default:
      throw InvalidArgument("unknown greedy order " +
                            std::to_string(static_cast<int>(options.order)));
  }
  check_disc_options(options.disc);
  if (options.order != GreedyOrder::natural && options.algorithm != ColoringAlgorithm::greedy) {
    throw InvalidArgument(std::string("order is ") + name_of(options.order) +
                          ", which nothing would read; it needs the algorithm greedy, not " +
                          name_of(options.algorithm));
  }
  if (options.disc.palette != Palette::clique_bound &&
      options.algorithm != ColoringAlgorithm::random_disc) {
    throw InvalidArgument(
        std::string("palette is conflicts, which nothing would read; it needs the algorithm "
                    "random_disc, not ") +
        name_of(options.algorithm));
  }
  if (options.max_colors < 0) {
    throw InvalidArgument("max_colors is " + std::to_string(options.max_colors) +
                          "; it must be >= 1, or 0 for no limit");
  }
}

Coloring color_constraints(const ConstraintVertices& constraints, const ColoringOptions& options) {
  check_coloring_options(options);
  if (ColoringDevice* const device = find_device(options)) {
    return device->color(constraints, options);
  }
  Coloring coloring = color_by_name(constraints, options);
  if (options.repair) {
    repair_coloring(coloring, constraints, options.seed, options.executor, repair_swaps(options));
  }
  if (options.max_colors > 0) {
    limit_colors(coloring, constraints, options.max_colors, options.seed, options.executor);
  }
  if (options.balance) {
    balance_coloring(coloring, constraints, options.seed, options.executor);
  }
  return coloring;
}

const char* name_of(ColoringAlgorithm algorithm) noexcept {
  switch (algorithm) {
    case ColoringAlgorithm::greedy:
      return "greedy";
    case ColoringAlgorithm::luby:
      return "luby";
    case ColoringAlgorithm::jones_plassmann:
      return "jones_plassmann";
    case ColoringAlgorithm::random_disc:
      return "random_disc";
  }
  return "unknown";
}

const char* name_of(GreedyOrder order) noexcept {
  switch (order) {
    case GreedyOrder::natural:
      return "natural";
    case GreedyOrder::largest_valence:
      return "largest_valence";
    case GreedyOrder::smallest_last:
      return "smallest_last";
    case GreedyOrder::saturation:
      return "saturation";
  }
  return "unknown";
}

}  // namespace pbdsurg
