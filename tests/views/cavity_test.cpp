// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/views/cavity.h"

#include <algorithm>
#include <array>
#include <functional>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/scene.h"

#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_refused;

constexpr double kEdge = 4e-3;  // m
constexpr double kCube = kEdge * kEdge * kEdge;

// A box of 5 x 5 x 5 cubes.
Scene box_scene() {
  Scene scene;
  scene.add_body("box", testing::make_box({5, 5, 5}, kEdge));
  return scene;
}

using Where = std::function<bool(const Eigen::Vector3d&)>;  // in cubes

std::vector<Index> tets_where(const Tissue& tissue, const Where& is_in) {
  std::vector<Index> found;
  const auto x = tissue.rest_positions();
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); ++t) {
    const Tet& tet = tissue.tets()[t];
    const Eigen::Vector3d middle = (x[tet[0]] + x[tet[1]] + x[tet[2]] + x[tet[3]]) / 4;
    if (tissue.is_tet_alive(t) && is_in(middle / kEdge)) {
      found.push_back(t);
    }
  }
  return found;
}

void remove(Tissue& tissue, const Where& is_in) {
  tissue.apply({.remove_tets = tets_where(tissue, is_in)});
}

// Cubes [first, last] along x, of the middle of the box.
Where cubes(double first, double last) {
  return [=](const Eigen::Vector3d& x) {
    return x.x() > first && x.x() < last + 1 && x.y() > 2 && x.y() < 3 && x.z() > 2 && x.z() < 3;
  };
}

std::vector<Eigen::Vector3f> places(const Tissue& tissue) {
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : tissue.rest_positions()) {
    positions.push_back(x.cast<float>());
  }
  return positions;
}

// With its smallest corner first, winding kept.
std::vector<Triangle> sorted(std::span<const Triangle> triangles) {
  std::vector<Triangle> result(triangles.begin(), triangles.end());
  for (Triangle& t : result) {
    std::rotate(t.begin(), std::ranges::min_element(t), t.end());
  }
  std::ranges::sort(result);
  return result;
}

}  // namespace

// Would catch an outer surface that is taken for a hollow, one hollow for two, and a wall that is
// wound the wrong way.
TEST_CASE("cavity: hollows of a body are found, each by itself", "[unit]") {
  Tissue tissue(box_scene());
  CHECK(find_cavities(tissue, 0).empty());
  remove(tissue, cubes(1, 1));
  remove(tissue, cubes(3, 3));
  const auto cavities = find_cavities(tissue, 0);
  REQUIRE(cavities.size() == 2);
  for (const auto& wall : cavities) {
    CHECK(wall.size() == 12);
    const Cavity cavity(tissue, wall);
    CHECK(cavity.volume(places(tissue)) == Approx(kCube).epsilon(1e-5));
    CHECK(cavity.vertices().size() == 8);
    CHECK(!cavity.is_open());
    CHECK(cavity.hole_area(places(tissue)) == 0);
  }
  CHECK_THROWS_AS(find_cavities(tissue, 1), InvalidArgument);
}

// Would catch hollows that meet along an edge taken for one.
TEST_CASE("cavity: hollows that meet along an edge are two", "[unit]") {
  Tissue tissue(box_scene());
  remove(tissue, [](const Eigen::Vector3d& x) {
    return x.z() > 2 && x.z() < 3 &&
           ((x.x() > 1 && x.x() < 2 && x.y() > 1 && x.y() < 2) ||
            (x.x() > 2 && x.x() < 3 && x.y() > 2 && x.y() < 3));
  });
  CHECK(find_cavities(tissue, 0).size() == 2);
}

// Would catch a crater that is not of the wall, a hole whose rim is not where tissue is thinnest,
// one that an undo leaves behind, and a wall that keeps old ids.
TEST_CASE("cavity: it grows with craters, opens with a hole, and closes with an undo", "[unit]") {
  Tissue tissue(box_scene());
  remove(tissue, cubes(2, 2));
  Cavity cavity(tissue, find_cavities(tissue, 0)[0]);
  remove(tissue, cubes(3, 3));
  CHECK(!cavity.is_open());
  CHECK(cavity.volume(places(tissue)) == Approx(2 * kCube).epsilon(1e-5));
  CHECK(sorted(cavity.triangles()) == sorted(find_cavities(tissue, 0)[0]));
  const std::vector<Triangle> closed(cavity.triangles().begin(), cavity.triangles().end());
  const std::uint64_t version = cavity.version();

  remove(tissue, cubes(4, 4));
  CHECK(cavity.is_open());
  CHECK(cavity.hole_count() == 1);
  CHECK(cavity.hole_area(places(tissue)) == Approx(kEdge * kEdge).epsilon(1e-5));
  CHECK(cavity.volume(places(tissue)) == Approx(2 * kCube).epsilon(1e-5));
  CHECK(cavity.version() != version);
  CHECK_THROWS_AS(cavity.caps(1), InvalidArgument);

  tissue.undo();
  CHECK(!cavity.is_open());
  CHECK(std::ranges::equal(cavity.triangles(), closed));

  remove(tissue, cubes(1, 1));
  tissue.undo();
  remove(tissue, [](const Eigen::Vector3d& x) { return x.y() < 1; });  // far from it
  tissue.undo();
  CHECK(std::ranges::equal(cavity.triangles(), closed));
}

// Would catch holes whose rims are mixed up, and a wall that an opened lumen loses or keeps
// wrongly.
TEST_CASE("cavity: each hole has its rim, until no wall is left", "[unit]") {
  Tissue tissue(box_scene());
  remove(tissue, cubes(2, 2));
  Cavity cavity(tissue, find_cavities(tissue, 0)[0]);
  remove(tissue, [](const Eigen::Vector3d& x) { return cubes(0, 1)(x) || cubes(3, 4)(x); });
  CHECK(cavity.hole_count() == 2);
  CHECK(cavity.hole_area(places(tissue)) == Approx(2 * kEdge * kEdge).epsilon(1e-5));
  CHECK(cavity.volume(places(tissue)) == Approx(kCube).epsilon(1e-5));
  CHECK(cavity.wall_count() == 8);
  remove(tissue, [](const Eigen::Vector3d& x) { return x.y() > 3; });
  CHECK(cavity.hole_count() == 1);  // of three sides, of which two face each other
  CHECK(cavity.hole_area(places(tissue)) == Approx(kEdge * kEdge).epsilon(1e-5));
  tissue.apply({.remove_bodies = {0}});
  CHECK(cavity.is_open());
  CHECK(cavity.triangles().empty());
  CHECK(cavity.volume(places(tissue)) == 0);
  tissue.undo();
  CHECK(cavity.wall_count() > 0);
}

// Would catch parts of divided tetrahedra that the wall loses, or takes though they lie within.
TEST_CASE("cavity: a wall whose tetrahedra are divided is the same surface", "[property]") {
  Tissue tissue(box_scene());
  remove(tissue, cubes(2, 2));
  Cavity cavity(tissue, find_cavities(tissue, 0)[0]);
  for (int round = 0; round < 6; ++round) {
    const Triangle wall =
        cavity.triangles()[static_cast<std::size_t>(3 * round) % cavity.triangles().size()];
    const Index a = wall[round % 3], b = wall[(round + 1) % 3];
    TopologyEdit edit;
    edit.new_vertices.push_back({a, b, 0.4F});
    for (const Index t : tissue.tets_at(a)) {
      const Tet& tet = tissue.tets()[t];
      if (std::ranges::find(tet, b) == tet.end()) {
        continue;
      }
      for (const Index gone : {a, b}) {
        NewTet part{t, tet};
        std::ranges::replace(part.vertices, gone, tissue.vertex_count());
        edit.new_tets.push_back(part);
      }
    }
    tissue.apply(edit);
    CHECK(!cavity.is_open());
    CHECK(cavity.volume(places(tissue)) == Approx(kCube).epsilon(1e-5));
    CHECK(sorted(cavity.triangles()) == sorted(find_cavities(tissue, 0)[0]));
  }
  CHECK(cavity.wall_count() == 12 + 2 * 6);
}

// Would catch a wall that goes on to the wrong face where several meet at an edge, or that knows a
// hollow only by what an edit has touched.
TEST_CASE("cavity: after random removals it is what a search finds, or open", "[property]") {
  Tissue tissue(box_scene());
  remove(tissue, cubes(2, 2));
  Cavity cavity(tissue, find_cavities(tissue, 0)[0]);
  int opened = 0, grown = 0;
  for (std::uint64_t round = 0; round < 400; ++round) {
    const std::vector<Index> near = tets_where(tissue, [](const Eigen::Vector3d& x) {
      return (x - Eigen::Vector3d(2.5, 2.5, 2.5)).cwiseAbs().maxCoeff() < 2.3;
    });
    const std::vector<Triangle> before(cavity.triangles().begin(), cavity.triangles().end());
    const auto walls = cavity.origins();
    const Index tet = round % 2 == 0 ? near[random_bits(7, round) % near.size()]
                                     : walls[random_bits(7, round) % walls.size()].tet;
    tissue.apply({.remove_tets = {tet}});
    const auto found = find_cavities(tissue, 0);
    const auto is_it = [&](const std::vector<Triangle>& wall) {
      return sorted(wall) == sorted(cavity.triangles());
    };
    const auto shares_wall = [&](const std::vector<Triangle>& wall) {
      const auto own = sorted(cavity.triangles().first(cavity.wall_count()));
      return std::ranges::any_of(sorted(wall), [&](const Triangle& triangle) {
        return std::ranges::binary_search(own, triangle);
      });
    };
    CAPTURE(round, found.size());
    if (cavity.is_open()) {
      REQUIRE(std::ranges::none_of(found, shares_wall));
      ++opened;
    } else {
      REQUIRE(std::ranges::count_if(found, is_it) == 1);
      grown += cavity.triangles().size() > before.size() ? 1 : 0;
    }
    if (cavity.is_open() || round % 3 == 0) {
      tissue.undo();
      REQUIRE(std::ranges::equal(cavity.triangles(), before));
    }
  }
  CHECK(opened > 5);
  CHECK(grown > 20);
}

// Would catch a wall that is accepted though pressure would have nothing to act against.
TEST_CASE("cavity: a wall that is none is refused", "[unit]") {
  Tissue tissue(box_scene());
  remove(tissue, cubes(2, 2));
  std::vector<Triangle> wall = find_cavities(tissue, 0)[0];
  const auto refuse = [&](const std::vector<Triangle>& bad, const std::string& what) {
    check_refused([&] { const Cavity cavity(tissue, bad); }, what);
  };
  std::vector<Triangle> open(wall.begin(), wall.end() - 1), twice = wall, none = wall, far = wall,
                                                            inner = wall, outer;
  refuse(open, "the wall is open at edge ");
  twice.push_back(wall.front());
  refuse(twice, "is in the wall twice");
  none.push_back({0, 1, 200});
  refuse(none, "triangle 0-1-200 is no face of living tissue");
  far.push_back({0, 1, 9999});
  refuse(far, "there is no vertex 9999");
  const Tet& tet = tissue.tets()[tets_where(tissue, cubes(1, 1)).front()];
  for (const auto& face : kTetTriangles) {
    inner.push_back({tet[face[0]], tet[face[1]], tet[face[2]]});
  }
  refuse(inner, "lies between two tetrahedra");
  for (const BoundaryTriangle& each : find_boundary(box_scene().tets())) {
    outer.push_back(each.vertices);
  }
  refuse(outer, "bounds no hollow");
  refuse({}, "bounds no hollow");
  Cavity cavity(tissue, wall);
  check_refused([&] { return cavity.volume({}); }, "there are 0 positions");
  const Cavity moved = std::move(cavity);
  CHECK(moved.volume(places(tissue)) == Approx(kCube).epsilon(1e-5));
  CHECK(cavity.triangles().empty());
  CHECK(cavity.volume({}) == 0);
}

}  // namespace pbdsurg
