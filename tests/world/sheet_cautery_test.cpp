// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <vector>

#include "pbdsurg/world/world.h"
#include "pbdsurg/world/world_file.h"

#include "tests/support/catch.h"
#include "tests/support/cautery_block.h"
#include "tests/support/check_refused.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/temporary_folder.h"
#include "tests/world/sheets.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::check_ledger;
using testing::kSheetDt;
using testing::kSheetThickness;
using testing::SheetMesh;

constexpr double kBurntEdge = 1e-3;  // m
constexpr Index kBurntCells = 16;

// A sheet without weight that is held at its rim, and a hook that points at its middle.
struct BurntSheet {
  // @param height  m, of the hook over the sheet
  explicit BurntSheet(float height = 0.3e-3F, double edge = kBurntEdge)
      : world({.damping = 20, .executor = executor::threads(1)}) {
    const SheetMesh mesh = testing::make_sheet({kBurntCells, kBurntCells}, edge, 0.1);
    sheet = world.add_sheet("peritoneum", mesh.positions, mesh.triangles, kSheetThickness,
                            tissues::membrane());
    const double side = kBurntCells * edge;
    world.fix(sheet, [&](const Eigen::Vector3d& x) {
      return x.x() < 0.1 * edge || x.y() < 0.1 * edge || x.x() > side - 0.1 * edge ||
             x.y() > side - 0.1 * edge;
    });
    world.set_gravity({0, 0, 0});
    const auto middle = static_cast<float>(side / 2);
    hook = world.add_tool({}, ToolPose(Eigen::Translation3f(middle, middle, height)));
    burner = world.add_cautery(hook, {sheet});
  }

  // @return  triangles that went
  Index burn(int steps, double power = 20) {
    world.energise(burner, power > 0 ? cut_settings(power) : off_settings());
    Index removed = 0;
    for (int i = 0; i < steps; ++i) {
      const Frame frame = world.step(kSheetDt);
      REQUIRE(frame.ok());
      removed += frame.removed_triangles;
      check_ledger(world.cautery(burner));
    }
    return removed;
  }

  [[nodiscard]] std::vector<Index> dead() {
    std::vector<Index> found;
    for (Index t = 0; t < static_cast<Index>(world.tissue().triangles().size()); ++t) {
      if (!world.tissue().is_triangle_alive(t)) {
        found.push_back(t);
      }
    }
    return found;
  }

  World world;
  BodyId sheet;
  ToolId hook;
  CauteryId burner;
};

}  // namespace

// Would catch an electrode that touches one side of a sheet alone, heat that arrives nowhere near
// it, and triangles that dry and stay.
TEST_CASE("sheet cautery: a hook burns a hole from either side", "[long]") {
  const float side = GENERATE(1.0F, -1.0F);
  BurntSheet burnt(side * 0.3e-3F);
  const Index removed = burnt.burn(100);
  const std::vector<Index> dead = burnt.dead();
  CHECK(removed == static_cast<Index>(dead.size()));
  CHECK(removed > 4);
  const Eigen::Vector3d middle(kBurntCells * kBurntEdge / 2, kBurntCells * kBurntEdge / 2, 0);
  for (const Index t : dead) {
    for (const Index v : burnt.world.tissue().triangles()[static_cast<std::size_t>(t)]) {
      CHECK((burnt.world.tissue().rest_positions()[static_cast<std::size_t>(v)] - middle).norm() <
            5e-3);
    }
    CHECK(burnt.world.cautery(burnt.burner).state_of_triangle(t) == HeatState::vaporised);
  }
  // the rest has whitened around the hole, and is as it was at the rim
  const HeatField& field = burnt.world.cautery(burnt.burner).field();
  CHECK(*std::ranges::min_element(field.survival()) < 0.01);
  CHECK(field.survival()[0] > 0.99);
  CHECK(*std::ranges::max_element(field.peak_temperatures()) >= kBoilingTemperature);
}

// Would catch a disk's closed form on a sheet, whose half-space is not there, and coarse triangles
// that an electrode between their corners does not touch.
TEST_CASE("sheet cautery: a coarse sheet burns by its potential", "[unit]") {
  BurntSheet burnt(0.3e-3F, 6 * kBurntEdge);
  burnt.world.energise(burnt.burner, cut_settings(20));
  const Frame frame = burnt.world.step(kSheetDt);
  REQUIRE(frame.cauteries.size() == 1);
  CHECK_FALSE(frame.cauteries[0].is_disk);
  CHECK(frame.cauteries[0].contact_vertices > 0);
  CHECK(frame.cauteries[0].energy > 0);
  check_ledger(burnt.world.cautery(burnt.burner));
}

// Would catch heat of removed triangles that an undo loses, and triangles that come back for good
// though they are dry.
TEST_CASE("sheet cautery: an undo brings triangles back, and heat takes them again", "[unit]") {
  BurntSheet burnt;
  while (burnt.burn(1) == 0) {
  }
  const std::vector<Index> dead = burnt.dead();
  burnt.world.undo();
  CHECK(burnt.dead().empty());
  check_ledger(burnt.world.cautery(burnt.burner));
  CHECK(burnt.burn(1, 0) > 0);
  for (const Index t : dead) {
    CHECK_FALSE(burnt.world.tissue().is_triangle_alive(t));
  }
}

// Would catch due triangles, temperatures or energies that a file forgets.
TEST_CASE("sheet cautery: a file goes on as the world that was saved, to the bit", "[property]") {
  BurntSheet burnt;
  burnt.world.record();
  Index removed = 0;
  while (removed == 0) {
    removed = burnt.burn(1);
  }
  burnt.burn(3);
  burnt.burn(1, 0);
  const testing::TemporaryFolder folder;
  write_world(folder / "a.world", burnt.world.save());
  World other = read_world(folder / "a.world", executor::threads(1));
  const HeatField& here = burnt.world.cautery(burnt.burner).field();
  const HeatField& there = other.cautery(burnt.burner).field();
  for (int i = 0; i < 20; ++i) {
    REQUIRE(other.solver().state_hash() == burnt.world.solver().state_hash());
    REQUIRE(std::ranges::equal(here.temperatures(), there.temperatures()));
    REQUIRE(std::ranges::equal(here.water(), there.water()));
    REQUIRE(here.ledger().removed == there.ledger().removed);
    const Frame ours = burnt.world.step(kSheetDt), theirs = other.step(kSheetDt);
    REQUIRE(ours.removed_triangles == theirs.removed_triangles);
  }
}

// Would catch elements that keep old ids.
TEST_CASE("sheet cautery: a compaction keeps heat and goes on", "[property]") {
  BurntSheet burnt, plain;
  const auto energy = [](BurntSheet& of) {
    return of.world.cautery(of.burner).field().ledger().in;
  };
  for (BurntSheet* const each : {&burnt, &plain}) {
    while (each->burn(1) == 0) {
    }
    each->burn(5);
  }
  REQUIRE(energy(burnt) == energy(plain));
  burnt.world.compact();
  CHECK(burnt.dead().empty());
  check_ledger(burnt.world.cautery(burnt.burner));
  const Index removed = burnt.burn(20), expected = plain.burn(20);
  CHECK(expected > 0);
  CHECK(removed == Approx(expected).epsilon(0.1));
  CHECK(energy(burnt) == Approx(energy(plain)).epsilon(0.02));
}

// Would catch a cautery of a snapshot that has triangles which the tissue does not.
TEST_CASE("sheet cautery: bad input is refused", "[unit]") {
  BurntSheet burnt;
  burnt.burn(1);
  Cautery& cautery = burnt.world.cautery(burnt.burner);
  CauterySnapshot snapshot = cautery.snapshot();
  snapshot.due = {{element_of_triangle(1 << 20), false}};
  testing::check_refused([&] { cautery.restore(snapshot); }, "there is no triangle 1048576");
  snapshot.due = {{element_of_triangle(1), false}, {element_of_triangle(2), false}};
  testing::check_refused([&] { cautery.restore(snapshot); }, "must ascend");
  testing::check_refused([&] { (void)cautery.state_of_triangle(2 * kBurntCells * kBurntCells); },
                         "there is no triangle 512");
  TissueRecord dry = tissues::membrane();
  dry.heat.water_fraction = 0;
  World other;
  const SheetMesh mesh = testing::make_sheet({2, 2}, kBurntEdge);
  const BodyId sheet = other.add_sheet("dry", mesh.positions, mesh.triangles, kSheetThickness, dry);
  const ToolId hook = other.add_tool({}, ToolPose::Identity());
  testing::check_refused([&] { other.add_cautery(hook, {sheet}); },
                         "the tissue of body 'dry' has no water");
}

}  // namespace pbdsurg
