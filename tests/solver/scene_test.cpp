// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/scene.h"

#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {

using testing::ContainsSubstring;

TEST_CASE("scene: bodies share one numbering", "[unit]") {
  Scene scene;
  const TetMesh box = testing::make_box({1, 1, 1}, 1e-2);
  const Index first = scene.add_body("first", box, testing::kSprings);
  const Index second = scene.add_body("second", box, testing::kSprings);

  CHECK(scene.body(second).first_vertex == 8);
  CHECK(scene.body(second).first_tet == 6);
  CHECK(scene.tets()[6][0] == scene.tets()[0][0] + 8);
  CHECK(scene.find_body("first") == first);
  CHECK(scene.fix_where(second, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; }) == 4);
  CHECK(scene.is_fixed(8));
  CHECK_FALSE(scene.is_fixed(0));
  CHECK(scene.add_link({0, 8, 1e-3F, {}}) == 0);
}

TEST_CASE("scene: bad values are refused by name and change nothing", "[unit]") {
  Scene scene;
  const TetMesh box = testing::make_box({1, 1, 1}, 1e-2);
  scene.add_body("box", box, testing::kSprings);
  const float nan = std::numeric_limits<float>::quiet_NaN();

  CHECK_THROWS_WITH(scene.add_body("box", box, testing::kSprings),
                    ContainsSubstring("'box' already"));
  CHECK_THROWS_WITH(scene.add_body("", box, testing::kSprings), ContainsSubstring("name"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.density = -1}), ContainsSubstring("density is -1"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.stretch = {0, 0}}), ContainsSubstring("(0, 1]"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.volume = {1, nan}}),
                    ContainsSubstring("volume compliance"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.stretch = {1, 2 * kLargestCompliance}}),
                    ContainsSubstring("[0, 1e12]"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.model = static_cast<ElasticModel>(9)}),
                    ContainsSubstring("unknown model 9"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.youngs_modulus = 0}),
                    ContainsSubstring("body 'b': youngs_modulus is 0"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.poissons_ratio = 0.5F}),
                    ContainsSubstring("poissons_ratio is 0.5"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.damping = nan}), ContainsSubstring("damping"));
  CHECK_THROWS_WITH(scene.add_body("b", box, {.max_stretch = 1}),
                    ContainsSubstring("max_stretch is 1"));
  CHECK_THROWS_WITH(scene.fix_vertices(0, std::vector<Index>{1, 8}),
                    ContainsSubstring("no vertex 8"));
  CHECK_FALSE(scene.is_fixed(1));
  CHECK_THROWS_WITH(scene.fix_vertices(1, {}), ContainsSubstring("no body 1"));
  CHECK_THROWS_WITH(scene.find_body("liver"), ContainsSubstring("the scene has: box"));
  CHECK_THROWS_WITH(scene.add_link({0, 8, 1, {}}), ContainsSubstring("vertex 8"));
  CHECK_THROWS_WITH(scene.add_link({3, 3, 1, {}}), ContainsSubstring("itself"));
  CHECK_THROWS_WITH(scene.add_link({0, 1, -1, {}}), ContainsSubstring("rest length -1"));
  CHECK_THROWS_AS(scene.set_gravity({0, nan, 0}), InvalidArgument);
  CHECK_THROWS_WITH(scene.add_particles("p", std::vector<Eigen::Vector3d>(1, {0, 0, 0}), 0),
                    ContainsSubstring("mass"));
  CHECK(scene.bodies().size() == 1);
  CHECK(scene.vertex_count() == 8);
  std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
  positions.emplace_back(1, 1, 1);
  scene.add_body("with a loose vertex", TetMesh(positions, {box.tets().begin(), box.tets().end()}),
                 testing::kSprings);
  CHECK_THROWS_WITH(scene.add_link({0, 16, 1, {}}),
                    ContainsSubstring("link 0 refers to vertex 16, which no tetrahedron has"));
  CHECK(scene.links().empty());
}

}  // namespace pbdsurg
