// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/random_disc.h"

#include <limits>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

constexpr RandomDiscOptions kPalettes[]{
    {Palette::clique_bound, 2},
    {Palette::conflicts, 1},
    {Palette::conflicts, 2.5},
    // starts with one colour each: the rank must break the ties and palettes must grow
    {Palette::conflicts, 1e9}};

}  // namespace

// Would catch the livelock of palettes without a tie rule: the test would not end.
TEST_CASE("random_disc: ends with a valid colouring, whatever the palette", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    for (const RandomDiscOptions& options : kPalettes) {
      INFO(sample.name << ", shrink " << options.shrink);
      const ConstraintVertices constraints = sample.view();
      const Coloring coloring = color_random_disc(constraints, 7, {}, options);

      CHECK_FALSE(find_conflict(coloring, constraints));
      CHECK(testing::has_no_gap(coloring));
      CHECK(coloring.color_count >= clique_bound(constraints));
    }
  }
}

TEST_CASE("random_disc: the result depends on the seed, not on the threads", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    for (const RandomDiscOptions& options : kPalettes) {
      INFO(sample.name << ", shrink " << options.shrink);
      const Coloring one = color_random_disc(sample.view(), 3, {}, options);
      for (const int threads : {2, 3, 8}) {
        CHECK(color_random_disc(sample.view(), 3, executor::threads(threads), options) == one);
      }
      if (one.color_of.size() > 1000) {
        CHECK(color_random_disc(sample.view(), 4, {}, options) != one);
      }
    }
  }
}

// The paper's table 1 shows a third of its constraints in the first tenth of random disc's colours:
// palettes by conflicts fill low colours first, a palette of the clique bound does not.
TEST_CASE("random_disc: the palette decides how even the colours are", "[benchmark]") {
  const TetMesh organ = table2_mesh(1);
  const std::vector<Edge> edges = find_edges(organ.tets());
  const ConstraintVertices constraints(std::span<const Edge>(edges), organ.vertex_count());

  const auto even = measure_coloring(color_random_disc(constraints), constraints);
  const auto paper = measure_coloring(
      color_random_disc(constraints, 0, {}, {Palette::conflicts, 2.2}), constraints);

  CHECK(paper.relative_deviation > 1.2 * even.relative_deviation);
  CHECK(even.colors <= even.clique_bound + 4);
}

TEST_CASE("random_disc: options out of range are refused", "[unit]") {
  CHECK_THROWS_AS(color_random_disc({}, 0, {}, {Palette::conflicts, 0.5}), InvalidArgument);
  CHECK_THROWS_AS(
      color_random_disc({}, 0, {}, {Palette::conflicts, std::numeric_limits<double>::quiet_NaN()}),
      InvalidArgument);
  CHECK_THROWS_AS(color_random_disc({}, 0, {}, {static_cast<Palette>(9), 2}), InvalidArgument);
}

}  // namespace pbdsurg
