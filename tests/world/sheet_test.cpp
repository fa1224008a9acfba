// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <set>
#include <vector>

#include "pbdsurg/world/world.h"
#include "pbdsurg/world/world_file.h"

#include "lib/world/edit_merge.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/sheets.h"

namespace pbdsurg {
namespace {

using testing::check_refused;
using testing::kSheetDt;
using testing::kSheetThickness;
using testing::SheetMesh;

constexpr double kSheetWorldEdge = 4e-3;  // m

// A block with a hinged surface, and a sheet beside it.
struct SheetWorld {
  SheetWorld() {
    block = world.add_body("block", testing::make_box({2, 2, 1}, kSheetWorldEdge, 0.1),
                           tissues::liver());
    world.add_hinges(block, 1e-6F);
    const SheetMesh mesh = testing::make_sheet({6, 5}, kSheetWorldEdge, 0.2);
    sheet = world.add_sheet("peritoneum", mesh.positions, mesh.triangles, kSheetThickness,
                            tissues::membrane());
    world.fix(block, {0, 1, 2});
    world.fix(sheet, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSheetWorldEdge; });
  }

  // Of the vertex in the second column and row.
  [[nodiscard]] Index vertex() { return world.tissue().body(1).first_vertex + 8; }

  // Parts two triangles at that vertex.
  void rip() {
    const Tissue& tissue = world.tissue();
    const Index from = vertex();
    TopologyEdit edit{.new_vertices = {{from, from, 0}}};
    for (const Index t : tissue.triangles_at(from).first(2)) {
      edit.triangle_moves.push_back({t, from, tissue.vertex_count()});
    }
    world.edit(edit);
    REQUIRE(world.step(kSheetDt).ok());
  }

  World world{SolverOptions{.executor = executor::threads(1)}};
  BodyId block, sheet;
};

}  // namespace

// Would catch a surface that draws one side of a sheet, normals that cancel, and sides that stay
// behind when triangles go or part.
TEST_CASE("world sheet: its surface has both sides, and follows edits", "[unit]") {
  SheetWorld slab;
  const Surface& skin = slab.world.surface(slab.sheet);
  const auto sides = [&] {
    std::multiset<std::array<float, 3>> found;  // x, y and the sign of z of areas
    for (const auto& [a, b, c] : skin.triangles()) {
      if (a != b) {
        const auto x = skin.positions();
        const Eigen::Vector3f area = (x[b] - x[a]).cross(x[c] - x[a]);
        const Eigen::Vector3f center = (x[a] + x[b] + x[c]) / 3;
        found.insert({std::round(1e5F * center.x()), std::round(1e5F * center.y()),
                      area.z() > 0 ? 1.0F : -1.0F});
      }
    }
    return found;
  };
  CHECK(sides().size() == 2 * 60);
  for (const auto& side : sides()) {
    CHECK(sides().count({side[0], side[1], -side[2]}) == 1);
  }
  for (const Eigen::Vector3f& normal : skin.normals()) {
    CHECK((normal - Eigen::Vector3f::UnitZ()).norm() < 1e-5F);
  }
  const std::uint64_t before = skin.version();
  slab.world.edit({.remove_triangles = {0, 1, 2}});
  REQUIRE(slab.world.step(kSheetDt).ok());
  CHECK(sides().size() == 2 * 57);
  CHECK(skin.version() > before);
  slab.rip();
  CHECK(sides().size() == 2 * 57);
  CHECK(std::ranges::count(skin.vertices(), slab.world.tissue().vertex_count() - 1) == 1);
}

// Would catch a file that forgets triangles, thickness, their edits, or the order of hinges, on
// which colours and so bits depend.
TEST_CASE("world sheet: a file goes on as the world that was saved, to the bit", "[property]") {
  SheetWorld slab;
  slab.world.record();
  slab.world.step(kSheetDt);
  slab.rip();
  slab.world.edit({.remove_triangles = {10, 11}});
  const SheetMesh disc = testing::make_disc(2, 2 * kSheetWorldEdge);
  slab.world.add_sheet("disc", disc.positions, disc.triangles, kSheetThickness,
                       tissues::membrane());
  for (int i = 0; i < 3; ++i) {
    REQUIRE(slab.world.step(kSheetDt).ok());
  }
  const testing::TemporaryFolder folder;
  write_world(folder / "a.world", slab.world.save());
  World other = read_world(folder / "a.world", executor::threads(1));
  CHECK(std::ranges::equal(other.tissue().triangles(), slab.world.tissue().triangles()));
  CHECK(other.tissue().body(1).thickness == kSheetThickness);
  CHECK(other.tissue().body(2).triangle_count == 24);
  REQUIRE(other.tissue().hinges().size() == slab.world.tissue().hinges().size());
  for (std::size_t h = 0; h < other.tissue().hinges().size(); ++h) {
    REQUIRE(other.tissue().hinges()[h].vertices == slab.world.tissue().hinges()[h].vertices);
  }
  for (int i = 0; i < 5; ++i) {
    REQUIRE(other.solver().state_hash() == slab.world.solver().state_hash());
    slab.world.step(kSheetDt);
    other.step(kSheetDt);
  }
}

// Would catch a world that gives factors to others, and a file that forgets them, rest areas, or
// edits of these.
TEST_CASE("world sheet: has stiffness and rest area of triangles, and so has its file",
          "[property]") {
  SheetWorld slab;
  slab.world.set_stiffnesses(slab.sheet, [](const Eigen::Vector3d& x) {
    return x.x() > 3 * kSheetWorldEdge ? 4.0F : 1.0F;
  });
  slab.world.record();
  slab.world.step(kSheetDt);
  const float area = 0.8F * slab.world.solver().rest_area(11);
  slab.world.edit({.rest_areas = {{11, area}}, .triangle_stiffnesses = {{7, 2}}});
  slab.world.edit({.remove_triangles = {3}, .triangle_stiffnesses = {{59, 0.5F}}});
  REQUIRE(slab.world.step(kSheetDt).ok());
  const testing::TemporaryFolder folder;
  write_world(folder / "a.world", slab.world.save());
  World read = read_world(folder / "a.world", executor::threads(1)), saved(slab.world.save());
  for (World* const each : {&slab.world, &read, &saved}) {
    const Tissue& tissue = each->tissue();
    CHECK(tissue.triangle_stiffness(7) == 2);
    CHECK(each->solver().rest_area(11) == testing::Approx(area));
    CHECK(tissue.triangle_stiffness(59) == 0.5F);
    for (const Index t : {0, 5, 6, 11, 29, 30}) {
      double x = 0;
      for (const Index v : tissue.triangles()[static_cast<std::size_t>(t)]) {
        x += tissue.rest_positions()[static_cast<std::size_t>(v)].x() / 3;
      }
      CHECK(tissue.triangle_stiffness(t) == (x > 3 * kSheetWorldEdge ? 4 : 1));
    }
  }
  for (int i = 0; i < 5; ++i) {
    REQUIRE(read.solver().state_hash() == slab.world.solver().state_hash());
    REQUIRE(saved.solver().state_hash() == slab.world.solver().state_hash());
    slab.world.step(kSheetDt);
    read.step(kSheetDt);
    saved.step(kSheetDt);
  }
}

// Would catch a part that takes sheets and does nothing for them.
TEST_CASE("world sheet: who has nothing to do with sheets says so", "[unit]") {
  SheetWorld slab;
  const SheetMesh mesh = testing::make_sheet({1, 1}, kSheetWorldEdge);
  check_refused(
      [&] {
        slab.world.add_sheet("tube", mesh.positions, mesh.triangles, kSheetThickness,
                             {"springs", {.model = ElasticModel::springs}, {}, {}});
      },
      "a sheet is made of a Neo-Hookean material's moduli");
  CHECK(slab.world.step(kSheetDt).ok());
}

// Would catch triangles and copies that are named by old numbers, or twice, once edits are merged
// or come after others.
TEST_CASE("world sheet: edits of several sources become one", "[unit]") {
  constexpr Index kVertices = 10;
  TopologyEdit edit{.remove_triangles = {4, 2},
                    .rest_areas = {{0, 1e-6F}},
                    .triangle_stiffnesses = {{1, 2}},
                    .new_vertices = {{1, 1}},
                    .triangle_moves = {{3, 1, kVertices}}};
  REQUIRE(merge(edit,
                {.remove_triangles = {2, 7},
                 .rest_areas = {{9, 2e-6F}},
                 .triangle_stiffnesses = {{8, 3}},
                 .new_vertices = {{5, 5}},
                 .triangle_moves = {{6, 5, kVertices}}},
                kVertices));
  REQUIRE(edit.triangle_stiffnesses.size() == 2);
  CHECK(edit.triangle_stiffnesses[1].triangle == 8);
  CHECK_FALSE(is_empty({.triangle_stiffnesses = {{0, 2}}}));
  REQUIRE(edit.rest_areas.size() == 2);
  CHECK(edit.rest_areas[1].triangle == 9);
  CHECK_FALSE(is_empty({.rest_areas = {{0, 1e-6F}}}));
  CHECK(edit.remove_triangles == std::vector<Index>{4, 2, 7});
  REQUIRE(edit.triangle_moves.size() == 2);
  CHECK(edit.triangle_moves[1].to == kVertices + 1);
  CHECK_FALSE(is_empty({.remove_triangles = {0}}));
  CHECK_FALSE(is_empty({.triangle_moves = {{0, 0, 0}}}));

  Scene scene;
  const SheetMesh mesh = testing::make_sheet({2, 2}, kSheetWorldEdge);
  scene.add_sheet("sheet", mesh.positions, mesh.triangles);
  Tissue tissue(scene);
  EarlierEdits earlier(tissue);
  TopologyEdit later{.remove_triangles = {0, 3},
                     .rest_areas = {{5, 1e-6F}, {9, 1e-6F}},
                     .triangle_stiffnesses = {{4, 2}, {8, 2}}};
  TopologyEdit first{.remove_triangles = {0}};
  first.new_bodies.add_sheet("guest", mesh.positions, mesh.triangles);
  earlier.note(tissue.apply(first));
  earlier.adapt(later, tissue);
  CHECK(later.remove_triangles == std::vector<Index>{3});
  CHECK(later.rest_areas[0].triangle == 5);
  CHECK(later.rest_areas[1].triangle == 17);
  CHECK(later.triangle_stiffnesses[0].triangle == 4);
  CHECK(later.triangle_stiffnesses[1].triangle == 16);  // that does not exist, as before
}

}  // namespace pbdsurg
