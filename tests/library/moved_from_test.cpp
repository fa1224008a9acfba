// SPDX-License-Identifier: Apache-2.0
// What was moved from, of every public class that can be.
#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "pbdsurg/base/owned.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/heat/disk_source.h"
#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/heat/surface_texture.h"
#include "pbdsurg/mesh/series.h"
#include "pbdsurg/mesh/surface_distance.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/library.h"
#include "pbdsurg/views/live_boundary.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;

// Calls something of an object that was moved from, which says so.
template <class Call>
void check_refused(Call call) {
  CHECK_THROWS_AS(call(), InvalidArgument);
  CHECK_THROWS_WITH(call(), ContainsSubstring("was moved from"));
}

// Two blocks that a strand joins, and all that can follow their edits.
struct World {
  TetMesh mesh = testing::make_box({3, 3, 3}, 1e-3);
  Scene scene;
  ConnectiveTissue strands;
  std::vector<ThermalBody> bodies{{0, tissues::fat().heat}};

  World() {
    scene.add_body("a", mesh);
    scene.add_body("b", mesh);
    const MembraneLink link{0, 1, 1e-3};
    strands.join(scene, 0, 1, std::span(&link, 1));
  }
};

const Electrode kAway{{1, 1, 1}, {1, 1, 1}};
const TopologyEdit kRemoval{.remove_tets = {0}, .remove_links = {0}};

// Leaves `object` as one that was moved from, and gives where it went.
template <class T>
T moved_out(T& object) {
  return std::move(object);
}

}  // namespace

TEST_CASE("moved from: a solver says so, whatever it is asked", "[unit]") {
  const World world;
  Solver solver(world.scene);
  Tissue& tissue = solver.tissue();  // which stays where it is
  ContactProbe probe(solver, std::vector<Index>{0}, {});
  Solver there = moved_out(solver);
  Snapshot snapshot = there.snapshot();
  std::vector<Eigen::Vector3f> positions = there.positions();
  const std::vector<Index> ids{0};
  const ToolPose pose = ToolPose::Identity();

  check_refused([&] { solver.step(1e-3F); });
  check_refused([&] { solver.start_step(1e-3F); });
  check_refused([&] { solver.finish_step(); });
  check_refused([&] { (void)solver.last_report(); });
  check_refused([&] { (void)solver.options(); });
  check_refused([&] { (void)solver.plan(); });
  check_refused([&] { (void)solver.backend_name(); });
  check_refused([&] { (void)solver.memory_bytes(); });
  check_refused([&] { (void)solver.vertex_count(); });
  check_refused([&] { (void)solver.positions(); });
  check_refused([&] { solver.read_positions(positions); });
  check_refused([&] { solver.read_positions(ids, std::span(positions).first(1)); });
  check_refused([&] { solver.watch({}); });
  check_refused([&] { (void)solver.watched_positions(); });
  check_refused([&] { solver.write_positions(positions); });
  check_refused([&] { (void)solver.velocities(); });
  check_refused([&] { solver.write_velocities(positions); });
  check_refused([&] { (void)solver.snapshot(); });
  check_refused([&] { solver.restore(snapshot); });
  check_refused([&] { (void)solver.state_hash(); });
  check_refused([&] { solver.add_tool({}, pose); });
  check_refused([&] { solver.move_tool(ToolId{0}, pose); });
  check_refused([&] { solver.grasp(ToolId{0}, ids); });
  check_refused([&] { solver.grasp(ToolId{0}, {}, Grip{}); });
  check_refused([&] { solver.close_jaws(ToolId{0}, {ToolId{0}, ToolId{1}}, {}); });
  check_refused([&] { solver.set_clamp_force(ToolId{0}, 1); });
  check_refused([&] { (void)solver.tool_grip(ToolId{0}); });
  check_refused([&] { (void)solver.lost_grips(); });
  check_refused([&] { solver.release(ToolId{0}); });
  check_refused([&] { (void)solver.tool_force(ToolId{0}); });
  check_refused([&] { (void)solver.tissue(); });
  check_refused([&] { (void)std::as_const(solver).tissue(); });
  check_refused([&] { (void)solver.rest_length(0); });
  check_refused([&] { (void)solver.rest_volume(0); });
  // and so does all that is given one
  ConnectiveTissue strands = world.strands;
  tissue.add_follower(strands, FollowerRank::surgery);
  Cautery cautery(tissue, world.bodies);
  std::vector<Index> links;
  check_refused([&] { (void)plan_cut(solver, {}); });
  check_refused([&] { (void)find_vertices_near(solver, 0, {0, 0, 0}, 1); });
  check_refused([&] { cautery.update(solver, kAway, {}, 1e-3); });
  ContactPatch patch;
  check_refused([&] { probe.collect_patch(solver, ToolId{0}, GraspState::open, 1, 0, patch); });
  check_refused([&] { ContactProbe late(solver, ids, {}); });
  check_refused([&] { strands.find_torn(solver, links); });
  check_refused([&] { strands.find_cut(solver, {}, links); });
  check_refused([&] { strands.separate(solver); });
  check_refused([&] { Compaction compaction(solver); });

  CHECK(&there.tissue() == &tissue);
  solver = std::move(there);
  CHECK(solver.positions() == positions);
  tissue.apply(kRemoval);
  solver.step(1e-3F);
}

// Would catch an edit that is followed, or undone, where the follower was, and not where it went.
TEST_CASE("moved from: followers follow edits where they went", "[unit]") {
  World world;
  Solver solver(world.scene);
  Tissue& tissue = solver.tissue();
  // `see` gives something that the edit changes
  const auto try_out = [&](auto follower, auto see, auto&&... calls) {
    const auto before = see(follower);
    tissue.apply(kRemoval);
    const auto after = see(follower);
    CHECK(after != before);
    auto there = moved_out(follower);
    if constexpr (std::is_base_of_v<Follower, decltype(follower)>) {
      check_refused([&] { tissue.check_follower(follower, "it"); });
      CHECK_NOTHROW(tissue.check_follower(there, "it"));
    }
    tissue.undo();
    CHECK(see(there) == before);
    tissue.apply(kRemoval);
    CHECK(see(there) == after);
    (calls(follower), ...);

    follower = std::move(there);
    CHECK(see(follower) == after);
    tissue.undo();
    CHECK(see(follower) == before);
    tissue.apply(kRemoval);
    CHECK(see(follower) == after);
    tissue.undo();
  };
  SECTION("live surface") {
    const auto see = [](const LiveSurface& surface) {
      return std::vector(surface.triangles().begin(), surface.triangles().end());
    };
    try_out(LiveSurface(tissue, 0), see, [](LiveSurface& surface) {
      CHECK(surface.slot_count() == 0);
      CHECK(surface.triangle_count() == 0);
      CHECK(surface.triangles().empty());
      CHECK(surface.origins().empty());
      std::vector<SlotRange> ranges;
      surface.collect_changes(0, ranges);
      surface.collect_changes(surface.version(), ranges);
      CHECK_THROWS_AS(surface.is_on_surface(0), InvalidArgument);
    });
  }
  SECTION("live pieces") {
    const auto see = [](const LivePieces& pieces) { return pieces.tet_count(0); };
    try_out(LivePieces(tissue), see, [&](LivePieces& pieces) {
      CHECK(pieces.count() == 0);
      CHECK_THROWS_AS(pieces.piece_of(0), InvalidArgument);
      CHECK_THROWS_AS(pieces.tets(0), InvalidArgument);
      TopologyEdit edit;
      check_refused([&] { pieces.add_crumbs(tissue, edit, 3); });
    });
  }
  SECTION("thermal mesh") {
    const auto see = [](const ThermalMesh& mesh) { return mesh.version() > 0; };
    try_out(ThermalMesh(tissue, world.bodies), see, [](ThermalMesh& mesh) {
      CHECK(mesh.vertex_count() == 0);
      CHECK(mesh.tet_count() == 0);
      CHECK(mesh.tissues().empty());
      CHECK(mesh.tets().empty());
      CHECK(mesh.rest_positions().empty());
      check_refused([&] { (void)mesh.tissue(); });
      check_refused([&] { mesh.check_current("it"); });
      mesh.set_tissue(tissues::liver().heat);
    });
  }
  SECTION("heat field") {
    const auto see = [](const HeatField& field) { return field.ledger().removed; };
    HeatField warm(tissue, world.bodies);
    warm.set_temperatures(std::vector<Index>{world.mesh.tets()[0][0]}, std::vector<double>{60});
    try_out(std::move(warm), see, [](HeatField& field) {
      const HeatSource source{0, 1};
      check_refused([&] { field.step(1e-3, {}); });
      check_refused([&] { field.step(1e-3, std::span(&source, 1)); });
      check_refused([&] { (void)field.active_vertices(); });
      check_refused([&] { const HeatField copy(field); });
      check_refused([&] { PotentialField potential(field); });
      CHECK(field.temperatures().empty());
      CHECK_THROWS_AS(field.capacity(0), InvalidArgument);
      CHECK_THROWS_AS(field.has_boiled(0), InvalidArgument);
      CHECK_THROWS_AS(field.boiled_vertices(0), InvalidArgument);
      const std::vector<Index> vertices{0};
      const std::vector<double> temperatures{50};
      CHECK_THROWS_AS(field.set_temperatures(vertices, temperatures), InvalidArgument);
      CHECK_THROWS_AS(field.hold(vertices), InvalidArgument);
    });
  }
  SECTION("cautery") {
    const auto see = [](const Cautery& cautery) { return cautery.state(0); };
    try_out(Cautery(tissue, world.bodies), see, [&](Cautery& cautery) {
      check_refused([&] { cautery.update(solver, kAway, {}, 1e-3); });
      check_refused([&] { (void)cautery.field(); });
      check_refused([&] { (void)cautery.potential(); });
      check_refused([&] { (void)cautery.state(0); });
      check_refused([&] { (void)cautery.link_energy_spent(); });
      check_refused([&] { (void)cautery.electrode_energy(); });
      check_refused([&] { (void)cautery.removal_energy(); });
    });
  }
  SECTION("connective tissue") {
    ConnectiveTissue registered = world.strands;
    tissue.add_follower(registered, FollowerRank::surgery);
    const auto see = [](const ConnectiveTissue& strands) { return strands.whole_count(); };
    try_out(std::move(registered), see, [&](ConnectiveTissue& strands) {
      std::vector<Index> links;
      Scene scene = world.scene;
      check_refused([&] { strands.find_torn(solver, links); });
      check_refused([&] { strands.find_cut(solver, {}, links); });
      check_refused([&] { strands.separate(solver); });
      CHECK(strands.join(scene, 0, 1, {}) == 0);
      CHECK(strands.strands().empty());
      CHECK(strands.whole_count() == 0);
      CHECK(strands.events().empty());
      CHECK(strands.share_lost(StrandLoss::torn) == 0);
      CHECK_THROWS_AS(strands.is_whole(0), InvalidArgument);
    });
  }
}

TEST_CASE("moved from: a compaction says so", "[unit]") {
  const World world;
  Solver solver(world.scene);
  Compaction compaction(solver);
  Compaction there = moved_out(compaction);
  check_refused([&] { compaction.build(); });
  check_refused([&] { (void)compaction.finish(solver); });
  compaction = std::move(there);
  compaction.build();
  (void)compaction.finish(solver);
}

TEST_CASE("moved from: a contact probe says so", "[unit]") {
  const World world;
  Solver solver(world.scene);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  ContactProbe probe(solver, std::vector<Index>{0}, {});
  ContactProbe there = moved_out(probe);
  ContactPatch patch;
  const auto collect = [&] { probe.collect_patch(solver, tool, GraspState::open, 1, 0, patch); };
  check_refused(collect);
  check_refused([&] { probe.collect_patch({}, solver, tool, GraspState::open, 1, 0, patch); });
  check_refused([&] { (void)make_contact_packet(probe, solver, tool, GraspState::open, 1, 0); });
  probe = std::move(there);
  collect();
}

TEST_CASE("moved from: a scene and a mesh are empty", "[unit]") {
  World world;
  const Scene scene = moved_out(world.scene);
  CHECK(world.scene.bodies().empty());
  CHECK(world.scene.vertex_count() == 0);
  CHECK_THROWS_AS(world.scene.is_fixed(0), InvalidArgument);
  CHECK_THROWS_AS(world.scene.body(0), InvalidArgument);
  CHECK(world.scene.add_body("a", world.mesh) == 0);
  Solver(world.scene).step(1e-3F);

  const TetMesh mesh = moved_out(world.mesh);
  CHECK(world.mesh.vertex_count() == 0);
  CHECK(world.mesh.tet_count() == 0);
  CHECK(lumped_masses(world.mesh, 1000).empty());
}

// Would catch shapes that share nothing any more, and call a null pointer.
TEST_CASE("moved from: shapes and distances stay what they are", "[unit]") {
  ImplicitShape shape = sphere_shape({0, 0, 0}, 1);
  const ImplicitShape other = moved_out(shape);
  CHECK(shape({2, 0, 0}) == other({2, 0, 0}));
  CHECK(shape.bounds().isApprox(other.bounds()));
  CHECK(shape.project({1.01, 0, 0}, 1) == other.project({1.01, 0, 0}, 1));
  ImplicitShape third = sphere_shape({0, 0, 0}, 2);
  third = std::move(shape);
  CHECK(shape({2, 0, 0}) == third({2, 0, 0}));

  const TetMesh box = testing::make_box({1, 1, 1}, 1);
  std::vector<Triangle> triangles;
  for (const BoundaryTriangle& triangle : find_boundary(box.tets())) {
    triangles.push_back(triangle.vertices);
  }
  SurfaceDistance distance(box.positions(), triangles);
  const SurfaceDistance same = moved_out(distance);
  CHECK(distance.signed_distance({0.5, 0.5, 0.9}) == same.signed_distance({0.5, 0.5, 0.9}));
  CHECK(distance.bounds().isApprox(same.bounds()));
}

// Would catch what is left of a map that takes only what has changed since it was whole.
TEST_CASE("moved from: maps and textures begin anew", "[unit]") {
  const World world;
  const Solver solver(world.scene);
  const LiveSurface surface(solver.tissue(), 0);
  const std::vector<double> warm(static_cast<std::size_t>(solver.vertex_count()), 60.0);
  const std::vector<double> ones(warm.size(), 1.0), none(warm.size(), 0.0);
  const SurfaceFields fields{warm, ones, ones, none};
  SurfaceMap map;
  SurfaceTexture texture;
  map.update(surface, fields);
  texture.update(surface, map);

  const SurfaceMap map_there = moved_out(map);
  const SurfaceTexture texture_there = moved_out(texture);
  CHECK(map.temperatures().empty());
  CHECK(texture.temperatures().empty());
  map.update(surface, fields);
  CHECK(std::ranges::equal(map.temperatures(), map_there.temperatures()));
  texture.update(surface, map);
  CHECK(std::ranges::equal(texture.temperatures(), texture_there.temperatures()));
}

// Would catch a division by the number of changes that it remembers, which is zero.
TEST_CASE("moved from: a log of changes gives all slots once", "[unit]") {
  ChangeLog log(8);
  log.note(3);
  const std::uint64_t before = log.version();
  const ChangeLog there = moved_out(log);
  log.note(5);
  log.note_again(before);
  log.note_all();
  std::vector<SlotRange> ranges;
  log.collect(before, 8, ranges);
  REQUIRE(ranges.size() == 1);
  CHECK(ranges[0].first == 0);
  CHECK(ranges[0].end == 8);
  log = there;
  log.collect(1, 8, ranges);
  REQUIRE(ranges.size() == 1);
  CHECK(ranges[0].first == 3);
}

TEST_CASE("moved from: a disk source and a series of meshes say so", "[unit]") {
  const TetMesh box = testing::make_box({1, 1, 1}, 1e-2);
  std::vector<Eigen::Vector3f> positions;
  for (const Eigen::Vector3d& x : box.positions()) {
    positions.push_back(x.cast<float>());
  }
  const DiskContact contact{{5e-3, 5e-3, 1e-2}, {0, 0, -1}, 1e-3};
  const std::vector<Index> near{0, 1, 2, 3, 4, 5};
  std::vector<VertexShare> shares;
  DiskSource source;
  DiskSource there = moved_out(source);
  check_refused([&] { source.distribute(contact, positions, box.tets(), near, shares); });
  source = std::move(there);
  CHECK(source.distribute(contact, positions, box.tets(), near, shares) > 0);

  const std::filesystem::path path = std::filesystem::temp_directory_path() / "pbdsurg_moved.pvd";
  MeshSeries series(path);
  MeshSeries elsewhere = moved_out(series);
  check_refused([&] { series.add_frame(0, {}); });
  CHECK(series.frame_count() == 0);
  series = std::move(elsewhere);
  CHECK(series.frame_count() == 0);
  std::filesystem::remove(path);
}

}  // namespace pbdsurg
