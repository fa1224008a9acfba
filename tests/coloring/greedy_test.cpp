// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/greedy.h"

#include <set>
#include <vector>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

constexpr GreedyOrder kOrders[]{GreedyOrder::natural, GreedyOrder::largest_valence,
                                GreedyOrder::smallest_last, GreedyOrder::saturation};

// First fit with sets instead of masks.
Coloring plain_first_fit(const ConstraintVertices& constraints) {
  std::vector<std::set<Index>> seen(static_cast<std::size_t>(constraints.vertex_count));
  Coloring coloring;
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    Index color = 0;
    const auto taken = [&] {
      const auto ids = constraints[c];
      return std::any_of(ids.begin(), ids.end(), [&](Index v) { return seen[v].contains(color); });
    };
    while (taken()) {
      ++color;
    }
    for (const Index v : constraints[c]) {
      seen[v].insert(color);
    }
    coloring.color_of.push_back(color);
    coloring.color_count = std::max(coloring.color_count, color + 1);
  }
  return coloring;
}

}  // namespace

TEST_CASE("greedy: natural order is first fit by its definition", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    CHECK(color_greedy(sample.view()) == plain_first_fit(sample.view()));
  }
}

// Would catch a wrong order too: first fit leaves nothing that could take a lower colour.
TEST_CASE("greedy: every order is valid and leaves no lower colour free", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    for (const GreedyOrder order : kOrders) {
      INFO(sample.name << ", order " << static_cast<int>(order));
      const ConstraintVertices constraints = sample.view();
      const Coloring coloring = color_greedy(constraints, order);

      CHECK_FALSE(find_conflict(coloring, constraints));
      CHECK(coloring.color_count >= clique_bound(constraints));
      CHECK(testing::has_no_gap(coloring));
      CHECK(testing::leaves_no_lower_color_free(coloring, constraints));
    }
  }
}

// Would catch masks that are too narrow, and quadratic work at a hub.
TEST_CASE("greedy: a hub gives every constraint a colour of its own", "[unit]") {
  const testing::SampleConstraints hub = testing::hub_sample(10000);
  for (const GreedyOrder order : {GreedyOrder::natural, GreedyOrder::largest_valence}) {
    const Coloring coloring = color_greedy(hub.view(), order);
    CHECK(coloring.color_count == 10000);
    CHECK_FALSE(find_conflict(coloring, hub.view()));
  }
}

// The orders earn their cost: literature and measurements give 32, 29 and 27 or so of 24.
TEST_CASE("greedy: better orders need fewer colours on a lattice", "[benchmark]") {
  const TetMesh box = testing::make_box({12, 12, 12}, 1e-3);
  const ConstraintVertices tets(box.tets(), box.vertex_count());
  const Index bound = clique_bound(tets);
  REQUIRE(bound == 24);

  CHECK(color_greedy(tets).color_count <= 1.30 * bound);
  CHECK(color_greedy(tets, GreedyOrder::smallest_last).color_count <= 1.21 * bound);
  CHECK(color_greedy(tets, GreedyOrder::saturation).color_count <= 1.125 * bound);
}

TEST_CASE("greedy: vertex blocks of tetrahedra need at most nine colours", "[benchmark]") {
  const TetMesh organ = table2_mesh(1);
  const ConstraintVertices tets(organ.tets(), organ.vertex_count());
  const IndexLists blocks = find_vertex_constraints(tets);
  const ConstraintVertices vertices(blocks, tets.constraint_count());

  const Coloring coloring = color_greedy(vertices, GreedyOrder::saturation);

  CHECK(coloring.color_count <= 9);
  CHECK_FALSE(find_conflict(coloring, vertices));
  for (const Edge& edge : find_edges(organ.tets())) {
    REQUIRE(coloring.color_of[edge[0]] != coloring.color_of[edge[1]]);
  }
}

TEST_CASE("greedy: an unknown order is refused", "[unit]") {
  CHECK_THROWS_AS(color_greedy({}, static_cast<GreedyOrder>(9)), InvalidArgument);
}

}  // namespace pbdsurg
