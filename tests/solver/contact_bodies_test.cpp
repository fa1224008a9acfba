// SPDX-License-Identifier: Apache-2.0
// The surfaces of bodies that meet, as edits change them.
#include "lib/solver/state/contact_bodies.h"

#include <algorithm>
#include <cstdint>
#include <random>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

constexpr float kListStep = 1e-3F;
constexpr TissueContact kNearContact{.thickness = 0.5e-3F, .friction = 0.1F};

// Two blocks, a sheet and a thread, far from each other.
Scene make_listed_bodies() {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  for (const int block : {0, 1}) {
    const TetMesh box = testing::make_box({4, 3, 3}, 5e-3);
    std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& x : positions) {
      x.x() += 0.1 * block;
    }
    scene.add_body(block == 0 ? "first" : "second",
                   TetMesh(positions, {box.tets().begin(), box.tets().end()}), {});
  }
  testing::SheetMesh sheet = testing::make_sheet({4, 4}, testing::kSheetEdge);
  for (Eigen::Vector3d& x : sheet.positions) {
    x.z() -= 0.1;
  }
  scene.add_sheet("sheet", sheet.positions, sheet.triangles, SheetMaterial{});
  const BodyId thread = scene.add_particles(
      "thread", std::vector<Eigen::Vector3d>{{0, 0.5, 0}, {0, 0.51, 0}, {0, 0.52, 0}}, 1e-3);
  const Index first = scene.body(thread).first_vertex;
  scene.add_link({first, first + 1, 0.01F, {1e-3F, 0}});
  scene.add_link({first + 1, first + 2, 0.01F, {1e-3F, 0}});
  return scene;
}

void check_as_anew(const Solver& solver) {
  const SolverData& data = testing::inspect(solver);
  ContactBodies anew;
  anew.replace({data.contact_bodies.pairs().begin(), data.contact_bodies.pairs().end()});
  anew.refresh(solver.tissue(), data.surface, data.place_of_vertex);
  const auto& kept = data.contact_bodies;
  CHECK(kept.vertex_count() == anew.vertex_count());
  CHECK(std::ranges::equal(kept.joined_places(), anew.joined_places()));
  CHECK(std::ranges::equal(kept.first_neighbors(), anew.first_neighbors()));
  CHECK(std::ranges::equal(kept.neighbors(), anew.neighbors()));
  REQUIRE(kept.bodies().size() == anew.bodies().size());
  for (std::size_t b = 0; b < kept.bodies().size(); ++b) {
    CAPTURE(b);
    const ContactBodies::Body &one = kept.bodies()[b], &other = anew.bodies()[b];
    CHECK(one.body == other.body);
    CHECK(one.is_two_sided == other.is_two_sided);
    CHECK(one.meets_itself == other.meets_itself);
    CHECK(one.first_vertex == other.first_vertex);
    CHECK(one.places == other.places);
    CHECK(one.triangles == other.triangles);
    CHECK(std::ranges::equal(one.edges, other.edges));
    CHECK(std::ranges::is_sorted(one.places));
    CHECK(std::ranges::is_sorted(one.triangles));
    CHECK(std::ranges::is_sorted(one.edges));
  }
}

std::vector<std::uint64_t> list_revisions(const Solver& solver) {
  std::vector<std::uint64_t> all;
  for (const ContactBodies::Body& body : testing::inspect(solver).contact_bodies.bodies()) {
    all.push_back(body.revision);
  }
  return all;
}

// Would catch a body that keeps its lists although its surface has changed, one whose lists are
// made again although it has not, and an undo that brings back the number of other lists.
TEST_CASE("contact bodies: after edits and undos their lists are as if they were made anew",
          "[unit]") {
  Solver solver(make_listed_bodies());
  for (const auto& [first, second] :
       {std::pair(0, 1), std::pair(1, 1), std::pair(1, 2), std::pair(2, 3)}) {
    solver.set_body_contact(first, second, kNearContact);
  }
  solver.step(kListStep);
  check_as_anew(solver);
  std::mt19937 random(5);
  for (int round = 0; round < 12; ++round) {
    CAPTURE(round);
    const std::vector<std::uint64_t> before = list_revisions(solver);
    const Index body = round % 2;  // the blocks by turns
    std::vector<Index> tets;
    for (const Index tet : solver.tissue().tets_of(body)) {
      if (solver.tissue().is_tet_alive(tet)) {
        tets.push_back(tet);
      }
    }
    std::ranges::shuffle(tets, random);
    tets.resize(3);
    solver.tissue().apply({.remove_tets = tets});
    solver.step(kListStep);
    check_as_anew(solver);
    const std::vector<std::uint64_t> after = list_revisions(solver);
    CHECK(after[body] != before[body]);
    CHECK(after[1 - body] == before[1 - body]);
    CHECK(after[2] == before[2]);
    if (round % 3 == 2) {
      solver.tissue().undo();
      solver.step(kListStep);
      check_as_anew(solver);
      CHECK(list_revisions(solver)[body] != after[body]);
    }
  }
}

}  // namespace
}  // namespace pbdsurg
