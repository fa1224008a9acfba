// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/color.h"

#include "pbdsurg/coloring/balance.h"
#include "pbdsurg/coloring/jones_plassmann.h"
#include "pbdsurg/coloring/luby.h"
#include "pbdsurg/coloring/repair.h"
#include "pbdsurg/core/error.h"

#include "coloring/sample_constraints.h"
#include "support/catch.h"

namespace pbdsurg {

TEST_CASE("color: a name stands for the function, and the seed reaches it", "[unit]") {
  const testing::SampleConstraints sample = testing::random_sample("tets", 1500, 400, 4, 2);
  const ConstraintVertices constraints = sample.view();
  ColoringOptions options;
  options.seed = 11;

  options.order = GreedyOrder::smallest_last;
  CHECK(color_constraints(constraints, options) ==
        color_greedy(constraints, GreedyOrder::smallest_last));
  options.order = GreedyOrder::natural;
  options.algorithm = ColoringAlgorithm::luby;
  CHECK(color_constraints(constraints, options) == color_luby(constraints, 11));
  options.algorithm = ColoringAlgorithm::jones_plassmann;
  CHECK(color_constraints(constraints, options) == color_jones_plassmann(constraints, 11));
  options.algorithm = ColoringAlgorithm::random_disc;
  options.disc = {Palette::conflicts, 2.2};
  CHECK(color_constraints(constraints, options) ==
        color_random_disc(constraints, 11, 1, {Palette::conflicts, 2.2}));
}

TEST_CASE("color: repairs, then limits, then balances", "[unit]") {
  const testing::SampleConstraints sample = testing::random_sample("tets", 1500, 400, 4, 2);
  const ConstraintVertices constraints = sample.view();
  ColoringOptions options;
  options.algorithm = ColoringAlgorithm::luby;
  options.repair = true;
  options.balance = true;
  options.max_colors = 12;

  Coloring expected = color_luby(constraints);
  repair_coloring(expected, constraints);
  limit_colors(expected, constraints, 12);
  balance_coloring(expected, constraints);
  CHECK(color_constraints(constraints, options) == expected);
  CHECK(expected.color_count == 12);
}

TEST_CASE("color: options out of range are refused", "[unit]") {
  CHECK_THROWS_AS(color_constraints({}, {.max_colors = -1}), InvalidArgument);
  CHECK_THROWS_AS(color_constraints({}, {.algorithm = static_cast<ColoringAlgorithm>(9)}),
                  InvalidArgument);
  ColoringOptions luby{.algorithm = ColoringAlgorithm::luby};
  luby.order = static_cast<GreedyOrder>(9);
  CHECK_THROWS_AS(color_constraints({}, luby), InvalidArgument);
}

}  // namespace pbdsurg
