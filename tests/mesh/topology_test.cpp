// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/topology.h"

#include <algorithm>

#include "tests/support/catch.h"

namespace pbdsurg {

TEST_CASE("topology: two tets that share a face", "[unit]") {
  const std::vector<Tet> tets{{0, 1, 2, 3}, {1, 2, 3, 4}};

  const std::vector<Edge> edges = find_edges(tets);
  const std::vector<BoundaryTriangle> boundary = find_boundary(tets);
  const IndexLists vertex_tets = find_vertex_tets(5, tets);

  CHECK(edges.size() == 9);
  CHECK(std::is_sorted(edges.begin(), edges.end()));
  CHECK(boundary.size() == 6);
  for (const BoundaryTriangle& triangle : boundary) {
    CHECK(triangle.vertices != Triangle{1, 2, 3});
  }
  CHECK(vertex_tets[0].size() == 1);
  CHECK(std::vector<Index>(vertex_tets[2].begin(), vertex_tets[2].end()) ==
        std::vector<Index>{0, 1});
  CHECK(find_components(5, tets).count == 1);
}

TEST_CASE("topology: the edges of a tetrahedron are found again", "[unit]") {
  const std::vector<Tet> tets{{3, 1, 0, 2}, {1, 2, 3, 4}};
  const std::vector<Edge> edges = find_edges(tets);

  const auto tet_edges = find_tet_edges(tets, edges);

  for (std::size_t t = 0; t < tets.size(); ++t) {
    for (std::size_t e = 0; e < 6; ++e) {
      const Index a = tets[t][kTetEdges[e][0]], b = tets[t][kTetEdges[e][1]];
      CHECK(edges[tet_edges[t][e]] == Edge{std::min(a, b), std::max(a, b)});
    }
  }
}

TEST_CASE("topology: components are numbered by their smallest vertex", "[unit]") {
  const std::vector<Tet> tets{{6, 7, 8, 9}, {0, 1, 2, 3}};

  const Components parts = find_components(10, tets);

  CHECK(parts.count == 2);
  CHECK(parts.of_vertex[0] == 0);
  CHECK(parts.of_vertex[4] == kInvalidIndex);
  CHECK(parts.of_vertex[9] == 1);
}

TEST_CASE("topology: nothing in, nothing out", "[unit]") {
  CHECK(find_edges({}).empty());
  CHECK(find_boundary({}).empty());
  CHECK(find_components(0, std::span<const Tet>{}).count == 0);
}

}  // namespace pbdsurg
