// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/lattice.h"

#include <Eigen/Core>
#include <Eigen/LU>

#include "tests/support/catch.h"

namespace cholecystectomy {

// Would catch a part that is missing, doubled or wound the other way, and a point of another
// triangle.
TEST_CASE("lattice: its parts are equal, wound alike and tile each triangle", "[unit]") {
  const int subdivision = GENERATE(1, 2, 3, 5, 8);
  const Lattice lattice = make_lattice(subdivision, 7);
  REQUIRE(lattice.triangle_count == 7);
  REQUIRE(lattice.indices.size() ==
          static_cast<std::size_t>(3 * subdivision * subdivision * lattice.triangle_count));

  for (std::size_t i = 0; i < lattice.indices.size(); i += 3) {
    Eigen::Matrix3d corners;
    for (int corner = 0; corner < 3; ++corner) {
      const auto& [a, b, c, triangle] =
          lattice.points.at(lattice.indices[i + static_cast<std::size_t>(corner)]);
      REQUIRE(a + b + c == subdivision);
      REQUIRE(triangle == i / static_cast<std::size_t>(3 * subdivision * subdivision));
      corners.row(corner) << a, b, c;
    }
    // the volume over the corners is the area of a part, in parts of the whole's
    REQUIRE(corners.determinant() == pbdsurg::testing::Approx(subdivision));
  }
}

TEST_CASE("lattice: as many triangles as 16 bits can name", "[unit]") {
  CHECK(make_lattice(1).triangle_count == 8192);
  CHECK(make_lattice(3).triangle_count == 6553);
  CHECK(make_lattice(3).points.size() == 65530);
}

}  // namespace cholecystectomy
