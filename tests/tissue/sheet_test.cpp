// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/tissue/compact.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_refused;
using testing::kSoftEdge;
using testing::SheetMesh;

constexpr SheetMaterial kMaterial{.thickness = 5e-4F, .density = 1100, .youngs_modulus = 1e6F};

// A block, a sheet of 3 by 2 squares, another of one.
Scene make_block_and_sheets() {
  const SheetMesh wide = testing::make_sheet({3, 2}, kSoftEdge),
                  small = testing::make_sheet({1, 1}, kSoftEdge);
  Scene scene;
  scene.add_body("block", testing::make_box({1, 1, 1}, kSoftEdge));
  scene.add_sheet("wide", wide.positions, wide.triangles, kMaterial);
  scene.add_sheet("small", small.positions, small.triangles, kMaterial);
  return scene;
}

}  // namespace

// Would catch mass by another thickness or density, triangles in another numbering than that of the
// scene, and edges of two triangles without a hinge, or with another rigidity than a plate's.
TEST_CASE("sheet: has the mass of its area, and hinges as a plate", "[unit]") {
  const Scene scene = make_block_and_sheets();
  const Body& sheet = scene.body(1);
  CHECK(sheet.tet_count == 0);
  CHECK(sheet.triangle_count == 12);
  CHECK(scene.body(2).first_triangle == 12);
  CHECK(scene.triangles().size() == 14);
  CHECK(scene.triangles()[12][0] == scene.body(2).first_vertex);
  const auto masses = scene.masses().subspan(static_cast<std::size_t>(sheet.first_vertex), 12);
  const double area = 6 * kSoftEdge * kSoftEdge, density = 1100 * 5e-4;
  CHECK(std::accumulate(masses.begin(), masses.end(), 0.0) == Approx(density * area));
  // of two triangles around the corner, half a square each
  CHECK(masses[0] == Approx(density * kSoftEdge * kSoftEdge / 3));
  CHECK(scene.hinges().size() ==
        6 + 3 + 4 + 1);  // diagonals, edges along y and x; of the small one
  CHECK(scene.hinges()[0].rigidity == Approx(1e6 * std::pow(5e-4, 3) / (12 * (1 - 0.45 * 0.45))));
}

// Would catch a bad sheet that is taken, in part or whole.
TEST_CASE("sheet: bad ones are refused by name and change nothing", "[unit]") {
  Scene scene = make_block_and_sheets();
  const std::size_t bodies = scene.bodies().size(), hinges = scene.hinges().size();
  const SheetMesh mesh = testing::make_sheet({1, 1}, kSoftEdge);
  const auto add = [&](const char* name, const SheetMesh& of, const SheetMaterial& material) {
    return [&scene, name, &of, material] {
      scene.add_sheet(name, of.positions, of.triangles, material);
    };
  };
  check_refused(add("", mesh, {}), "needs a name");
  check_refused(add("wide", mesh, {}), "there is a body named 'wide'");
  check_refused(add("s", mesh, {.thickness = 0}),
                "body 's': thickness is 0 m; it must be positive");
  check_refused(add("s", mesh, {.density = -1}), "body 's': density is -1 kg/m^3");
  check_refused(add("s", mesh, {.youngs_modulus = std::numeric_limits<float>::infinity()}),
                "youngs_modulus is inf");
  check_refused(add("s", mesh, {.poissons_ratio = 0.5F}), "poissons_ratio is 0.5");
  check_refused(add("s", mesh, {.damping = -1}), "damping is -1");
  check_refused(add("s", mesh, {.thickness = 1e-9F}), "it must be in [1e-12, 1e12]");
  SheetMesh bad = mesh;
  bad.positions[2].y() = std::numeric_limits<double>::quiet_NaN();
  check_refused(add("s", bad, {}), "the position of vertex 2");
  bad = mesh;
  bad.triangles[1][2] = 4;
  check_refused(add("s", bad, {}), "triangle 1 refers to vertex 4; ids must be in [0, 4)");
  bad.triangles[1] = {0, 2, 0};
  check_refused(add("s", bad, {}), "triangle 1 has vertex 0 twice");
  bad.triangles[1] = {3, 0, 1};
  check_refused(add("s", bad, {}), "triangles 0 and 1 have the same vertices");
  bad = mesh;
  bad.positions[1] = 0.5 * (bad.positions[0] + bad.positions[3]);
  check_refused(add("s", bad, {}), "triangle 0 has 0 m^2");
  CHECK(scene.bodies().size() == bodies);
  CHECK(scene.hinges().size() == hinges);
  CHECK(scene.triangles().size() == 14);
}

// Would catch a second hinge between two triangles, and one whose triangle the sheet has not.
TEST_CASE("sheet: further hinges follow the rules of hinges", "[unit]") {
  Scene scene = make_block_and_sheets();
  check_refused([&] { scene.add_hinges(1, 1e-6F); }, "have a hinge already");
  const Index first = scene.body(1).first_vertex;
  check_refused(
      [&] {
        scene.add_hinge({{first, first + 1, first + 4, first + 9}, 1e-6F});
      },
      "belongs to 0 tetrahedra of body 'wide'");
}

// Would catch mass, hinges, links or vertices that stay behind when triangles go, and an undo that
// leaves any of it out.
TEST_CASE("sheet: removed triangles take mass, hinges and links along", "[unit]") {
  Scene scene = make_block_and_sheets();
  const Index corner = scene.body(1).first_vertex;  // of two triangles
  scene.add_link({0, corner, 1e-3F, {}});
  Tissue tissue(scene);
  const std::vector<Index> around(tissue.triangles_at(corner).begin(),
                                  tissue.triangles_at(corner).end());
  REQUIRE(around == std::vector<Index>{0, 1});
  const TissueChange& change = tissue.apply({.remove_triangles = around});
  CHECK(change.removed_triangles == around);
  CHECK(change.emptied_vertices == std::vector<Index>{corner});
  CHECK(change.removed_links == std::vector<Index>{0});
  CHECK(change.removed_hinges.size() == 3);  // the diagonal, and both sides of the square
  CHECK_FALSE(tissue.has_tissue(corner));
  CHECK_FALSE(tissue.is_triangle_alive(0));
  CHECK(tissue.masses()[corner + 1] ==
        Approx(scene.masses()[corner + 1] - tissue.triangle_mass(0) / 3));
  check_refused([&] { tissue.apply({.remove_triangles = {0}}); }, "triangle 0 was removed before");
  tissue.undo();
  CHECK(tissue.has_tissue(corner));
  CHECK(std::ranges::equal(tissue.masses(), scene.masses()));
  CHECK(std::ranges::equal(tissue.triangles_at(corner), around));
  CHECK(tissue.hinges_at(corner).size() == 3);
  CHECK(tissue.is_link_alive(0));
}

// Would catch a rip that leaves both sides joined, or parts what keeps a common edge.
TEST_CASE("sheet: rips along edges, and hinges across the rip go", "[unit]") {
  const Scene scene = make_block_and_sheets();
  Tissue tissue(scene);
  const Index first = scene.body(1).first_vertex;
  // from the lower rim up the edge between the first and the second column of squares
  const Index low = first + 1, up = first + 5;
  const Index copy_of_low = tissue.vertex_count();
  TopologyEdit edit;
  edit.new_vertices = {{low, low, 0}};
  for (const Index t : tissue.triangles_at(low)) {
    const auto is_right = [&](Index v) { return scene.positions()[v].x() > 1.5 * kSoftEdge; };
    if (std::ranges::any_of(scene.triangles()[t], is_right)) {
      edit.triangle_moves.push_back({t, low, copy_of_low});
    }
  }
  REQUIRE(!edit.triangle_moves.empty());
  const double before = tissue.masses()[low];
  const TissueChange& change = tissue.apply(edit);
  CHECK(change.removed_hinges.size() == 1);  // at the edge that was ripped
  CHECK(tissue.masses()[low] + tissue.masses()[copy_of_low] == Approx(before));
  CHECK(tissue.body_of_vertex(copy_of_low) == 1);
  for (const Index t : tissue.triangles_at(copy_of_low)) {
    CHECK(std::ranges::count(tissue.triangles()[t], low) == 0);
  }
  for (Index h = 0; h < static_cast<Index>(tissue.hinges().size()); ++h) {
    const auto& v = tissue.hinges()[h].vertices;
    const bool is_ripped = (v[0] == low && v[1] == up) || (v[0] == up && v[1] == low);
    CHECK(tissue.is_hinge_alive(h) != is_ripped);
  }
  tissue.undo();
  CHECK(std::ranges::equal(tissue.triangles(), scene.triangles()));
  CHECK(std::ranges::equal(tissue.masses(), scene.masses()));
}

// Would catch moves that tear what they must not: ids, corners and copies that are not good.
TEST_CASE("sheet: bad moves are refused", "[unit]") {
  const Scene scene = make_block_and_sheets();
  Tissue tissue(scene);
  const Index first = scene.body(1).first_vertex, copy = tissue.vertex_count();
  const Triangle& triangle = tissue.triangles()[0];
  const auto move = [&](TriangleMove asked) {
    return [&tissue, first, asked] {
      tissue.apply({.new_vertices = {{first, first, 0}}, .triangle_moves = {asked}});
    };
  };
  check_refused(move({14, first, copy}), "triangle 14 does not exist");
  check_refused(move({5, first, copy}), "triangle 5 has no corner at vertex");
  check_refused(move({0, triangle[1], copy}), "no new copy of it");
  check_refused(
      [&] {
        tissue.apply({.new_vertices = {{first, first, 0}}});
      },
      "would have no tetrahedron or triangle");
  check_refused(
      [&] {
        tissue.apply({.remove_triangles = {0},
                      .new_vertices = {{first, first, 0}},
                      .triangle_moves = {{0, first, copy}}});
      },
      "triangle 0 is moved and removed by one edit");
  check_refused([&] { tissue.apply({.remove_triangles = {0}, .remove_bodies = {BodyId(1)}}); },
                "triangle 0 is of body 'wide', which the same edit removes");
}

// Would catch triangles that a compaction drops, or leaves with old numbers.
TEST_CASE("sheet: compaction keeps what lives", "[unit]") {
  const Scene scene = make_block_and_sheets();
  Tissue tissue(scene);
  tissue.apply({.remove_triangles = {0, 1}});
  Renumbering ids;
  const auto compacted = compact(testing::inspect(tissue), ids);
  CHECK(compacted->triangles.size() == 12);
  CHECK(ids.triangles[0] == kInvalidIndex);
  CHECK(ids.triangles[2] == 0);
  CHECK(compacted->bodies[1].triangle_count == 10);
  CHECK(compacted->bodies[2].first_triangle == 10);
  CHECK(compacted->bodies[1].thickness == kMaterial.thickness);
  for (Index t = 2; t < 14; ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      CHECK(compacted->triangles[ids.triangles[t]][k] == ids.vertices[tissue.triangles()[t][k]]);
    }
  }
}

// Would catch a sheet that comes with an edit and has other mass, hinges or numbers than in a
// scene.
TEST_CASE("sheet: comes and goes with edits", "[unit]") {
  Scene first;
  first.add_body("block", testing::make_box({1, 1, 1}, kSoftEdge));
  Tissue tissue(first);
  const SheetMesh mesh = testing::make_sheet({3, 2}, kSoftEdge);
  TopologyEdit edit;
  edit.new_bodies.add_sheet("wide", mesh.positions, mesh.triangles, kMaterial);
  tissue.apply(edit);
  const Scene whole = make_block_and_sheets();
  CHECK(tissue.triangles().size() == 12);
  CHECK(std::ranges::equal(tissue.triangles(), whole.triangles().first(12)));
  CHECK(tissue.hinges().size() == 13);
  CHECK(tissue.body_of_triangle(11) == 1);
  for (Index v = 0; v < tissue.vertex_count(); ++v) {
    CHECK(tissue.masses()[v] == Approx(whole.masses()[v]));
  }
  tissue.apply({.remove_bodies = {BodyId(1)}});
  CHECK_FALSE(tissue.is_body_alive(1));
  CHECK(tissue.last_change().removed_triangles.size() == 12);
  CHECK(tissue.last_change().removed_hinges.size() == 13);
  tissue.undo();
  CHECK(tissue.is_body_alive(1));
  CHECK(tissue.triangles_at(whole.body(1).first_vertex + 5).size() >= 4);
}

}  // namespace pbdsurg
