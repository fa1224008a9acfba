// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/contact/proximity.h"

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {

TEST_CASE("proximity: finds the vertices of one body that have tissue", "[unit]") {
  Scene scene;
  const TetMesh cell = testing::make_box({1, 1, 1}, 1e-2);
  scene.add_body("first", cell);
  scene.add_body("second", cell);
  Solver solver(scene);

  CHECK(find_vertices_near(solver, 1, {0, 0, 0}, 1e-3F) == std::vector<Index>{8});
  CHECK(find_vertices_near(solver, 0, {0, 0, 0}, 1.1e-2F).size() == 4);
  CHECK(find_vertices_near(solver, 0, {1, 1, 1}, 1e-3F).empty());

  solver.tissue().apply({.remove_tets = {0, 1, 2, 3, 4, 5}});
  CHECK(find_vertices_near(solver, 0, {0, 0, 0}, 1.0F).empty());
  CHECK_THROWS_AS(find_vertices_near(solver, 2, {0, 0, 0}, 1.0F), InvalidArgument);
  CHECK_THROWS_AS(find_vertices_near(solver, 0, {0, 0, 0}, 0.0F), InvalidArgument);
}

}  // namespace pbdsurg
