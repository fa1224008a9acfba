// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/world/world.h"
#include "pbdsurg/world/world_file.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/sheets.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::kSheetDt;
using testing::kSheetThickness;
using testing::SheetMesh;

constexpr double kHungEdge = 2e-3;  // m
constexpr double kGap = 3e-3;       // m
constexpr Index kHungCells = 8;
constexpr double kSide = kHungCells * kHungEdge;  // m

// A slab that is fixed, and a sheet below it that hangs from it by strands alone.
struct HungSheet {
  // @param copies  of the world
  explicit HungSheet(bool sheet_is_first, int segments = 1, float tear_stretch = 2,
                     Index copies = 1)
      : world({.damping = 5, .copies = copies, .executor = executor::threads(1)}) {
    const TetMesh box = testing::make_box({kHungCells, kHungCells, 1}, kHungEdge);
    std::vector<Eigen::Vector3d> points(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& x : points) {
      x.z() += kGap;
    }
    slab = world.add_body("slab", TetMesh(points, {box.tets().begin(), box.tets().end()}),
                          tissues::liver());
    world.fix(slab, [](const Eigen::Vector3d&) { return true; });
    const SheetMesh mesh = testing::make_sheet({kHungCells, kHungCells}, kHungEdge);
    sheet = world.add_sheet("peritoneum", mesh.positions, mesh.triangles, kSheetThickness,
                            tissues::membrane());
    world.set_gravity({0, 0, -9.81F});
    strand_count = world.join(
        sheet_is_first ? sheet : slab, sheet_is_first ? slab : sheet,
        {.max_distance = 2 * kGap,
         .density = 1e6,
         .strands = {.segments = segments, .stiffness = 1e-3, .tear_stretch = tear_stretch}});
  }

  // N along z, of all strands on the sheet.
  [[nodiscard]] double pull() {
    const std::vector<Eigen::Vector3f> x = world.replica(ReplicaId(0)).positions();
    const Tissue& tissue = world.tissue();
    double sum = 0;
    for (const Strand& strand : world.strands().strands()) {
      const Link& link = tissue.links()[static_cast<std::size_t>(strand.first_link)];
      const bool is_first = tissue.body_of_vertex(link.first) == 1;
      const Eigen::Vector3d from = x[is_first ? link.first : link.second].cast<double>();
      const Eigen::Vector3d way = x[is_first ? link.second : link.first].cast<double>() - from;
      sum += (way.norm() - link.rest_length) / link.stiffness.compliance * way.z() / way.norm();
    }
    return sum;
  }

  // kg
  [[nodiscard]] double mass() {
    double sum = 0;
    for (const Index v : world.tissue().vertices_of(1)) {
      sum += world.tissue().masses()[static_cast<std::size_t>(v)];
    }
    return sum;
  }

  World world;
  BodyId slab, sheet;
  Index strand_count = 0;
};

}  // namespace

// Would catch strands that end at no vertex of the sheet, forces that do not reach it, and a
// stiffness other than that of the fibres.
TEST_CASE("sheet strands: together they bear the weight of a sheet", "[long]") {
  HungSheet hung(GENERATE(true, false));
  for (int i = 0; i < 400; ++i) {
    REQUIRE(hung.world.step(kSheetDt).ok());
  }
  CHECK(hung.world.strands().whole_count() == hung.strand_count);
  CHECK(hung.mass() ==
        Approx(tissues::membrane().mechanics.density * kSheetThickness * kSide * kSide));
  CHECK(hung.pull() == Approx(9.81 * hung.mass()).epsilon(0.01));
}

// Would catch fibres scattered once for each side of a sheet, or on one of its sides alone.
TEST_CASE("sheet strands: a sheet has as many fibres on each side as a solid", "[property]") {
  const bool is_above = GENERATE(true, false);  // the block
  constexpr double kDensity = 3e6;              // 1/m^2
  const SheetMesh mesh = testing::make_sheet({kHungCells, kHungCells}, kHungEdge);
  std::vector<Eigen::Vector3d> points = mesh.positions;
  for (Eigen::Vector3d& x : points) {
    x.z() = is_above ? kHungEdge + kGap : -kGap;
  }
  std::vector<Triangle> triangles = mesh.triangles;
  for (std::size_t t = 0; t < triangles.size(); t += 2) {
    std::swap(triangles[t][0], triangles[t][1]);  // whichever way they are wound
  }
  Scene scene;
  scene.add_body("block", testing::make_box({kHungCells, kHungCells, 1}, kHungEdge));
  scene.add_sheet("sheet", points, triangles, {});
  scene.add_sheet("other", mesh.positions, mesh.triangles, {});
  const LinkedSurface block(scene, 0), sheet(scene, 1);
  CHECK(sheet.triangles.size() == triangles.size());
  const auto count = [](const std::vector<MembraneLink>& links) {
    Index fibres = 0;
    for (const MembraneLink& link : links) {
      fibres += link.fibres;
    }
    return fibres;
  };
  const ScatterOptions options{.max_distance = 2 * kGap, .density = kDensity};
  CHECK(count(scattered_links(sheet, block, options)) ==
        Approx(kDensity * kSide * kSide).epsilon(0.02));
  CHECK(count(scattered_links(block, sheet, options)) ==
        Approx(kDensity * kSide * kSide).epsilon(0.02));
  CHECK(count(scattered_links(sheet, LinkedSurface(scene, 2),
                              {.max_distance = 3 * kGap, .density = kDensity})) ==
        Approx(kDensity * kSide * kSide).epsilon(0.02));
}

// Would catch strands that outlive the tissue they hang on, or do not come back with it.
TEST_CASE("sheet strands: they go with the sheet's triangles, and an undo brings them back",
          "[unit]") {
  HungSheet hung(true, GENERATE(1, 3));
  hung.world.step(kSheetDt);
  const Tissue& tissue = hung.world.tissue();
  const Index corner = tissue.body(1).first_vertex + 4 * (kHungCells + 1) + 4;
  const auto around = tissue.triangles_at(corner);
  Index at_corner = 0;
  for (const Strand& strand : hung.world.strands().strands()) {
    at_corner += tissue.links()[static_cast<std::size_t>(strand.first_link)].first == corner;
  }
  REQUIRE(at_corner > 0);
  hung.world.edit({.remove_triangles = {around.begin(), around.end()}});
  REQUIRE(hung.world.step(kSheetDt).ok());
  CHECK(hung.world.strands().whole_count() == hung.strand_count - at_corner);
  CHECK(std::ranges::all_of(hung.world.strands().events(), [](const StrandEvent& event) {
    return event.cause == StrandLoss::without_tissue;
  }));
  hung.world.undo();
  CHECK(hung.world.strands().whole_count() == hung.strand_count);
  hung.world.edit({.remove_triangles = {around.begin(), around.end()}});
  REQUIRE(hung.world.step(kSheetDt).ok());
  hung.world.compact();
  CHECK(hung.world.strands().whole_count() == hung.strand_count - at_corner);
  for (Index s = 0; s < hung.strand_count; ++s) {
    if (hung.world.strands().is_whole(s)) {
      const Index first = hung.world.strands().strands()[static_cast<std::size_t>(s)].first_link;
      REQUIRE(tissue.body_of_vertex(tissue.links()[static_cast<std::size_t>(first)].first) == 1);
    }
  }
}

// Would catch strands of sheets that never tear, in one replica or in all.
TEST_CASE("sheet strands: they tear where the sheet is pulled off", "[unit]") {
  HungSheet hung(true, 1, 1.2F, 2);
  const Tissue& tissue = hung.world.tissue();
  const std::vector<Index> vertices = tissue.vertices_of(1);
  hung.world.replica(ReplicaId(1))
      .set_forces(vertices, std::vector<Eigen::Vector3f>(vertices.size(), {0, 0, -0.05F}));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(hung.world.step(kSheetDt).ok());
  }
  CHECK(hung.world.strands().whole_count() == hung.strand_count);  // the first replica is looked at
  hung.world.set_forces(vertices, std::vector<Eigen::Vector3f>(vertices.size(), {0, 0, -0.05F}));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(hung.world.step(kSheetDt).ok());
  }
  CHECK(hung.world.strands().share_lost(StrandLoss::torn) == 1);
}

// Would catch strands that a file forgets.
TEST_CASE("sheet strands: a file goes on as the world that was saved, to the bit", "[property]") {
  HungSheet hung(false, 2);
  hung.world.record();
  hung.world.step(kSheetDt);
  hung.world.edit({.remove_triangles = {10, 11, 12, 13}});
  hung.world.step(kSheetDt);
  const testing::TemporaryFolder folder;
  write_world(folder / "a.world", hung.world.save());
  World other = read_world(folder / "a.world", executor::threads(1));
  CHECK(other.strands().whole_count() == hung.world.strands().whole_count());
  for (int i = 0; i < 5; ++i) {
    REQUIRE(other.solver().state_hash() == hung.world.solver().state_hash());
    hung.world.step(kSheetDt);
    other.step(kSheetDt);
  }
}

}  // namespace pbdsurg
