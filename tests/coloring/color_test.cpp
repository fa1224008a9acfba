// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/color.h"

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/coloring/balance.h"
#include "pbdsurg/coloring/jones_plassmann.h"
#include "pbdsurg/coloring/luby.h"
#include "pbdsurg/coloring/repair.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

std::uint64_t fingerprint(const Coloring& coloring) {
  auto result = static_cast<std::uint64_t>(coloring.color_count);
  for (const Index color : coloring.color_of) {
    result = random_bits(result, static_cast<std::uint64_t>(color));
  }
  return result;
}

}  // namespace

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
        color_random_disc(constraints, 11, {}, {Palette::conflicts, 2.2}));
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

// Recorded before repair learnt to swap with two and balance to move chains: neither may act where
// it is not wanted, as the bits of every simulation follow from its colours.
TEST_CASE("color: plans of the solver, and what sweeps can balance, keep their colours", "[unit]") {
  const TetMesh box = testing::make_box({9, 7, 6}, 1e-3);
  const std::vector<Edge> edge_list = find_edges(box.tets());
  const ConstraintVertices tets(box.tets(), box.vertex_count());
  const ConstraintVertices edges(std::span<const Edge>(edge_list), box.vertex_count());
  const IndexLists blocks = find_vertex_constraints(tets);

  const ColoringOptions by_default{.repair = true};  // ends above the bound of tets
  CHECK(fingerprint(color_constraints(tets, by_default)) == 0xbe28c0c979373290);
  CHECK(fingerprint(color_constraints(edges, by_default)) == 0x1270faee68fd2e95);
  const ColoringOptions paper{.algorithm = ColoringAlgorithm::random_disc,
                              .disc = {.palette = Palette::conflicts}};
  CHECK(fingerprint(color_constraints(tets, paper)) == 0xc63d8b05ac080194);
  CHECK(fingerprint(color_constraints(edges, paper)) == 0xdc63ec765102f1c6);
  const ColoringOptions of_blocks{.order = GreedyOrder::saturation, .repair = true};
  CHECK(fingerprint(color_constraints({blocks, box.tet_count()}, of_blocks)) == 0xd9fb8e54abfdbdb4);

  const ColoringOptions balanced{.repair = true, .balance = true};  // within 0.8 and 1.9 %
  CHECK(fingerprint(color_constraints(edges, balanced)) == 0xbe78f4bc4367c763);
  CHECK(fingerprint(color_constraints({blocks, box.tet_count()}, balanced)) == 0x83f4e3b287cf41fc);
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
