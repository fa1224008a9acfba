// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/coloring.h"

#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

const std::vector<Edge> kPath{{0, 1}, {2, 3}, {1, 2}};
const ConstraintVertices kPathView{std::span<const Edge>(kPath), 4};

}  // namespace

TEST_CASE("coloring: a conflict is found and named", "[unit]") {
  const auto conflict = find_conflict({{0, 0, 0}, 1}, kPathView);

  REQUIRE(conflict);
  CHECK(conflict->color == 0);
  CHECK(conflict->first == 0);
  CHECK(conflict->second == 2);
  CHECK(conflict->vertex == 1);
  CHECK_FALSE(find_conflict({{0, 0, 1}, 2}, kPathView));
}

TEST_CASE("coloring: overflow conflicts with nothing", "[unit]") {
  CHECK_FALSE(find_conflict({{0, 0, kOverflowColor}, 1}, kPathView));
  CHECK_FALSE(find_conflict({{kOverflowColor, kOverflowColor, kOverflowColor}, 0}, kPathView));
}

TEST_CASE("coloring: what does not fit the constraints is refused", "[unit]") {
  CHECK_THROWS_WITH(find_conflict({{0}, 1}, kPathView), ContainsSubstring("colouring of 1"));
  CHECK_THROWS_WITH(find_conflict({{0, 7, 1}, 2}, kPathView),
                    ContainsSubstring("constraint 1") && ContainsSubstring("colour 7"));
  CHECK_THROWS_AS(find_conflict({{0, -2, 1}, 2}, kPathView), InvalidArgument);
  CHECK_THROWS_AS(find_conflict({{}, -1}, kPathView), InvalidArgument);
  CHECK_THROWS_AS(measure_coloring({{0}, 1}, kPathView), InvalidArgument);
  CHECK_THROWS_AS(color_sizes({{3}, 2}), InvalidArgument);
}

// By hand, with 12 colours: a tenth is two whole colours.
TEST_CASE("coloring: statistics follow their definitions", "[unit]") {
  std::vector<Edge> edges;
  Coloring coloring{{}, 12};
  for (Index color = 0; color < 12; ++color) {
    for (Index i = 0; i <= color; ++i) {
      edges.push_back(
          {static_cast<Index>(2 * edges.size()), static_cast<Index>(2 * edges.size() + 1)});
      coloring.color_of.push_back(color);
    }
  }
  edges.push_back({0, 1});
  coloring.color_of.push_back(kOverflowColor);

  const ColoringStatistics statistics =
      measure_coloring(coloring, {std::span<const Edge>(edges), 2 * 78});

  CHECK(statistics.constraints == 79);
  CHECK(statistics.overflow == 1);
  CHECK(statistics.colors == 12);
  CHECK(statistics.clique_bound == 2);
  CHECK(statistics.top10 == Approx(23.0 / 78));
  CHECK(statistics.last10 == Approx(3.0 / 78));
  CHECK(statistics.mid80 == Approx(52.0 / 78));
  CHECK(statistics.max_over_mean == Approx(12 / 6.5));
  CHECK(statistics.relative_deviation == Approx(std::sqrt(143.0 / 12) / 6.5));
}

TEST_CASE("coloring: statistics of next to nothing are finite", "[unit]") {
  const ColoringStatistics none = measure_coloring({}, {std::span<const Edge>(), 3});
  CHECK(none.constraints == 0);
  CHECK(none.relative_deviation == 0);
  CHECK(none.top10 + none.mid80 + none.last10 == 0);

  const ColoringStatistics one =
      measure_coloring({{0}, 1}, {std::span<const Edge>(kPath).first(1), 4});
  CHECK(one.top10 == 1);
  CHECK(one.mid80 == 0);
  CHECK(one.last10 == 0);
}

}  // namespace pbdsurg
