// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/anatomy/membrane.h"

#include <set>

#include "pbdsurg/core/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;

TetMesh ball(const Vector3d& center) {
  TetrahedralizeOptions options;
  options.spacing = 0.004;
  return tetrahedralize(sphere_shape(center, 0.02), options).mesh;
}

std::set<Index> boundary_vertices(const TetMesh& mesh) {
  std::set<Index> vertices;
  for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
    vertices.insert(triangle.vertices.begin(), triangle.vertices.end());
  }
  return vertices;
}

}  // namespace

// Against every pair. Would catch a neighbour that is missed in another cell.
TEST_CASE("membrane: every near vertex is linked to its nearest", "[property]") {
  const TetMesh first = ball({0, 0, 0});
  const TetMesh second = ball({0.01, -0.02, 0.035});
  constexpr double kReach = 0.008;
  const std::set<Index> others = boundary_vertices(second);

  const std::vector<MembraneLink> links = membrane_links(first, second, kReach);

  std::size_t found = 0;
  for (const Index v : boundary_vertices(first)) {
    Index nearest = kInvalidIndex;
    double distance = kReach;
    for (const Index w : others) {
      const double d = (first.positions()[v] - second.positions()[w]).norm();
      if (d < distance) {
        distance = d;
        nearest = w;
      }
    }
    if (nearest != kInvalidIndex) {
      REQUIRE(found < links.size());
      CHECK(links[found].first == v);
      CHECK(links[found].second == nearest);
      CHECK(links[found].rest_length == Approx(distance));
      ++found;
    }
  }
  CHECK(found == links.size());
  CHECK(found > 10);
}

TEST_CASE("membrane: the sheet lies halfway", "[unit]") {
  const TetMesh first = ball({0, 0, 0});
  const TetMesh second = ball({0, 0, 0.043});
  const std::vector<MembraneLink> links = membrane_links(first, second, 0.008);

  const MeshData sheet = membrane_sheet(first, second, links);

  REQUIRE(sheet.points.size() == links.size());
  CHECK_FALSE(sheet.triangles.empty());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const double to_first = (sheet.points[i] - first.positions()[links[i].first]).norm();
    CHECK(to_first == Approx(links[i].rest_length / 2));
  }
  for (const Triangle& triangle : sheet.triangles) {
    for (const Index v : triangle) {
      REQUIRE(v >= 0);
      REQUIRE(v < static_cast<Index>(sheet.points.size()));
    }
  }
}

TEST_CASE("membrane: nothing near, no link; no sense, no answer", "[unit]") {
  const TetMesh mesh = ball({0, 0, 0});
  CHECK(membrane_links(mesh, ball({1, 0, 0}), 0.008).empty());
  CHECK(membrane_links(mesh, TetMesh(), 0.008).empty());
  CHECK_THROWS_AS(membrane_links(mesh, mesh, 0), InvalidArgument);
}

}  // namespace pbdsurg
