// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/surgery/membrane.h"

#include <set>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"

#include "tests/support/bad_ids.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;
using testing::Approx;
using testing::ContainsSubstring;

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

namespace {

// A plate of a given thickness with its lower face at z.
TetMesh plate(Index cells, double edge, double thickness, double z) {
  const TetMesh box = testing::make_box({cells, cells, 1}, edge);
  std::vector<Vector3d> points(box.positions().begin(), box.positions().end());
  for (Vector3d& p : points) {
    p.z() = z + p.z() / edge * thickness;
  }
  return TetMesh(points, {box.tets().begin(), box.tets().end()});
}

Index count_fibres(const std::vector<MembraneLink>& links) {
  Index count = 0;
  for (const MembraneLink& link : links) {
    count += link.fibres;
  }
  return count;
}

}  // namespace

// Would catch strands that pierce an organ, reach too far, or hang on inner vertices; inside is
// judged by winding numbers, which share nothing with how links are found.
TEST_CASE("membrane: scattered links run between surfaces, outside of both bodies", "[property]") {
  const std::uint64_t seed = GENERATE(1, 2, 3);
  const TetMesh first = ball({0, 0, 0});
  const TetMesh second = ball({0.01, -0.02, 0.035});
  const std::set<Index> of_first = boundary_vertices(first), of_second = boundary_vertices(second);
  constexpr double kReach = 0.012;

  const auto links =
      scattered_links(first, second, {.max_distance = kReach, .density = 2e6, .seed = seed});

  const auto surface_of = [](const TetMesh& mesh) {
    std::vector<Triangle> triangles;
    for (const BoundaryTriangle& triangle : find_boundary(mesh.tets())) {
      triangles.push_back(triangle.vertices);
    }
    return SurfaceDistance(mesh.positions(), triangles);
  };
  const SurfaceDistance surfaces[] = {surface_of(first), surface_of(second)};
  CHECK(links.size() > 50);
  std::set<std::pair<Index, Index>> pairs;
  for (const MembraneLink& link : links) {
    const Vector3d a = first.positions()[link.first], b = second.positions()[link.second];
    CHECK(of_first.count(link.first) == 1);
    CHECK(of_second.count(link.second) == 1);
    CHECK(pairs.insert({link.first, link.second}).second);
    CHECK(link.fibres >= 1);
    CHECK(link.rest_length == Approx((b - a).norm()));
    CHECK(link.rest_length < kReach);
    for (const double share : {0.05, 0.3, 0.5, 0.7, 0.95}) {
      for (const SurfaceDistance& surface : surfaces) {
        CHECK(surface.signed_distance(a + share * (b - a)) > -1e-5);
      }
    }
  }
}

// Would catch a density that follows the mesh, and a seed that does nothing or not all.
TEST_CASE("membrane: fibres are as dense as asked on any mesh, and follow the seed", "[property]") {
  const Index cells = GENERATE(4, 10, 25);
  const double edge = 0.02 / cells;
  const TetMesh below = plate(cells, edge, 2e-3, 0), above = plate(cells, edge, 2e-3, 3e-3);
  const ScatterOptions options{.max_distance = 8e-3, .density = 3e6, .seed = 7};

  const auto links = scattered_links(below, above, options);

  CHECK(count_fibres(links) == Approx(3e6 * 0.02 * 0.02).epsilon(0.05));
  ScatterOptions other = options;
  other.seed = 8;
  const auto pairs = [](const std::vector<MembraneLink>& of) {
    std::vector<std::array<Index, 3>> result;
    for (const MembraneLink& link : of) {
      result.push_back({link.first, link.second, link.fibres});
    }
    return result;
  };
  CHECK(pairs(scattered_links(below, above, options)) == pairs(links));
  CHECK(pairs(scattered_links(below, above, other)) != pairs(links));
}

// Would catch strands from the far side of a thin organ, or through a part of it that lies between.
TEST_CASE("membrane: what is behind or covered is not linked", "[unit]") {
  const TetMesh lower = plate(6, 2e-3, 0.5e-3, 0), upper = plate(6, 2e-3, 0.5e-3, 1e-3);
  std::vector<Vector3d> points(lower.positions().begin(), lower.positions().end());
  std::vector<Tet> tets(lower.tets().begin(), lower.tets().end());
  points.insert(points.end(), upper.positions().begin(), upper.positions().end());
  for (Tet tet : upper.tets()) {
    for (Index& v : tet) {
      v += lower.vertex_count();
    }
    tets.push_back(tet);
  }
  const TetMesh both(points, tets);
  const TetMesh above = plate(6, 2e-3, 0.5e-3, 2e-3);

  const auto links = scattered_links(both, above, {.max_distance = 4e-3, .density = 5e6});

  CHECK(links.size() >= 49);
  for (const MembraneLink& link : links) {
    CHECK(both.positions()[link.first].z() == Approx(1.5e-3));
    CHECK(above.positions()[link.second].z() == Approx(2e-3));
  }
}

// Would catch fibres that follow vertices: a coarse plate has 16 of them, a fine one 625, and with
// 8 mm between the coarse one's vertices, links are longer than the gap may be.
TEST_CASE("membrane: links by area are as many on coarse meshes as on fine ones", "[property]") {
  constexpr double kSide = 0.024;
  const Index cells_below = GENERATE(3, 24), cells_above = GENERATE(3, 24);
  CAPTURE(cells_below, cells_above);
  const TetMesh below = plate(cells_below, kSide / cells_below, 1e-3, 0);
  const TetMesh above = plate(cells_above, kSide / cells_above, 1e-3, 2e-3);

  const auto links = links_by_area(below, above, {.max_distance = 1.5e-3, .density = 2e6});

  CHECK(count_fibres(links) == Approx(kSide * kSide * 2e6).epsilon(0.03));
  for (const MembraneLink& link : links) {
    const Vector3d& v = below.positions()[link.first];
    const Vector3d& w = above.positions()[link.second];
    CHECK(v.z() == Approx(1e-3));
    CHECK(w.z() == Approx(2e-3));
    CHECK(link.rest_length == Approx((w - v).norm()));
    // either vertex is nearest to the fibre
    CHECK((w - v).head<2>().norm() < 0.75 * (kSide / cells_below + kSide / cells_above));
  }
}

// Would catch fibres between far sides, or across more than they may span.
TEST_CASE("membrane: links by area run where surfaces face each other", "[unit]") {
  const TetMesh below = plate(12, 2e-3, 0.5e-3, 0), above = plate(12, 2e-3, 0.5e-3, 1e-3);
  for (const MembraneLink& link : links_by_area(below, above, {.max_distance = 4e-3})) {
    CHECK(below.positions()[link.first].z() == Approx(0.5e-3));
    CHECK(above.positions()[link.second].z() == Approx(1e-3));
  }
  CHECK(links_by_area(below, above, {.max_distance = 0.4e-3}).empty());
}

// Would catch an enclosed organ that hangs on the surface of what encloses it, or on nothing.
TEST_CASE("membrane: links by area hold what lies inside, too", "[unit]") {
  TetrahedralizeOptions options;
  options.spacing = 0.004;
  const TetMesh inner = tetrahedralize(sphere_shape({0, 0, 0}, 0.01), options).mesh;
  const TetMesh outer = tetrahedralize(sphere_shape({0, 0, 0}, 0.04), options).mesh;
  constexpr double kArea = 4 * 3.14159 * 1e-4;

  const auto links = links_by_area(inner, outer, {.max_distance = 1e-3, .density = 1e6});

  CHECK(count_fibres(links) == Approx(kArea * 1e6).epsilon(0.05));
  for (const MembraneLink& link : links) {
    CHECK(outer.positions()[link.second].norm() < 0.015);
  }
}

TEST_CASE("membrane: nothing near, no link; no sense, no answer", "[unit]") {
  const TetMesh mesh = ball({0, 0, 0});
  const TetMesh other = ball({1, 0, 0});
  CHECK(membrane_links(mesh, other, 0.008).empty());
  CHECK(membrane_links(mesh, TetMesh(), 0.008).empty());
  CHECK_THROWS_AS(membrane_links(mesh, other, 0), InvalidArgument);
  CHECK(scattered_links(mesh, other, {}).empty());
  CHECK(scattered_links(TetMesh(), mesh, {}).empty());
  CHECK(links_by_area(mesh, other, {}).empty());
  CHECK(links_by_area(mesh, TetMesh(), {}).empty());
  CHECK(links_by_area(TetMesh(), mesh, {}).empty());
  CHECK_THROWS_WITH(links_by_area(mesh, other, {.max_distance = -1}),
                    ContainsSubstring("max_distance is -1 m"));
  CHECK_THROWS_WITH(scattered_links(mesh, other, {.max_distance = -1}),
                    ContainsSubstring("max_distance is -1 m"));
  CHECK_THROWS_WITH(scattered_links(mesh, other, {.density = 0}),
                    ContainsSubstring("density is 0 fibres"));
  CHECK_THROWS_WITH(scattered_links(mesh, other, {.density = 1e30}), ContainsSubstring("1e8"));
  CHECK_THROWS_WITH(membrane_links(mesh, mesh, 0.008), ContainsSubstring("to itself"));
  CHECK_THROWS_WITH(scattered_links(mesh, mesh, {}), ContainsSubstring("to itself"));
  CHECK_THROWS_WITH(links_by_area(mesh, mesh, {}), ContainsSubstring("to itself"));
  for (const Index bad : testing::bad_ids(mesh.vertex_count())) {
    const MembraneLink forth{bad, 0, 1e-3}, back{0, bad, 1e-3};
    CHECK_THROWS_AS(membrane_sheet(mesh, mesh, std::span(&forth, 1)), InvalidArgument);
    CHECK_THROWS_AS(membrane_sheet(mesh, mesh, std::span(&back, 1)), InvalidArgument);
  }
}

}  // namespace pbdsurg
