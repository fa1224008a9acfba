// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/balance.h"

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/coloring/repair.h"
#include "pbdsurg/mesh/tetrahedralize.h"

#include "lib/coloring/chain_balance.h"
#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {

TEST_CASE("balance: valid, of no more colours, no less even, on any threads", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Coloring before = color_greedy(constraints);
    Coloring coloring = before;
    balance_coloring(coloring, constraints, 9);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(testing::has_no_gap(coloring));
    CHECK(coloring.color_count <= before.color_count);
    CHECK(measure_coloring(coloring, constraints).relative_deviation <=
          measure_coloring(before, constraints).relative_deviation);
    for (const int threads : {2, 3, 8}) {
      Coloring other = before;
      balance_coloring(other, constraints, 9, executor::threads(threads));
      CHECK(other == coloring);
    }
  }
}

TEST_CASE("balance: colours of organs are even within 2 %, at no extra colour", "[benchmark]") {
  const TetMesh organ = table2_mesh(1);
  const std::vector<Edge> edges = find_edges(organ.tets());
  for (const ConstraintVertices& constraints :
       {ConstraintVertices(organ.tets(), organ.vertex_count()),
        ConstraintVertices(std::span<const Edge>(edges), organ.vertex_count())}) {
    Coloring coloring = color_greedy(constraints);
    repair_coloring(coloring, constraints);
    const Index colors = coloring.color_count;
    REQUIRE(constraints.constraint_count() / colors >= 300);
    balance_coloring(coloring, constraints);

    const ColoringStatistics statistics = measure_coloring(coloring, constraints);
    CHECK(statistics.colors == colors);
    CHECK(statistics.relative_deviation <= 0.02);
    CHECK(statistics.max_over_mean <= 1.02);
  }
}

// Sweeps at random leave them at 12 % (fat), 6 % (liver) and 3 % (lattice).
TEST_CASE("balance: even where no single constraint is free to move", "[benchmark]") {
  const auto check = [](const ConstraintVertices& constraints, GreedyOrder order) {
    Coloring coloring = color_greedy(constraints, order);
    repair_coloring(coloring, constraints);
    const Coloring before = coloring;
    balance_coloring(coloring, constraints);

    CHECK_FALSE(find_conflict(coloring, constraints));
    const ColoringStatistics statistics = measure_coloring(coloring, constraints);
    CHECK(statistics.colors == before.color_count);
    CHECK(statistics.relative_deviation <= 0.005);
    Coloring other = before;
    balance_coloring(other, constraints, 0, executor::threads(3));
    CHECK(other == coloring);
  };
  for (const Organ organ : {Organ::calot_fat, Organ::liver}) {
    INFO(name_of(organ));
    const OrganRecipe recipe = organ_recipe(organ);
    const TetMesh mesh = tetrahedralize(recipe.shape, recipe.options).mesh;
    const IndexLists blocks =
        find_vertex_constraints(ConstraintVertices(mesh.tets(), mesh.vertex_count()));
    check({blocks, mesh.tet_count()}, GreedyOrder::saturation);
    check({blocks, mesh.tet_count()}, GreedyOrder::smallest_last);
  }
  const TetMesh lattice = testing::make_box({20, 20, 20}, 1e-3);
  check({lattice.tets(), lattice.vertex_count()}, GreedyOrder::natural);
  check({lattice.tets(), lattice.vertex_count()}, GreedyOrder::saturation);
}

// Who holds a colour is then searched, as a table of vertices and colours would be too large.
TEST_CASE("balance: chains among far more vertices than constraints", "[unit]") {
  const TetMesh box = testing::make_box({9, 7, 6}, 1e-3);
  const ConstraintVertices few(box.tets(), box.vertex_count());
  const ConstraintVertices many(box.tets(), 2'000'000);
  Coloring coloring = color_greedy(few);
  repair_coloring(coloring, few);
  Coloring other = coloring;
  const Coloring before = coloring;
  balance_by_chains(coloring, few);
  balance_by_chains(other, many);
  CHECK(other == coloring);
  CHECK(coloring.color_of != before.color_of);
  CHECK_FALSE(find_conflict(coloring, few));
}

TEST_CASE("balance: overflow stays where it is", "[unit]") {
  const TetMesh box = testing::make_box({6, 6, 6}, 1e-3);
  const ConstraintVertices tets(box.tets(), box.vertex_count());
  Coloring coloring = color_greedy(tets);
  limit_colors(coloring, tets, 20);
  const Coloring before = coloring;
  balance_coloring(coloring, tets);

  CHECK(coloring.color_count == 20);
  CHECK_FALSE(find_conflict(coloring, tets));
  for (std::size_t c = 0; c < coloring.color_of.size(); ++c) {
    CHECK((coloring.color_of[c] == kOverflowColor) == (before.color_of[c] == kOverflowColor));
  }
}

TEST_CASE("balance: an invalid colouring is refused and stays as it is", "[unit]") {
  const std::vector<Edge> path{{0, 1}, {1, 2}};
  const ConstraintVertices constraints(std::span<const Edge>(path), 3);
  Coloring coloring{{0, 0}, 1};
  CHECK_THROWS_AS(balance_coloring(coloring, constraints), InvalidArgument);
  CHECK(coloring == Coloring{{0, 0}, 1});
}

}  // namespace pbdsurg
