// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;

TetMesh filled(const ImplicitShape& shape, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  return tetrahedralize(shape, options).mesh;
}

// All organs but the gallbladder and the liver from one small ball, to keep a test short.
CholecystectomyOptions with_stand_ins() {
  const TetMesh ball = filled(sphere_shape({1, 0, 0}, 0.01), 0.005);
  CholecystectomyOptions options;
  options.cystic_duct = options.cystic_artery = options.common_bile_duct = options.calot_fat = ball;
  return options;
}

double least_value(const ImplicitShape& shape, const TetMesh& mesh) {
  double least = 1;
  for (const Vector3d& point : mesh.positions()) {
    least = std::min(least, shape(point));
  }
  return least;
}

}  // namespace

TEST_CASE("cholecystectomy anatomy: organs are as large as the paper's largest", "[property]") {
  const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy();
  const auto is_between = [](const TetMesh& mesh, Index low, Index high) {
    return mesh.tet_count() >= low && mesh.tet_count() <= high;
  };
  CHECK(is_between(anatomy.gallbladder, 22611, 24500));
  CHECK(is_between(anatomy.liver, 19729, 24000));
  CHECK(is_between(anatomy.calot_fat, 12000, 16000));
  CHECK(is_between(anatomy.cystic_duct, 3000, 5000));
  CHECK(is_between(anatomy.cystic_artery, 3000, 5000));
  CHECK(is_between(anatomy.common_bile_duct, 3000, 5000));
  for (const TetMesh* mesh :
       {&anatomy.gallbladder, &anatomy.liver, &anatomy.calot_fat, &anatomy.cystic_duct,
        &anatomy.cystic_artery, &anatomy.common_bile_duct}) {
    CHECK(find_components(mesh->vertex_count(), mesh->tets()).count == 1);
  }
}

TEST_CASE("cholecystectomy anatomy: a user's shape gets a wall and a bed of its own", "[unit]") {
  const ImplicitShape own = ellipsoid_shape({0.03, 0, 0.015}, {0.04, 0.02, 0.018});
  CholecystectomyOptions options = with_stand_ins();
  options.gallbladder = own;
  options.wall_thickness = 4e-3;

  const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy(options);

  // the wall is thinner than its outside by far
  CHECK(total_volume(anatomy.gallbladder) < 0.6 * total_volume(filled(own, 4e-3)));
  CHECK(least_value(own, anatomy.liver) > 0.5e-3);
  CHECK(total_volume(anatomy.liver) < 0.99 * total_volume(filled(liver_block(), 7e-3)));
}

// The liver must not grow into the lumen of a hollow mesh.
TEST_CASE("cholecystectomy anatomy: a user's mesh is kept and bedded", "[unit]") {
  const ImplicitShape outside = sphere_shape({0.03, 0, 0.02}, 0.02);
  const TetMesh own = filled(shell_shape(outside, 3e-3), 2.6e-3);
  CholecystectomyOptions options = with_stand_ins();
  options.gallbladder = own;

  const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy(options);

  CHECK(std::equal(anatomy.gallbladder.tets().begin(), anatomy.gallbladder.tets().end(),
                   own.tets().begin(), own.tets().end()));
  CHECK(least_value(outside, anatomy.liver) > 0.3e-3);
  const ImplicitShape solid = filled_shape(own);
  CHECK(solid({0.03, 0, 0.02}) == Approx(-0.02).epsilon(0.05));
}

TEST_CASE("cholecystectomy anatomy: what cannot be made is refused", "[unit]") {
  CholecystectomyOptions options = with_stand_ins();
  options.wall_thickness = 0;
  CHECK_THROWS_AS(make_cholecystectomy_anatomy(options), InvalidArgument);
  CHECK_THROWS_AS(filled_shape(TetMesh()), InvalidMesh);
}

}  // namespace pbdsurg
