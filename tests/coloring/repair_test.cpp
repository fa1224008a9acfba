// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/repair.h"

#include <numeric>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/color.h"
#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/coloring/jones_plassmann.h"
#include "pbdsurg/coloring/luby.h"
#include "pbdsurg/coloring/random_disc.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// The worst that is valid.
Coloring one_color_each(const ConstraintVertices& constraints) {
  Coloring coloring{{}, constraints.constraint_count()};
  coloring.color_of.resize(static_cast<std::size_t>(coloring.color_count));
  std::iota(coloring.color_of.begin(), coloring.color_of.end(), Index{0});
  return coloring;
}

}  // namespace

TEST_CASE("repair: valid, without gaps and never with more colours, on any threads", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const Coloring before = color_luby(constraints, 5);
    Coloring coloring = before;
    repair_coloring(coloring, constraints, 9);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(testing::has_no_gap(coloring));
    CHECK(coloring.color_count <= before.color_count);
    for (const int threads : {2, 3, 8}) {
      Coloring other = before;
      repair_coloring(other, constraints, 9, executor::threads(threads));
      CHECK(other == coloring);
    }
  }
}

// Where the limit has to rise, a constraint can be done at one step and be lifted again at the
// next: listed twice, it would be moved twice, by two threads at once.
TEST_CASE("repair: above the bound, too, the result does not depend on the threads",
          "[property][long]") {
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    INFO("seed " << seed);
    const testing::SampleConstraints sample = testing::crowded_sample(seed);
    const Coloring before = color_greedy(sample.view(), GreedyOrder::smallest_last);
    for (const RepairSwaps swaps : {RepairSwaps::with_one, RepairSwaps::with_two}) {
      if (swaps == RepairSwaps::with_two && seed >= 15) {
        continue;  // takes far longer
      }
      Coloring coloring = before;
      repair_coloring(coloring, sample.view(), seed, {}, swaps);
      CHECK_FALSE(find_conflict(coloring, sample.view()));
      for (const int threads : {2, 3}) {
        Coloring other = before;
        repair_coloring(other, sample.view(), seed, executor::threads(threads), swaps);
        CHECK(other == coloring);
      }
    }
  }
}

TEST_CASE("repair: organs reach the clique bound from any start", "[benchmark]") {
  const TetMesh organ = table2_mesh(1);
  const std::vector<Edge> edges = find_edges(organ.tets());
  for (const ConstraintVertices& constraints :
       {ConstraintVertices(organ.tets(), organ.vertex_count()),
        ConstraintVertices(std::span<const Edge>(edges), organ.vertex_count())}) {
    INFO("arity " << constraints.arity);
    const Index bound = clique_bound(constraints);
    for (Coloring coloring : {color_luby(constraints), color_random_disc(constraints),
                              color_jones_plassmann(constraints)}) {
      repair_coloring(coloring, constraints);
      CHECK(coloring.color_count <= bound + 1);
      CHECK_FALSE(find_conflict(coloring, constraints));
    }
  }
}

// Of ten seeds, five end above the bound where a constraint swaps with one alone: every colour
// around the last of them is held by two.
TEST_CASE("repair: swaps with two reach the bound that swaps with one do not", "[benchmark]") {
  const TetMesh organ = table2_mesh(1);
  const ConstraintVertices tets(organ.tets(), organ.vertex_count());
  const Index bound = clique_bound(tets);
  int missed = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    INFO("seed " << seed);
    const Coloring before = color_random_disc(tets, seed);
    Coloring with_one = before;
    repair_coloring(with_one, tets, seed);
    Coloring with_two = before;
    repair_coloring(with_two, tets, seed, {}, RepairSwaps::with_two);

    CHECK_FALSE(find_conflict(with_two, tets));
    CHECK(with_two.color_count == bound);
    if (with_one.color_count == bound) {
      CHECK(with_two == with_one);
    } else {
      ++missed;
    }
    const ColoringOptions options{
        .algorithm = ColoringAlgorithm::random_disc, .repair = true, .seed = seed};
    CHECK(color_constraints(tets, options) == with_two);
  }
  CHECK(missed > 0);
}

// Hundreds of colours too many, and masks of many words.
TEST_CASE("repair: one colour each comes down to a few", "[unit]") {
  const TetMesh box = testing::make_box({4, 4, 4}, 1e-3);
  const ConstraintVertices tets(box.tets(), box.vertex_count());
  Coloring coloring = one_color_each(tets);
  repair_coloring(coloring, tets);

  CHECK(coloring.color_count <= clique_bound(tets) + 6);
  CHECK_FALSE(find_conflict(coloring, tets));
}

TEST_CASE("repair: a colouring at the clique bound stays as it is", "[unit]") {
  const testing::SampleConstraints hub = testing::hub_sample(100);
  const Coloring before = one_color_each(hub.view());
  Coloring coloring = before;
  repair_coloring(coloring, hub.view());
  CHECK(coloring == before);
}

TEST_CASE("limit_colors: what does not fit overflows, and no more than must", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    const ConstraintVertices constraints = sample.view();
    const Coloring before = color_luby(constraints, 5);
    for (const Index limit : {1, 5, 20, 1000}) {
      INFO(sample.name << ", limit " << limit);
      Coloring coloring = before;
      limit_colors(coloring, constraints, limit, 2);

      CHECK(coloring.color_count == std::min(limit, before.color_count));
      CHECK_FALSE(find_conflict(coloring, constraints));
      if (limit >= before.color_count) {
        CHECK(coloring == before);
        continue;
      }
      // what was in the largest colours is a lower bound for what can stay
      std::vector<Index> sizes = color_sizes(before);
      std::sort(sizes.rbegin(), sizes.rend());
      const std::vector<Index> kept = color_sizes(coloring);
      CHECK(std::accumulate(kept.begin(), kept.end(), 0) >=
            std::accumulate(sizes.begin(), sizes.begin() + limit, 0));
      for (const int threads : {2, 5}) {
        Coloring other = before;
        limit_colors(other, constraints, limit, 2, executor::threads(threads));
        CHECK(other == coloring);
      }
      // overflow is left alone by what follows
      Coloring repaired = coloring;
      repair_coloring(repaired, constraints);
      CHECK_FALSE(find_conflict(repaired, constraints));
      CHECK(std::count(repaired.color_of.begin(), repaired.color_of.end(), kOverflowColor) ==
            std::count(coloring.color_of.begin(), coloring.color_of.end(), kOverflowColor));
    }
  }
}

TEST_CASE("repair: an invalid colouring is refused and stays as it is", "[unit]") {
  const std::vector<Edge> path{{0, 1}, {1, 2}};
  const ConstraintVertices constraints(std::span<const Edge>(path), 3);
  Coloring coloring{{0, 0}, 1};
  CHECK_THROWS_WITH(repair_coloring(coloring, constraints),
                    ContainsSubstring("constraints 0 and 1") && ContainsSubstring("vertex 1"));
  CHECK_THROWS_AS(limit_colors(coloring, constraints, 1), InvalidArgument);
  CHECK(coloring == Coloring{{0, 0}, 1});

  Coloring good{{0, 1}, 2};
  CHECK_THROWS_AS(limit_colors(good, constraints, 0), InvalidArgument);
  Coloring short_one{{0}, 1};
  CHECK_THROWS_AS(repair_coloring(short_one, constraints), InvalidArgument);
}

}  // namespace pbdsurg
