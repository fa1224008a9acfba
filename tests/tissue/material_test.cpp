// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/material.h"

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {

using testing::ContainsSubstring;

// Would catch a property of the solid that its springs forget, and volume that a tube gets back.
TEST_CASE("material: springs have the compliances of the solid's moduli, and all else of it",
          "[unit]") {
  const TetMesh mesh = testing::make_box({4, 2, 2}, 2e-3);
  Material solid{.density = 900,
                 .model = ElasticModel::neo_hookean,
                 .stretch = {0.3F, 0},
                 .volume = {0.7F, 0},
                 .has_volume_constraints = GENERATE(false, true),
                 .youngs_modulus = 20e3F,
                 .poissons_ratio = 0.4F,
                 .damping = 2e-3F,
                 .max_stretch = 1.3F};
  const Material made = springs(mesh, solid);
  const Material elastic = elastic_material(mesh, 900, 20e3F, 0.4F);
  CHECK(made.model == ElasticModel::springs);
  CHECK(made.stretch.compliance == elastic.stretch.compliance);
  CHECK(made.volume.compliance == elastic.volume.compliance);
  CHECK(made.stretch.compliance > 0);
  CHECK(made.stretch.fraction == solid.stretch.fraction);
  CHECK(made.volume.fraction == solid.volume.fraction);
  CHECK(made.has_volume_constraints == solid.has_volume_constraints);
  CHECK(made.density == solid.density);
  CHECK(made.damping == solid.damping);
  CHECK(made.max_stretch == solid.max_stretch);
}

TEST_CASE("material: springs of what has no moduli, or no tetrahedra, are refused", "[unit]") {
  const TetMesh mesh = testing::make_box({1, 1, 1}, 2e-3);
  Material solid{.model = ElasticModel::neo_hookean};
  CHECK_THROWS_WITH(springs(mesh, {.model = ElasticModel::springs}),
                    ContainsSubstring("Neo-Hookean"));
  CHECK_THROWS_WITH(springs(TetMesh(), solid), ContainsSubstring("tetrahedra"));
  solid.youngs_modulus = 0;
  CHECK_THROWS_WITH(springs(mesh, solid), ContainsSubstring("Young's modulus"));
}

}  // namespace pbdsurg
