// SPDX-License-Identifier: Apache-2.0
// Ids that are out of range, for all public functions that take one or a list of them.
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/heat/disk_source.h"
#include "pbdsurg/mesh/partition.h"
#include "pbdsurg/mesh/quality.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_boundary.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "lib/base/check.h"
#include "tests/support/bad_ids.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

constexpr double kEdge = 1e-3;

struct Call {
  std::string name;
  Index count;  // of ids that are good
  std::function<void(Index)> of;
};

}  // namespace

// Would catch an accessor that reads beyond its array where others throw. Functions for inner loops
// are left out, which say so.
TEST_CASE("ids: whatever takes one refuses those out of range", "[unit]") {
  const TetMesh mesh = testing::make_box({2, 2, 2}, kEdge);
  Scene scene;
  scene.add_body("a", mesh, testing::kSprings);
  scene.add_body("b", mesh, testing::kSprings);
  ConnectiveTissue strands;
  const MembraneLink first{0, 1, kEdge};
  strands.join(scene, 0, 1, std::span(&first, 1));
  Solver solver(scene, testing::small_steps({.copies = 2}));
  const Tissue& tissue = solver.tissue();
  solver.add_tool({}, ToolPose::Identity());
  const ThermalBody body{0, tissues::fat().heat};
  HeatField field(tissue, std::span(&body, 1));
  Cautery cautery(tissue, std::span(&body, 1));
  PotentialField potential(field);
  const LivePieces pieces(tissue);
  const LiveSurface surface(tissue, 0);
  DiskSource disk;
  std::vector<VertexShare> shares;
  std::vector<Eigen::Vector3f> positions = solver.positions();
  const std::span<Eigen::Vector3f> one = std::span(positions).first(1);
  const ToolPose pose = ToolPose::Identity();
  const std::vector<Index> some{0};
  const std::vector<double> warm{50};
  std::vector<Eigen::Vector3d> points(mesh.positions().begin(), mesh.positions().end());

  const Index vertices = solver.vertex_count(), own_vertices = mesh.vertex_count();
  const auto tets = static_cast<Index>(tissue.tets().size());
  const auto edges = static_cast<Index>(tissue.edges().size());
  const std::vector<Call> calls{
      {"Scene::body", 2, [&](Index i) { (void)scene.body(i); }},
      {"Scene::is_fixed", vertices, [&](Index i) { (void)scene.is_fixed(i); }},
      {"Scene::fix_vertices, body", 2, [&](Index i) { Scene(scene).fix_vertices(i, some); }},
      {"Scene::fix_vertices, vertex", own_vertices,
       [&](Index i) { Scene(scene).fix_vertices(0, std::vector<Index>{i}); }},
      {"Scene::fix_where", 2,
       [&](Index i) { Scene(scene).fix_where(i, [](const auto&) { return true; }); }},
      {"Scene::add_link", vertices,
       [&](Index i) {
         Scene(scene).add_link({i, i == 0 ? 1 : 0, 1e-3F, {}});
       }},

      {"Solver::last_report", 2, [&](Index i) { (void)solver.last_report(i); }},
      {"Solver::positions", 2, [&](Index i) { (void)solver.positions(i); }},
      {"Solver::read_positions, copy", 2, [&](Index i) { solver.read_positions(positions, i); }},
      {"Solver::read_positions, some, copy", 2,
       [&](Index i) { solver.read_positions(some, one, i); }},
      {"Solver::read_positions, vertex", vertices,
       [&](Index i) { solver.read_positions(std::vector<Index>{i}, one); }},
      {"Solver::watch", vertices, [&](Index i) { solver.watch(std::vector<Index>{i}); }},
      {"Solver::watched_positions", 2, [&](Index i) { (void)solver.watched_positions(i); }},
      {"Solver::write_positions", 2, [&](Index i) { solver.write_positions(positions, i); }},
      {"Solver::velocities", 2, [&](Index i) { (void)solver.velocities(i); }},
      {"Solver::write_velocities", 2, [&](Index i) { solver.write_velocities(positions, i); }},
      {"Solver::snapshot", 2, [&](Index i) { (void)solver.snapshot(i); }},
      {"Solver::restore", 2, [&](Index i) { solver.restore(solver.snapshot(), i); }},
      {"Solver::state_hash", 2, [&](Index i) { (void)solver.state_hash(i); }},
      {"Solver::move_tool", 1, [&](Index i) { solver.move_tool(ToolId(i), pose); }},
      {"Solver::move_tool, copy", 2, [&](Index i) { solver.move_tool(ToolId{0}, pose, i); }},
      {"Solver::grasp", 1, [&](Index i) { solver.grasp(ToolId(i), {}); }},
      {"Solver::grasp, copy", 2, [&](Index i) { solver.grasp(ToolId{0}, {}, 0, i); }},
      {"Solver::grasp, vertex", vertices,
       [&](Index i) {
         solver.grasp(ToolId{0}, std::vector<Index>{i});
         solver.release(ToolId{0});
       }},
      {"Solver::tool_grip", 1, [&](Index i) { (void)solver.tool_grip(ToolId(i)); }},
      {"Solver::tool_grip, copy", 2, [&](Index i) { (void)solver.tool_grip(ToolId{0}, i); }},
      {"Solver::lost_grips, copy", 2, [&](Index i) { (void)solver.lost_grips(i); }},
      {"Solver::release", 1, [&](Index i) { solver.release(ToolId(i)); }},
      {"Solver::release, copy", 2, [&](Index i) { solver.release(ToolId{0}, i); }},
      {"Solver::tool_force", 1, [&](Index i) { (void)solver.tool_force(ToolId(i)); }},
      {"Solver::tool_force, copy", 2, [&](Index i) { (void)solver.tool_force(ToolId{0}, i); }},
      {"Tissue::body", 2, [&](Index i) { (void)tissue.body(i); }},
      {"Tissue::is_body_alive", 2, [&](Index i) { (void)tissue.is_body_alive(i); }},
      {"Tissue::body_of_vertex", vertices, [&](Index i) { (void)tissue.body_of_vertex(i); }},
      {"Tissue::body_of_tet", tets, [&](Index i) { (void)tissue.body_of_tet(i); }},
      {"Tissue::first_later_vertex", 2, [&](Index i) { (void)tissue.first_later_vertex(i); }},
      {"Tissue::first_later_tet", 2, [&](Index i) { (void)tissue.first_later_tet(i); }},
      {"Tissue::vertices_of", 2, [&](Index i) { (void)tissue.vertices_of(i); }},
      {"Tissue::tets_of", 2, [&](Index i) { (void)tissue.tets_of(i); }},
      {"Tissue::is_fixed", vertices, [&](Index i) { (void)tissue.is_fixed(i); }},
      {"Tissue::tets_at", vertices, [&](Index i) { (void)tissue.tets_at(i); }},
      {"Tissue::links_at", vertices, [&](Index i) { (void)tissue.links_at(i); }},
      {"Tissue::tet_mass", tets, [&](Index i) { (void)tissue.tet_mass(i); }},
      {"Tissue::tet_edges", tets, [&](Index i) { (void)tissue.tet_edges(i); }},
      {"Tissue::is_tet_alive", tets, [&](Index i) { (void)tissue.is_tet_alive(i); }},
      {"Tissue::is_edge_alive", edges, [&](Index i) { (void)tissue.is_edge_alive(i); }},
      {"Tissue::is_link_alive", 1, [&](Index i) { (void)tissue.is_link_alive(i); }},
      {"Tissue::has_tissue", vertices, [&](Index i) { (void)tissue.has_tissue(i); }},
      {"Solver::rest_length", edges, [&](Index i) { (void)solver.rest_length(i); }},
      {"Solver::rest_volume", tets, [&](Index i) { (void)solver.rest_volume(i); }},

      {"find_live_boundary", 2, [&](Index i) { (void)find_live_boundary(tissue, i); }},
      {"find_vertices_near", 2,
       [&](Index i) {
         (void)find_vertices_near(solver, i, {0, 0, 0}, 1e-3F);
       }},
      {"plan_cut", 2, [&](Index i) { (void)plan_cut(solver, {}, {}, i); }},
      {"LiveSurface", 2, [&](Index i) { (void)LiveSurface(tissue, i); }},
      {"shared_surface", 2, [&](Index i) { (void)shared_surface(tissue, i); }},
      {"LiveSurface::is_on_surface", vertices, [&](Index i) { (void)surface.is_on_surface(i); }},
      {"LivePieces::piece_of", tets, [&](Index i) { (void)pieces.piece_of(i); }},
      {"LivePieces::body", pieces.count(), [&](Index i) { (void)pieces.body(i); }},
      {"LivePieces::tet_count", pieces.count(), [&](Index i) { (void)pieces.tet_count(i); }},
      {"LivePieces::tets", pieces.count(), [&](Index i) { (void)pieces.tets(i); }},
      {"LivePieces::is_anchored", pieces.count(), [&](Index i) { (void)pieces.is_anchored(i); }},

      {"ConnectiveTissue::is_whole", 1, [&](Index i) { (void)strands.is_whole(i); }},
      {"ThermalMesh", 2,
       [&](Index i) {
         const ThermalBody conducting{i, tissues::fat().heat};
         (void)ThermalMesh(tissue, std::span(&conducting, 1));
       }},
      {"Cautery", 2,
       [&](Index i) {
         const ThermalBody burnt{i, tissues::fat().heat};
         (void)Cautery(tissue, std::span(&burnt, 1));
       }},
      {"Cautery::state", tets, [&](Index i) { (void)cautery.state(i); }},
      {"HeatField::step, vertex", vertices,
       [&](Index i) {
         const HeatSource source{i, 1e-3};
         field.step(1e-3, std::span(&source, 1));
       }},
      {"HeatField::step, tet", tets,
       [&](Index i) {
         const TetHeatSource source{i, 1e-3};
         field.step(1e-3, {}, std::span(&source, 1));
       }},
      {"HeatField::set_temperatures", own_vertices,
       [&](Index i) { field.set_temperatures(std::vector<Index>{i}, warm); }},
      {"HeatField::hold", vertices, [&](Index i) { field.hold(std::vector<Index>{i}); }},
      {"HeatField::capacity", vertices, [&](Index i) { (void)field.capacity(i); }},
      {"HeatField::has_boiled", vertices, [&](Index i) { (void)field.has_boiled(i); }},
      {"HeatField::boiled_vertices", tets, [&](Index i) { (void)field.boiled_vertices(i); }},
      {"PotentialField::set_patch", vertices,
       [&](Index i) {
         const PatchVertex touched{i, 1};
         potential.set_patch(std::span(&touched, 1), 1e-6);
       }},
      {"PotentialField::set_ground", vertices,
       [&](Index i) { potential.set_ground(std::vector<Index>{i}); }},
      {"DiskSource::distribute", tets,
       [&](Index i) {
         disk.distribute({{0, 0, 0}, {0, 0, 1}, kEdge}, positions, tissue.tets(),
                         std::vector<Index>{i}, shares);
       }},

      {"find_vertex_tets", own_vertices,
       [&](Index i) {
         (void)find_vertex_tets(own_vertices, std::vector<Tet>{{i, i, i, i}});
       }},
      {"find_components, tets", own_vertices,
       [&](Index i) {
         (void)find_components(own_vertices, std::span<const Tet>(std::vector<Tet>{{i, i, i, i}}));
       }},
      {"find_components, triangles", own_vertices,
       [&](Index i) {
         const Triangle triangle{i, i, i};
         (void)find_components(own_vertices, std::span(&triangle, 1));
       }},
      {"count_vertex_tets", own_vertices,
       [&](Index i) {
         (void)count_vertex_tets(own_vertices, std::vector<Tet>{{i, i, i, i}});
       }},
      {"edge_lengths", own_vertices,
       [&](Index i) {
         (void)edge_lengths(points, std::vector<Edge>{{i, 0}});
       }},
      {"orient_tets", own_vertices,
       [&](Index i) {
         Tet tet{i, i, i, i};
         orient_tets(points, std::span(&tet, 1));
       }},
      {"find_edge", 2,
       [&](Index i) {
         (void)find_edge(std::vector<Edge>{{0, 2}, {1, 2}}, i, 2);
       }},
      {"partition_vertices", own_vertices,
       [&](Index i) {
         const Edge edge{i, i == 0 ? 1 : 0};
         (void)partition_vertices(std::span(&edge, 1), points, 2);
       }},
  };
  for (const Call& call : calls) {
    for (const Index bad : testing::bad_ids(call.count)) {
      INFO(call.name << " of " << bad);
      CHECK_THROWS_AS(call.of(bad), InvalidArgument);
    }
    for (const Index good : {Index{0}, call.count - 1}) {
      INFO(call.name << " of " << good);
      CHECK_NOTHROW(call.of(good));
    }
  }
  CHECK_THROWS_AS(find_vertex_tets(-1, {}), InvalidArgument);
  CHECK_THROWS_AS(find_components(-1, std::span<const Tet>{}), InvalidArgument);
  CHECK_THROWS_AS(count_vertex_tets(-1, {}), InvalidArgument);
  CHECK_THROWS_AS(find_tet_edges(mesh.tets(), {}), InvalidArgument);
  CHECK_FALSE(surface.is_on_surface(own_vertices));  // of the other body
}

}  // namespace pbdsurg
