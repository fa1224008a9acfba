// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::kSoftEdge;

constexpr float kRigidity = 1e-4F;  // N m

Scene make_hinged_scene(std::array<Index, 3> cells = {2, 2, 1}) {
  Scene scene;
  scene.add_body("first", testing::make_box(cells, kSoftEdge, 0.1));
  scene.add_body("plate", testing::make_box(cells, kSoftEdge, 0.1, 2));
  scene.add_hinges(1, kRigidity);
  return scene;
}

bool has_triangle(const Tet& tet, Index a, Index b, Index c) {
  return std::ranges::count(tet, a) + std::ranges::count(tet, b) + std::ranges::count(tet, c) == 3;
}

// Hinges with a triangle of a tetrahedron that has a vertex; kInvalidIndex for any.
std::set<Index> hinges_of(const Tissue& tissue, Index tet, Index vertex) {
  std::set<Index> found;
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    const auto& v = tissue.hinges()[h].vertices;
    for (const Index opposite : {v[2], v[3]}) {
      const bool is_at =
          vertex == kInvalidIndex || v[0] == vertex || v[1] == vertex || opposite == vertex;
      if (is_at && has_triangle(tissue.tets()[tet], v[0], v[1], opposite)) {
        found.insert(h);
      }
    }
  }
  return found;
}

std::set<Index> dead_hinges(const Tissue& tissue) {
  std::set<Index> dead;
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    if (!tissue.is_hinge_alive(h)) {
      dead.insert(h);
    }
  }
  return dead;
}

}  // namespace

TEST_CASE("hinge: all of a body are at the edges of its surface, outwards", "[unit]") {
  const Scene scene = make_hinged_scene();
  const auto surface = find_boundary(scene.tets().subspan(scene.body(1).first_tet));
  REQUIRE(scene.hinges().size() == surface.size() * 3 / 2);
  std::set<Triangle> triangles;
  for (const BoundaryTriangle& triangle : surface) {
    Triangle v = triangle.vertices;
    std::rotate(v.begin(), std::ranges::min_element(v), v.end());
    triangles.insert(v);
  }
  const auto is_on_surface = [&](Triangle v) {
    std::rotate(v.begin(), std::ranges::min_element(v), v.end());
    return triangles.contains(v);
  };
  std::set<Edge> edges;
  for (const Hinge& hinge : scene.hinges()) {
    const auto& v = hinge.vertices;
    CHECK(hinge.rigidity == kRigidity);
    CHECK(is_on_surface({v[0], v[1], v[2]}));
    CHECK(is_on_surface({v[1], v[0], v[3]}));
    CHECK(edges.insert({v[0], v[1]}).second);
  }
}

TEST_CASE("hinge: bad ones are refused by name and change nothing", "[unit]") {
  Scene scene = make_hinged_scene();
  const auto count = static_cast<Index>(scene.hinges().size());
  const Hinge good = scene.hinges()[3];
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto with = [&](int place, Index vertex) {
    Hinge hinge = good;
    hinge.vertices[place] = vertex;
    return hinge;
  };
  const std::string name = "hinge " + std::to_string(count);
  CHECK_THROWS_WITH(scene.add_hinge(good), ContainsSubstring("joins the triangles of hinge 3"));
  const auto& v = good.vertices;
  CHECK_THROWS_WITH(scene.add_hinge({{v[1], v[0], v[3], v[2]}, kRigidity}),
                    ContainsSubstring(name + " joins the triangles of hinge 3"));
  CHECK_THROWS_WITH(scene.add_hinge(with(2, scene.vertex_count())),
                    ContainsSubstring(name + " refers to vertex 36; ids must be in [0, 36)"));
  CHECK_THROWS_WITH(scene.add_hinge(with(0, -1)), ContainsSubstring("vertex -1"));
  CHECK_THROWS_WITH(scene.add_hinge(with(3, v[2])), ContainsSubstring("twice"));
  CHECK_THROWS_WITH(scene.add_hinge(with(3, 0)),
                    ContainsSubstring("belongs to 0 tetrahedra of body 'plate'"));
  CHECK_THROWS_WITH(scene.add_hinges(1, kRigidity), ContainsSubstring("have a hinge already"));
  CHECK_THROWS_WITH(scene.add_hinges(0, nan), ContainsSubstring("rigidity is nan"));
  CHECK_THROWS_WITH(scene.add_hinges(0, 0), ContainsSubstring("rigidity is 0 N m"));
  CHECK_THROWS_WITH(scene.add_hinges(0, 1e-20F), ContainsSubstring("1e12"));
  CHECK_THROWS_WITH(scene.add_hinges(2, kRigidity), ContainsSubstring("no body 2"));
  const std::array<Eigen::Vector3d, 2> thread{{{0, 0, 0}, {1, 0, 0}}};
  const Index particles = scene.add_particles("thread", thread, 1e-5);
  CHECK_THROWS_WITH(scene.add_hinges(particles, kRigidity), ContainsSubstring("'thread' has no"));
  CHECK_THROWS_WITH(scene.add_hinge(with(0, scene.vertex_count() - 1)),
                    ContainsSubstring("belongs to 0 tetrahedra of body 'thread'"));

  // a triangle between two tetrahedra is not on the surface
  const Tet& tet = scene.tets()[0];
  for (const auto& corners : kTetTriangles) {
    const Index i = corners[0], j = corners[1], k = corners[2];
    const auto owners = std::ranges::count_if(
        scene.tets(), [&](const Tet& each) { return has_triangle(each, tet[i], tet[j], tet[k]); });
    if (owners == 2) {
      CHECK_THROWS_WITH(scene.add_hinge({{tet[i], tet[j], tet[k], 5}, kRigidity}),
                        ContainsSubstring("belongs to 2 tetrahedra"));
    }
  }
  CHECK(static_cast<Index>(scene.hinges().size()) == count);

  std::vector<Eigen::Vector3d> flat{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0.3, 1e-8, 1e-9}};
  scene.add_body("sliver", TetMesh(flat, {{0, 1, 2, 3}}));
  CHECK_THROWS_WITH(scene.add_hinges(3, kRigidity), ContainsSubstring("height of vertex"));
  CHECK(static_cast<Index>(scene.hinges().size()) == count);

  Scene one;
  one.add_body("box", testing::make_box({1, 1, 1}, kSoftEdge));
  CHECK(one.add_hinge({{0, 1, 3, 5}, kRigidity}) == 0);
  CHECK(one.add_hinge({{0, 2, 3, 6}, kRigidity}) == 1);
  CHECK_THROWS_WITH(one.add_hinges(0, kRigidity), ContainsSubstring("hinge already"));
  CHECK(one.hinges().size() == 2);
}

TEST_CASE("hinge: goes with a triangle of its own, and comes back with it", "[unit]") {
  const Scene scene = make_hinged_scene();
  Tissue tissue(scene);
  const Index tet = scene.body(1).first_tet + 4;
  const std::set<Index> all = hinges_of(tissue, tet, kInvalidIndex);
  REQUIRE(!all.empty());
  const std::vector<Hinge> before(tissue.hinges().begin(), tissue.hinges().end());
  const auto ends_at = [&](Index h, Index vertex) {
    return before[h].vertices[0] == vertex || before[h].vertices[1] == vertex;
  };
  const Index corner = before[*all.begin()].vertices[0];
  REQUIRE(std::ranges::count(tissue.tets()[tet], corner) == 1);

  TopologyEdit edit;
  std::set<Index> lost, moved;
  SECTION("removed") {
    edit.remove_tets = {tet};
    lost = all;
  }
  SECTION("parted") {
    edit.new_vertices = {{corner, corner}};
    edit.corner_moves = {{tet, corner, tissue.vertex_count()}};
    for (const Index h : hinges_of(tissue, tet, corner)) {
      const auto& v = before[h].vertices;
      const bool has_both = has_triangle(tissue.tets()[tet], v[0], v[1], v[2]) &&
                            has_triangle(tissue.tets()[tet], v[0], v[1], v[3]);
      (ends_at(h, corner) && !has_both ? lost : moved).insert(h);
    }
    CHECK(!lost.empty());
  }
  SECTION("split") {
    const auto [a, b, c, d] = tissue.tets()[tet];
    const Index middle = tissue.vertex_count();
    edit.new_vertices = {{a, b, 0.5F}};
    edit.new_tets = {{tet, {middle, b, c, d}}, {tet, {a, middle, c, d}}};
    for (const Index h : all) {  // what has a triangle with both ends of the edge
      const auto& v = before[h].vertices;
      for (const Index opposite : {v[2], v[3]}) {
        const auto has = [&](Index x) { return ends_at(h, x) || opposite == x; };
        if (has_triangle(tissue.tets()[tet], v[0], v[1], opposite) && has(a) && has(b)) {
          lost.insert(h);
        }
      }
    }
  }
  SECTION("with its body") {
    edit.remove_bodies = {1};
    for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
      lost.insert(h);
    }
  }
  const TissueChange& change = tissue.apply(edit);
  CHECK(std::set<Index>(change.removed_hinges.begin(), change.removed_hinges.end()) == lost);
  CHECK(change.removed_hinges.size() == lost.size());
  CHECK(dead_hinges(tissue) == lost);
  CHECK(std::set<Index>(change.moved_hinges.begin(), change.moved_hinges.end()) == moved);
  for (const Index h : moved) {
    std::array<Index, 4> expected = before[h].vertices;
    std::ranges::replace(expected, corner, change.first_new_vertex);
    CHECK(tissue.hinges()[h].vertices == expected);
  }
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    for (const Index hinge : tissue.hinges_at(v)) {
      CHECK(std::ranges::count(tissue.hinges()[hinge].vertices, v) == 1);
      CHECK(!lost.contains(hinge));
    }
  }
  tissue.undo();
  CHECK(dead_hinges(tissue).empty());
  for (Index hinge = 0; hinge < static_cast<Index>(before.size()); ++hinge) {
    CHECK(tissue.hinges()[hinge].vertices == before[hinge].vertices);
    for (const Index v : tissue.hinges()[hinge].vertices) {
      CHECK(std::ranges::count(tissue.hinges_at(v), hinge) == 1);
    }
  }
}

// Would catch a cut after which the side that got the copies bends more easily than the other.
TEST_CASE("hinge: of two sides that a cut parts, both keep theirs", "[unit]") {
  Tissue tissue(make_hinged_scene({4, 2, 1}));
  const auto x = [&](Index v) { return tissue.rest_positions()[v].x(); };
  const double middle = 2 * kSoftEdge, tolerance = 0.1 * kSoftEdge;
  const auto [first, last] =
      std::ranges::minmax(tissue.rest_positions(), {}, [](const auto& p) { return p.x(); });
  REQUIRE(first.x() + last.x() == testing::Approx(2 * middle).margin(tolerance));
  TopologyEdit edit;
  std::map<Index, Index> copies;
  const Body& body = tissue.bodies()[1];
  for (Index t = body.first_tet; t < body.first_tet + body.tet_count; ++t) {
    const Tet& tet = tissue.tets()[t];
    if (std::ranges::none_of(tet, [&](Index v) { return x(v) > middle + tolerance; })) {
      continue;
    }
    for (const Index v : tet) {
      if (std::abs(x(v) - middle) < tolerance) {
        const auto next = static_cast<Index>(tissue.vertex_count() + copies.size());
        const auto [copy, is_new] = copies.try_emplace(v, next);
        if (is_new) {
          edit.new_vertices.push_back({v, v});
        }
        edit.corner_moves.push_back({t, v, copy->second});
      }
    }
  }
  REQUIRE(!copies.empty());
  std::set<Index> across;  // a triangle on either side
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    const auto& v = tissue.hinges()[h].vertices;
    if (std::abs(x(v[0]) - middle) < tolerance && std::abs(x(v[1]) - middle) < tolerance) {
      across.insert(h);
    }
  }
  REQUIRE(!across.empty());
  tissue.apply(edit);
  CHECK(dead_hinges(tissue) == across);
}

// Would catch arrays that a scene without hinges pays for.
TEST_CASE("hinge: tissue without any has no room for them, and new bodies bring theirs", "[unit]") {
  Scene scene;
  scene.add_body("first", testing::make_box({2, 2, 1}, kSoftEdge, 0.1));
  Tissue tissue(scene);
  tissue.reserve(100, 100, 100, 100);
  const TissueData& data = testing::inspect(tissue);
  CHECK(data.vertex_hinges.memory_bytes() + data.hinges.memory_bytes() +
            data.hinge_alive.memory_bytes() ==
        0);
  TopologyEdit edit{.new_vertices = {{0, 0}}, .corner_moves = {{0, 0, tissue.vertex_count()}}};
  edit.new_bodies.add_body("guest", testing::make_box({1, 1, 1}, kSoftEdge));
  edit.new_bodies.add_hinges(0, kRigidity);
  REQUIRE(tissue.tets()[0][0] == 0);
  const Index first = tissue.vertex_count() + 1;
  for (int round = 0; round < 2; ++round) {
    CHECK(tissue.apply(edit).first_new_hinge == 0);
    REQUIRE(tissue.hinges().size() == 18);
    const Hinge& own = edit.new_bodies.hinges()[7];
    for (std::size_t k = 0; k < 4; ++k) {
      CHECK(tissue.hinges()[7].vertices[k] == own.vertices[k] + first);
      CHECK(std::ranges::count(tissue.hinges_at(own.vertices[k] + first), 7) == 1);
    }
    CHECK(tissue.is_hinge_alive(7));
    if (round == 0) {
      tissue.undo();
      CHECK(tissue.hinges().empty());
      CHECK(tissue.hinges_at(0).empty());
    }
  }
  CHECK_THROWS_WITH(tissue.is_hinge_alive(18), ContainsSubstring("no hinge 18"));
}

}  // namespace pbdsurg
