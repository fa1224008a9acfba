// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "pbdsurg/coloring/greedy.h"
#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/topology.h"

#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

template <std::size_t kArity>
ConstraintVertices view(const std::vector<std::array<Index, kArity>>& constraints, Index vertices) {
  return {std::span<const std::array<Index, kArity>>(constraints), vertices};
}

}  // namespace

TEST_CASE("coloring: greedy is valid and reports no more colours than it uses", "[property]") {
  const TetMesh box = testing::make_box({7, 5, 3}, 1e-3, 0.1);
  const std::vector<Tet> tets(box.tets().begin(), box.tets().end());
  const std::vector<Edge> edges = find_edges(tets);

  for (const ConstraintVertices& constraints :
       {view(tets, box.vertex_count()), view(edges, box.vertex_count())}) {
    const Coloring coloring = color_greedy(constraints);

    CHECK_FALSE(find_conflict(coloring, constraints));
    CHECK(coloring.color_count >= clique_bound(constraints));
    std::vector<bool> used(coloring.color_count, false);
    for (const Index color : coloring.color_of) {
      used[color] = true;
    }
    CHECK(std::count(used.begin(), used.end(), false) == 0);
  }
}

// Would catch masks that are too narrow: a hub gives every constraint a colour of its own.
TEST_CASE("coloring: a hub of 300 constraints needs 300 colours", "[unit]") {
  std::vector<Edge> spokes;
  for (Index i = 1; i <= 300; ++i) {
    spokes.push_back({0, i});
  }

  const Coloring coloring = color_greedy(view(spokes, 301));

  CHECK(coloring.color_count == 300);
  CHECK(clique_bound(view(spokes, 301)) == 300);
  CHECK_FALSE(find_conflict(coloring, view(spokes, 301)));
}

TEST_CASE("coloring: a conflict is found and named", "[unit]") {
  const std::vector<Edge> path{{0, 1}, {2, 3}, {1, 2}};

  const auto conflict = find_conflict({{0, 0, 0}, 1}, view(path, 4));

  REQUIRE(conflict);
  CHECK(conflict->first == 0);
  CHECK(conflict->second == 2);
  CHECK(conflict->vertex == 1);
  CHECK_FALSE(find_conflict({{0, 0, 1}, 2}, view(path, 4)));
}

TEST_CASE("coloring: nothing to colour takes no colour", "[unit]") {
  CHECK(color_greedy(view(std::vector<Edge>{}, 5)).color_count == 0);
  CHECK(color_greedy(view(std::vector<Tet>{}, 0)).color_count == 0);
  CHECK(clique_bound(view(std::vector<Tet>{}, 0)) == 0);
}

TEST_CASE("coloring: bad constraints are refused by name", "[unit]") {
  CHECK_THROWS_WITH(color_greedy(view(std::vector<Edge>{{0, 1}, {1, 4}}, 4)),
                    ContainsSubstring("constraint 1") && ContainsSubstring("vertex 4"));
  CHECK_THROWS_WITH(color_greedy(view(std::vector<Edge>{{-1, 1}}, 4)),
                    ContainsSubstring("vertex -1"));
  CHECK_THROWS_WITH(color_greedy(view(std::vector<Edge>{{2, 2}}, 4)), ContainsSubstring("twice"));
  CHECK_THROWS_AS(find_conflict({{0}, 1}, view(std::vector<Edge>{{0, 1}, {2, 3}}, 4)),
                  InvalidArgument);
  ConstraintVertices odd = view(std::vector<Edge>{{0, 1}, {2, 3}}, 4);
  odd.arity = 3;
  CHECK_THROWS_WITH(color_greedy(odd), ContainsSubstring("4 ids do not make"));
  odd.arity = 0;
  CHECK_THROWS_AS(clique_bound(odd), InvalidArgument);
  CHECK_THROWS_AS(find_conflict({{0, 7}, 1}, view(std::vector<Edge>{{0, 1}, {2, 3}}, 4)),
                  InvalidArgument);
}

}  // namespace pbdsurg
