// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/constraint_vertices.h"

#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/sample_constraints.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

template <std::size_t kArity>
ConstraintVertices view(const std::vector<std::array<Index, kArity>>& constraints, Index vertices) {
  return {std::span<const std::array<Index, kArity>>(constraints), vertices};
}

}  // namespace

TEST_CASE("constraint vertices: bad constraints are refused by name", "[unit]") {
  const std::vector<Edge> out_of_range{{0, 1}, {1, 4}};
  CHECK_THROWS_WITH(check_constraints(view(out_of_range, 4)), ContainsSubstring("constraint 1") &&
                                                                  ContainsSubstring("vertex 4") &&
                                                                  ContainsSubstring("[0, 4)"));
  const std::vector<Edge> negative{{-1, 1}};
  CHECK_THROWS_WITH(check_constraints(view(negative, 4)), ContainsSubstring("vertex -1"));
  const std::vector<Tet> twice{{0, 1, 2, 3}, {1, 2, 3, 2}};
  CHECK_THROWS_WITH(check_constraints(view(twice, 4)),
                    ContainsSubstring("constraint 1") && ContainsSubstring("vertex 2 twice"));
  const std::vector<Tet> no_vertices{{0, 1, 2, 3}};
  CHECK_THROWS_AS(check_constraints(view(no_vertices, 0)), InvalidArgument);
}

TEST_CASE("constraint vertices: lists of any length are checked too", "[unit]") {
  IndexLists lists{{0, 1, 4}, {2, 0, 1, 0}};
  CHECK_THROWS_WITH(check_constraints({lists, 3}),
                    ContainsSubstring("constraint 1 lists vertex 0"));
  lists.entries[3] = 7;
  CHECK_THROWS_WITH(check_constraints({lists, 3}), ContainsSubstring("vertex 7"));
  lists.entries[3] = 2;
  CHECK_NOTHROW(check_constraints({lists, 3}));
  lists.offsets = {0, 3, 1};
  CHECK_THROWS_WITH(check_constraints({lists, 3}), ContainsSubstring("offsets"));
  lists.offsets = {0, 1, 9};
  CHECK_THROWS_AS(check_constraints({lists, 3}), InvalidArgument);
}

TEST_CASE("constraint vertices: a view of the wrong shape is refused", "[unit]") {
  const std::vector<Edge> edges{{0, 1}, {2, 3}};
  ConstraintVertices odd = view(edges, 4);
  odd.arity = 3;
  CHECK_THROWS_WITH(clique_bound(odd), ContainsSubstring("4 ids do not make"));
  odd.arity = -1;
  CHECK_THROWS_AS(clique_bound(odd), InvalidArgument);
  odd.arity = 0;  // and no offsets
  CHECK_THROWS_AS(clique_bound(odd), InvalidArgument);
  odd.arity = 2;
  odd.vertex_count = -1;
  CHECK_THROWS_AS(clique_bound(odd), InvalidArgument);
}

TEST_CASE("constraint vertices: the bound is the largest list at a vertex", "[property]") {
  for (const testing::SampleConstraints& sample : testing::all_samples()) {
    INFO(sample.name);
    const ConstraintVertices constraints = sample.view();
    const IndexLists lists = find_vertex_constraints(constraints);

    REQUIRE(lists.list_count() == sample.vertex_count);
    std::size_t longest = 0;
    for (Index v = 0; v < sample.vertex_count; ++v) {
      longest = std::max(longest, lists[v].size());
      CHECK(std::is_sorted(lists[v].begin(), lists[v].end()));
      for (const Index c : lists[v]) {
        const auto ids = constraints[c];
        CHECK(std::find(ids.begin(), ids.end(), v) != ids.end());
      }
    }
    CHECK(lists.entries.size() == constraints.vertices.size());
    CHECK(clique_bound(constraints) == static_cast<Index>(longest));
  }
}

}  // namespace pbdsurg
