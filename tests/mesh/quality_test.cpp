// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/mesh/quality.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using testing::Approx;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr Tet kTet{0, 1, 2, 3};

std::vector<Eigen::Vector3d> regular(double scale) {
  return {{scale, scale, scale},
          {scale, -scale, -scale},
          {-scale, scale, -scale},
          {-scale, -scale, scale}};
}

}  // namespace

TEST_CASE("quality: a regular tet is ideal at every scale and orientation", "[unit]") {
  for (const double scale : {1e3, 1.0, 1e-5}) {
    for (const Tet& tet : {kTet, Tet{1, 0, 2, 3}}) {
      for (const double angle : dihedral_angles(regular(scale), tet)) {
        CHECK(angle == Approx(std::acos(1.0 / 3)));
      }
      CHECK(radius_ratio(regular(scale), tet) == Approx(1));
    }
  }
}

TEST_CASE("quality: angles of a right corner are in the order of its edges", "[unit]") {
  const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

  const auto angles = dihedral_angles(points, kTet);

  for (std::size_t e = 0; e < 6; ++e) {
    const bool at_corner = kTetEdges[e][0] == 0;
    CHECK(angles[e] * kDegrees ==
          Approx(at_corner ? 90 : std::acos(std::sqrt(1.0 / 3)) * kDegrees));
  }
  // inscribed radius 1 / (3 + sqrt 3), circumscribed radius sqrt(3) / 2
  CHECK(radius_ratio(points, kTet) == Approx(6 / (std::sqrt(3.0) * (3 + std::sqrt(3.0)))));
}

// Would catch a dihedral angle on the wrong edge: a sliver has two edges near pi and four near 0.
TEST_CASE("quality: slivers keep small and large angles apart", "[unit]") {
  const double height = 1e-6;
  const std::vector<Eigen::Vector3d> points{{1, 0, 0}, {0, 1, height}, {-1, 0, 0}, {0, -1, height}};

  const auto angles = dihedral_angles(points, kTet);

  // the diagonals 0-2 and 1-3 are nearly pi, the four sides nearly 0
  for (std::size_t e = 0; e < 6; ++e) {
    const bool diagonal = e == 1 || e == 4;
    CHECK((diagonal ? std::numbers::pi - angles[e] : angles[e]) < 1e-5);
    CHECK((diagonal ? std::numbers::pi - angles[e] : angles[e]) > 1e-7);
  }
  CHECK(radius_ratio(points, kTet) < 1e-5);
  CHECK(radius_ratio(points, {0, 1, 2, 2}) == 0);
}

TEST_CASE("quality: random tets keep to the bounds of geometry", "[property]") {
  for (std::uint64_t round = 0; round < 200; ++round) {
    std::vector<Eigen::Vector3d> points(4);
    for (std::uint64_t i = 0; i < 12; ++i) {
      points[i / 3][static_cast<Eigen::Index>(i % 3)] = random_unit(3, i, round);
    }
    const auto angles = dihedral_angles(points, kTet);
    const double sum = angles[0] + angles[1] + angles[2] + angles[3] + angles[4] + angles[5];

    // the sum of the six lies between 2 pi and 3 pi (Gaddum 1952)
    CHECK(sum > 2 * std::numbers::pi);
    CHECK(sum < 3 * std::numbers::pi);
    const double ratio = radius_ratio(points, kTet);
    CHECK(ratio > 0);
    CHECK(ratio <= 1);
  }
}

TEST_CASE("quality: valence and edge lengths", "[unit]") {
  const std::vector<Tet> tets{{0, 1, 2, 3}, {1, 2, 3, 4}};
  const std::vector<Eigen::Vector3d> points{{0, 0, 0}, {3, 4, 0}};

  CHECK(count_vertex_tets(6, tets) == std::vector<Index>{1, 2, 2, 2, 1, 0});
  CHECK(edge_lengths(points, std::vector<Edge>{{0, 1}}) == std::vector<double>{5});
}

}  // namespace pbdsurg
