// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/coloring/constraint_vertices.h"
#include "pbdsurg/coloring/greedy.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {

// A solver that moves whole vertices at once needs neighbours of different colours. Would catch
// blocks that miss a tet, and an order that spends colours.
TEST_CASE("vertex blocks: their colouring is a colouring of the vertices", "[property]") {
  for (const auto& [mesh, most] :
       {std::pair(table2_mesh(1), 9), std::pair(testing::make_box({9, 8, 7}, 1e-3), 4)}) {
    const ConstraintVertices constraints(mesh.tets(), mesh.vertex_count());
    const IndexLists blocks = find_vertex_constraints(constraints);
    const Coloring coloring = color_greedy(
        ConstraintVertices(blocks, constraints.constraint_count()), GreedyOrder::saturation);

    REQUIRE(coloring.color_of.size() == static_cast<std::size_t>(mesh.vertex_count()));
    Index clashes = 0;
    for (const Edge& edge : find_edges(mesh.tets())) {
      clashes += coloring.color_of[edge[0]] == coloring.color_of[edge[1]] ? 1 : 0;
    }
    CHECK(clashes == 0);
    CHECK(coloring.color_count <= most);
  }
}

}  // namespace pbdsurg
