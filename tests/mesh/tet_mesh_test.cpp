// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/tet_mesh.h"

#include <limits>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;

std::vector<Eigen::Vector3d> corner(double edge) {
  return {{0, 0, 0}, {edge, 0, 0}, {0, edge, 0}, {0, 0, edge}};
}

}  // namespace

TEST_CASE("tet mesh: a right corner has a sixth of the cube", "[unit]") {
  const TetMesh mesh(corner(0.01), {{0, 1, 2, 3}});

  CHECK(total_volume(mesh) == Approx(1e-6 / 6));
  const std::vector<double> masses = lumped_masses(mesh, 1000);
  for (const double mass : masses) {
    CHECK(mass == Approx(1000 * 1e-6 / 24));
  }
}

TEST_CASE("tet mesh: what breaks a guarantee is refused by name", "[unit]") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  std::vector<Eigen::Vector3d> points = corner(1);

  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, 4}}), ContainsSubstring("refers to vertex 4"));
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, -1}}), ContainsSubstring("refers to vertex -1"));
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, 2}}), ContainsSubstring("uses a vertex twice"));
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 3, 2}}),
                    ContainsSubstring("tet 0") && ContainsSubstring("inverted"));
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, 3}, {1, 2, 0, 3}}),
                    ContainsSubstring("tet 1") && ContainsSubstring("repeats tet 0"));
  points[3] = {0.3, 0.3, 0};
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, 3}}), ContainsSubstring("is flat"));
  points[3].z() = nan;
  CHECK_THROWS_WITH(TetMesh(points, {{0, 1, 2, 3}}), ContainsSubstring("vertex 3"));
  CHECK_THROWS_AS(lumped_masses(TetMesh(), 0), InvalidArgument);
}

// Would catch an absolute tolerance: the same shapes must be judged alike in metres and
// micrometres.
TEST_CASE("tet mesh: flatness does not depend on the scale", "[property]") {
  const double edge = GENERATE(1e3, 1.0, 1e-3, 1e-6);
  std::vector<Eigen::Vector3d> points = corner(edge);

  points[3] = {edge / 3, edge / 3, 1e-9 * edge};
  CHECK_FALSE(is_flat(points, {0, 1, 2, 3}));
  points[3].z() = 1e-17 * edge;
  CHECK(is_flat(points, {0, 1, 2, 3}));
}

TEST_CASE("tet mesh: orientation swaps the inverted ones only", "[unit]") {
  const std::vector<Eigen::Vector3d> points = corner(1);
  std::vector<Tet> tets{{0, 1, 2, 3}, {0, 2, 1, 3}};

  CHECK(orient_tets(points, tets) == 1);
  CHECK(tets[0] == Tet{0, 1, 2, 3});
  CHECK(tet_volume(points, tets[1]) > 0);
}

}  // namespace pbdsurg
