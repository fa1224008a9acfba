// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A scene of sheets, and what can be done to them, for comparing backends.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/cuts.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::testing {

/// A sheet held at one side, with a block that hangs on it by links, and a free disc.
/// @param link_compliance  m/N; by less than some 0.01, links are stiff, which no cooperative
/// kernel
///                         takes
inline Scene make_sheet_scene(float damping = 0, float link_compliance = 1e-3F) {
  const SheetMesh sheet = make_sheet({11, 8}, kSheetEdge, 0.2);
  const SheetMesh disc = make_disc(4, 3 * kSheetEdge);
  Scene scene;
  scene.add_sheet("sheet", sheet.positions, sheet.triangles,
                  {.youngs_modulus = 50e3F, .damping = damping});
  scene.add_body("block", make_box({3, 3, 2}, kSheetEdge, 0.1),
                 {.model = ElasticModel::neo_hookean, .damping = damping});
  scene.add_sheet("disc", disc.positions, disc.triangles, {.damping = damping});
  for (Index i = 0; i < 4; ++i) {
    scene.add_link({12 + i, scene.body(1).first_vertex + i, 2e-3F, {0.5F, link_compliance}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSheetEdge; });
  return scene;
}

/// What a program does to such a scene, on two solvers alike: a tool pushes, another holds, edits
/// come and are taken back. Choices follow from the round and the state.
class SheetProgram {
 public:
  /// Before the first round.
  static void begin(Solver& solver) {
    constexpr auto kRadius = static_cast<float>(kSheetEdge);
    const Capsule capsule{{0.016F, 0, 0}, {0.034F, 0, 0}, kRadius};
    solver.add_tool({&capsule, 1}, pose(0), {ContactFeatures::vertices});
    solver.grasp(solver.add_tool({}, ToolPose::Identity()), std::array<Index, 2>{34, 58}, 1e-3F);
  }

  /// Before each step; round 8 and every eighth after it steps once itself.
  static void act(Solver& solver, Index round) {
    solver.move_tool(ToolId{0}, pose(round));
    const Index guest = static_cast<Index>(solver.tissue().bodies().size()) - 1;
    switch (round % 8) {
      case 0:
        if (round > 0) {
          solver.tissue().apply(rip_some(solver, round));
          solver.step(kStep);
          solver.tissue().undo();
        }
        break;
      case 1:
        solver.tissue().apply(
            {.remove_triangles = some_triangles(solver, round),
             .triangle_stiffnesses = {{some_triangles(solver, round + 1)[0],
                                       0.5F * static_cast<float>(round % 7 + 1)}}});
        break;
      case 2:
      case 5:
        solver.tissue().apply(rip_some(solver, round));
        break;
      case 3:
        solver.tissue().undo();
        break;
      case 4: {
        const Index shrunk = some_triangles(solver, round + 2)[1];
        solver.tissue().apply({.remove_tets = {some_tet(solver, round)},
                               .remove_triangles = some_triangles(solver, round),
                               .rest_areas = {{shrunk, 0.8F * solver.rest_area(shrunk)}}});
        break;
      }
      case 6:
        solver.tissue().apply({.new_bodies = make_guest(round)});
        break;
      default:
        if (round % 16 == 7) {
          solver.tissue().apply({.remove_bodies = {guest}});
        } else {
          solver.tissue().undo();
        }
        break;
    }
  }

  static constexpr float kStep = 2e-3F;  // s

 private:
  static ToolPose pose(Index round) {
    ToolPose at = ToolPose::Identity();
    at.translation() = Eigen::Vector3f(0, 0.014F, -0.006F + 4e-4F * static_cast<float>(round % 20));
    return at;
  }

  static std::vector<Index> some_triangles(const Solver& solver, Index round) {
    const auto count = static_cast<Index>(solver.tissue().triangles().size());
    std::vector<Index> found;
    for (Index i = 0; found.size() < 3; ++i) {
      if (const Index t = (29 * round + 17 * i) % count; solver.tissue().is_triangle_alive(t)) {
        found.push_back(t);
      }
    }
    return found;
  }

  static TopologyEdit rip_some(const Solver& solver, Index round) {
    constexpr Index kSheetVertices = 12 * 9;
    Index vertex = 7 * round % kSheetVertices;
    while (solver.tissue().triangles_at(vertex).size() < 2) {
      vertex = (vertex + 1) % kSheetVertices;
    }
    return rip_vertex(solver, vertex);
  }

  static Index some_tet(const Solver& solver, Index round) {
    Index tet = 13 * round % static_cast<Index>(solver.tissue().tets().size());
    while (!solver.tissue().is_tet_alive(tet)) {
      tet = (tet + 1) % static_cast<Index>(solver.tissue().tets().size());
    }
    return tet;
  }

  static Scene make_guest(Index round) {
    const SheetMesh mesh = make_disc(1, 2 * kSheetEdge);
    Scene guest;
    guest.add_sheet("guest " + std::to_string(round), mesh.positions, mesh.triangles,
                    {.damping = 1e-3F});
    return guest;
  }
};

}  // namespace pbdsurg::testing
