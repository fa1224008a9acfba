// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <numbers>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;
using testing::ContainsSubstring;

TetMesh filled(const ImplicitShape& shape, double spacing) {
  TetrahedralizeOptions options;
  options.spacing = spacing;
  return tetrahedralize(shape, options).mesh;
}

// All organs but the gallbladder and the liver from one small ball, to keep a test short.
CholecystectomyOptions with_stand_ins() {
  const TetMesh ball = filled(sphere_shape({1, 0, 0}, 0.01), 0.005);
  CholecystectomyOptions options;
  for (const Organ organ :
       {Organ::cystic_duct, Organ::cystic_artery, Organ::common_bile_duct, Organ::calot_fat}) {
    options.own.emplace(organ, ball);
  }
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
  const auto is_between = [&anatomy](Organ organ, Index low, Index high) {
    const Index count = anatomy.organs.at(organ).tet_count();
    return count >= low && count <= high;
  };
  CHECK(is_between(Organ::gallbladder, 22611, 24500));
  CHECK(is_between(Organ::liver, 19729, 24000));
  CHECK(is_between(Organ::calot_fat, 12000, 16000));
  CHECK(is_between(Organ::cystic_duct, 3000, 5000));
  CHECK(is_between(Organ::cystic_artery, 3000, 5000));
  CHECK(is_between(Organ::common_bile_duct, 3000, 5000));
  CHECK(anatomy.organs.size() == kOrgans.size());
  CHECK_FALSE(anatomy.abdominal_wall.triangles.empty());
}

TEST_CASE("cholecystectomy anatomy: every recipe gives well-shaped tetrahedra", "[property]") {
  for (const Organ organ : kOrgans) {
    CAPTURE(name_of(organ));
    const OrganRecipe recipe = organ_recipe(organ);
    const TetrahedralizeReport report = tetrahedralize(recipe.shape, recipe.options).report;
    CHECK(report.min_dihedral > 20 * std::numbers::pi / 180);
    CHECK(report.meshes_made == 1);
    CHECK(report.pieces == 1);
    CHECK(report.bridges == 0);
    CHECK(report.thin_share < 0.02);
  }
}

// Would catch a built-in organ that its own range refuses, or that a guess takes for another unit.
TEST_CASE("cholecystectomy anatomy: every organ is recognised in every unit", "[unit]") {
  for (const Organ organ : kOrgans) {
    const OrganRecipe recipe = organ_recipe(organ);
    const double side = recipe.shape(recipe.options.spacing).bounds().sizes().maxCoeff();
    const LengthRange range = plausible_length(organ);
    CAPTURE(name_of(organ), side);
    CHECK(range.contains(0.7 * side));
    CHECK(range.contains(1.4 * side));
    CHECK(range.longest < 10 * range.shortest);
    CHECK(range.shortest >= kAnyOrgan.shortest);
    CHECK(range.longest <= kAnyOrgan.longest);
    for (const LengthUnit unit : kLengthUnits) {
      const LengthUnitGuess guess = guess_length_unit(side / metres_per(unit), range);
      CHECK(guess.unit == unit);
      CHECK_FALSE(guess.ambiguous());
    }
  }
  CHECK(guess_length_unit(12, plausible_length(Organ::cystic_artery)).plausible ==
        std::vector<LengthUnit>{LengthUnit::millimetre});
  CHECK_THROWS_AS(plausible_length(static_cast<Organ>(77)), InvalidArgument);
}

TEST_CASE("cholecystectomy anatomy: a coarser wall grows thick enough", "[unit]") {
  OrganRecipe recipe = organ_recipe(Organ::gallbladder);
  recipe.options.spacing = 0;
  recipe.options.vertex_count = 2500;
  const TetrahedralizeReport report = tetrahedralize(recipe.shape, recipe.options).report;
  CHECK(report.euler == 2);
  CHECK(report.spacing > 3.5e-3);
}

TEST_CASE("cholecystectomy anatomy: a user's shape gets a wall and a bed of its own", "[unit]") {
  const ImplicitShape own = ellipsoid_shape({0.03, 0, 0.015}, {0.04, 0.02, 0.018});
  CholecystectomyOptions options = with_stand_ins();
  options.own.emplace(Organ::gallbladder, own);
  options.wall_thickness = 4e-3;

  const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy(options);

  // the wall is thinner than its outside by far
  CHECK(total_volume(anatomy.organs.at(Organ::gallbladder)) <
        0.6 * total_volume(filled(own, 4e-3)));
  CHECK(least_value(own, anatomy.organs.at(Organ::liver)) > 0.5e-3);
  CHECK(total_volume(anatomy.organs.at(Organ::liver)) <
        0.99 * total_volume(filled(liver_block(), 7e-3)));
}

// The liver must not grow into the lumen of a hollow mesh.
TEST_CASE("cholecystectomy anatomy: a user's mesh is kept and bedded", "[unit]") {
  const ImplicitShape outside = sphere_shape({0.03, 0, 0.02}, 0.02);
  const TetMesh own = filled(shell_shape(outside, 3e-3), 2.6e-3);
  CholecystectomyOptions options = with_stand_ins();
  options.own.emplace(Organ::gallbladder, own);

  const CholecystectomyAnatomy anatomy = make_cholecystectomy_anatomy(options);

  const TetMesh& kept = anatomy.organs.at(Organ::gallbladder);
  CHECK(std::equal(kept.tets().begin(), kept.tets().end(), own.tets().begin(), own.tets().end()));
  CHECK(least_value(outside, anatomy.organs.at(Organ::liver)) > 0.3e-3);
  const ImplicitShape solid = filled_shape(own);
  CHECK(solid({0.03, 0, 0.02}) == Approx(-0.02).epsilon(0.05));
}

// Would catch tubes that get holes, or a coarser scene that is not cheaper.
TEST_CASE("cholecystectomy anatomy: coarser cells give the same organs in a third", "[property]") {
  const CholecystectomyAnatomy fine = make_cholecystectomy_anatomy();
  CholecystectomyOptions options;
  options.coarsening = 1.5;
  const CholecystectomyAnatomy coarse = make_cholecystectomy_anatomy(options);
  Index fine_count = 0, coarse_count = 0;
  for (const Organ organ : kOrgans) {
    CAPTURE(name_of(organ));
    fine_count += fine.organs.at(organ).tet_count();
    coarse_count += coarse.organs.at(organ).tet_count();
    const Eigen::AlignedBox3d full = bounding_box(fine.organs.at(organ)),
                              low = bounding_box(coarse.organs.at(organ));
    CHECK((low.center() - full.center()).norm() < 0.03 * full.sizes().norm());
    CHECK(low.sizes().norm() == Approx(full.sizes().norm()).epsilon(0.03));
  }
  CHECK(coarse_count < 0.36 * fine_count);
}

TEST_CASE("cholecystectomy anatomy: what cannot be made is refused", "[unit]") {
  CholecystectomyOptions options = with_stand_ins();
  options.wall_thickness = 0;
  CHECK_THROWS_AS(make_cholecystectomy_anatomy(options), InvalidArgument);
  for (const double coarsening : {0.0, -1.0, std::numeric_limits<double>::infinity()}) {
    options = with_stand_ins();
    options.coarsening = coarsening;
    CHECK_THROWS_WITH(make_cholecystectomy_anatomy(options), ContainsSubstring("coarsening"));
  }
  CHECK_THROWS_AS(filled_shape(TetMesh()), InvalidMesh);
}

// Would catch a refusal that leaves open which of several organs it means.
TEST_CASE("cholecystectomy anatomy: what is too thin to fill is refused by its name", "[unit]") {
  const ImplicitShape thread = sphere_shape({0, 0, 0}, 1e-4);
  CHECK_THROWS_AS(fill_organ(Organ::calot_fat, thread), InvalidMesh);
  CholecystectomyOptions options = with_stand_ins();
  options.own.insert_or_assign(Organ::calot_fat, thread);
  CHECK_THROWS_WITH(make_cholecystectomy_anatomy(options),
                    testing::ContainsSubstring("calot_fat: no sound mesh"));
}

// Would catch a resolution that is asked for in vain.
TEST_CASE("cholecystectomy anatomy: an organ is filled with the vertices wanted", "[unit]") {
  const ImplicitShape block = ellipsoid_shape({0, 0, 0}, {0.06, 0.04, 0.03});
  const Index default_count = fill_organ(Organ::liver, block).mesh.vertex_count();
  for (const Index wanted : {default_count / 3, 2 * default_count}) {
    CHECK(fill_organ(Organ::liver, block, 2.7e-3, wanted).mesh.vertex_count() ==
          Approx(wanted).epsilon(0.1));
  }
}

}  // namespace pbdsurg
