// SPDX-License-Identifier: Apache-2.0
// How stiffly tools are met at each vertex.
#include "lib/solver/methods/contact_firmness.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "lib/solver/methods/contact_multipliers.h"
#include "lib/solver/methods/feature_meeting.h"
#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg {
namespace {

constexpr float kAnyStep = 1e-3F;
constexpr Index kHeldBlock = 0, kFreeBlock = 1, kHeldSheet = 2,
                kParticles = 3;  // bodies, in their order

// After a step, of a body that is one and the same all over.
float firmness_of(Solver& solver, Index body) {
  solver.step(kAnyStep);
  const SolverData& data = testing::inspect(solver);
  std::vector<float> found;
  for (Index v = 0; v < solver.tissue().vertex_count(); ++v) {
    if (solver.tissue().has_tissue(v) && solver.tissue().body_of_vertex(v) == body) {
      found.push_back(data.contact_firmness.at(data.place_of_vertex[v]));
    }
  }
  REQUIRE(!found.empty());
  REQUIRE(std::ranges::count(found, found.front()) == std::ssize(found));
  return found.front();
}

Scene make_bodies() {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  for (const Index block : {kHeldBlock, kFreeBlock}) {
    TetMesh box = testing::make_box({3, 2, 2}, 5e-3);
    std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& x : positions) {
      x.x() += 0.1 * block;
    }
    scene.add_body(block == kHeldBlock ? "held" : "free",
                   TetMesh(positions, {box.tets().begin(), box.tets().end()}), {});
  }
  scene.fix_where(kHeldBlock, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
  testing::SheetMesh sheet = testing::make_sheet({4, 4}, testing::kSheetEdge);
  for (Eigen::Vector3d& x : sheet.positions) {
    x.z() -= 0.1;
  }
  scene.add_sheet("sheet", sheet.positions, sheet.triangles, SheetMaterial{});
  scene.fix_where(kHeldSheet, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
  scene.add_particles("particles", std::vector<Eigen::Vector3d>{{0, 0.5, 0}, {0, 0.6, 0}}, 1e-3);
  return scene;
}

}  // namespace

// Would catch a rod that throws sheets, particles or loose pieces off, or one that an edit leaves
// to feel tissue as it was: what is cut off, what comes, and an undo.
TEST_CASE("contact firmness: of tetrahedra that something holds, through edits", "[edit]") {
  const auto surface =
      GENERATE(ToolSurface{ContactFeatures::all, 0}, ToolSurface{ContactFeatures::vertices, 0.2F});
  Solver solver(make_bodies());
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 1e-3F};
  ToolPose far = ToolPose::Identity();
  far.translation() = Eigen::Vector3f(0, 1, 0);
  solver.add_tool({&ball, 1}, far, surface);
  CHECK(firmness_of(solver, kHeldBlock) == kHeldFirmness);
  CHECK(firmness_of(solver, kFreeBlock) == kPlainFirmness);
  CHECK(firmness_of(solver, kHeldSheet) == kPlainFirmness);
  CHECK(firmness_of(solver, kParticles) == kPlainFirmness);

  TopologyEdit edit;  // takes what is fixed off the rest
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    const std::array<Index, 4>& tet = solver.tissue().tets()[t];
    if (solver.tissue().body_of_tet(t) == kHeldBlock && std::ranges::any_of(tet, [&](Index v) {
          return solver.tissue().rest_positions()[v].x() < 1e-9;
        })) {
      edit.remove_tets.push_back(t);
    }
  }
  solver.tissue().apply(edit);
  CHECK(firmness_of(solver, kHeldBlock) == kPlainFirmness);
  solver.tissue().undo();
  CHECK(firmness_of(solver, kHeldBlock) == kHeldFirmness);

  edit = {};
  const auto guest = edit.new_bodies.add_body("guest", testing::make_box({2, 2, 2}, 5e-3), {});
  edit.new_bodies.fix_where(guest, [](const Eigen::Vector3d& x) { return x.x() < 1e-9; });
  solver.tissue().apply(edit);
  CHECK(firmness_of(solver, kParticles + 1) == kHeldFirmness);
}

// Would catch firm contacts of a tool that runs into tissue, which blow it up, or of a thick one.
TEST_CASE("contact firmness: falls with the tool's way and its thickness", "[unit]") {
  CHECK(firmness_of(kHeldFirmness, 1, 0) == kHeldFirmness);
  CHECK(firmness_of(kHeldFirmness, 0, 0.5F) == kHeldFirmness);
  CHECK(firmness_of(kHeldFirmness, 1, 0.75F) == (kHeldFirmness + kPlainFirmness) / 2);
  CHECK(firmness_of(kHeldFirmness, 1, 1) == kPlainFirmness);
  CHECK(firmness_of(kHeldFirmness, 1, 9) == kPlainFirmness);
  CHECK(firmness_of(kHeldFirmness, 1.5F, 0) == (kHeldFirmness + kPlainFirmness) / 2);
  CHECK(firmness_of(kHeldFirmness, 2, 0) == kPlainFirmness);
  CHECK(firmness_of(kHeldFirmness, kInfinity, 0) == kPlainFirmness);
  CHECK(firmness_of(kPlainFirmness, 1, 0.75F) == kPlainFirmness);
  const PlacedCapsule before{{0, 0, 0}, 2, {1, 0, 0}};
  const PlacedCapsule now{{0, 0, 1}, 2, {1, 4, 3}};
  CHECK(SweptCapsule{before, now}.relative_way() == 2.5F);  // of the longer end
  const std::array<Vec3<float>, 3> places{{{0, 0, 0}, {0, 4, 0}, {0, 0, 8}}};
  const auto position_of = [&](Index place) { return places[place]; };
  constexpr Vec3<float> kUp{0, 0, 1};
  CHECK(relative_thickness(now, {{0}}, kUp, position_of) == kInfinity);
  CHECK(relative_thickness(now, {{0, 1}}, kUp, position_of) == 1);
  CHECK(relative_thickness(now, {{0, 2}}, kUp, position_of) == 0.5F);
  CHECK(relative_thickness(now, {{0, 1, 2}}, kUp, position_of) == 4 / std::sqrt(80.0F));
  const PlacedCapsule plate{{0, 0, 0}, 0.5F, {8, 0, 0}, {0, 3, 0}};
  CHECK(relative_thickness(plate, {{0, 1}}, kUp, position_of) == 1);  // flat
  CHECK(thickness_of(plate, kUp) == 4);
  CHECK(thickness_of(plate, {0, 0.25F, std::sqrt(15.0F / 16)}) == 1 + 3 * 0.75F);
  CHECK(thickness_of(plate, {0, 0.5F, std::sqrt(0.75F)}) == 1);
  CHECK(thickness_of(plate, {0, 1, 0}) == 1);  // on its side
}

}  // namespace pbdsurg
