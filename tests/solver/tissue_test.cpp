// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/tissue.h"

#include "pbdsurg/core/error.h"
#include "pbdsurg/solver/solver.h"

#include "support/catch.h"
#include "support/meshes.h"

namespace pbdsurg {

using testing::ContainsSubstring;

TEST_CASE("tissue: every tissue makes a body that steps, as a solid and as a tube", "[unit]") {
  const Tissue tissue = GENERATE(Tissue::liver, Tissue::gallbladder_wall, Tissue::fat, Tissue::duct,
                                 Tissue::artery, Tissue::membrane);
  INFO(name_of(tissue));
  const TetMesh mesh = testing::make_box({4, 2, 2}, 2e-3);
  const Material solid = tissue_material(tissue);
  const Material tube = tube_material(mesh, tissue);
  CHECK(solid.model == ElasticModel::neo_hookean);
  CHECK(tube.model == ElasticModel::springs);
  CHECK_FALSE(tube.has_volume_constraints);
  CHECK(tube.density == solid.density);
  CHECK(tube.max_stretch == solid.max_stretch);

  Scene scene;
  scene.add_body("solid", mesh, solid);
  scene.add_body("tube", mesh, tube);
  for (const Index body : {0, 1}) {
    scene.fix_where(body, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  }
  Solver solver(scene);
  StepReport report;
  for (int i = 0; i < 50; ++i) {
    report = solver.step(0.01F);
  }
  CHECK(report.non_finite_vertices == 0);
  CHECK(report.inverted_tets == 0);
}

TEST_CASE("tissue: organs are softer than their vessels, and strangers are refused", "[unit]") {
  CHECK(tissue_material(Tissue::fat).youngs_modulus <
        tissue_material(Tissue::liver).youngs_modulus);
  CHECK(tissue_material(Tissue::liver).youngs_modulus <
        tissue_material(Tissue::artery).youngs_modulus);
  CHECK(std::string(name_of(Tissue::gallbladder_wall)) == "gallbladder_wall");
  CHECK_THROWS_WITH(tissue_material(static_cast<Tissue>(77)), ContainsSubstring("no tissue 77"));
}

}  // namespace pbdsurg
