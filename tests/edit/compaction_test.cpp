// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/compaction.h"

#include <algorithm>
#include <array>
#include <memory>
#include <numeric>
#include <thread>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_boundary.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/plan_checks.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::is_plan_valid;
using testing::kEventfulTimeStep;
using testing::serial_options;
using testing::Variant;

std::vector<Variant> compaction_variants() {
  return {{.damping = 0.01F},
          {.composition = PlanComposition::joint},
          {.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
          {.max_colors = 5},
          {.method = SolverMethod::vertex_block},
          {.method = SolverMethod::vertex_block, .damping = 0.01F}};
}

// Removals, shrinkage, cuts, a body that comes and one that goes.
void edit_much(Solver& solver, ProjectionMode mode) {
  for (Index round = 0; round < 6; ++round) {
    solver.tissue().apply(testing::eventful_edit(solver, round));
    solver.tissue().apply(testing::part_vertex(solver, 60 + 4 * round, 7));
    Index edge = 11 * round;
    while (!solver.tissue().is_edge_alive(edge)) {
      ++edge;
    }
    solver.tissue().apply(testing::split_edge(solver, edge, 0.4F));
  }
  Scene guests;
  const TetMesh box = testing::make_box({2, 2, 2}, testing::kEventfulEdge);
  guests.add_body("guest", box, elastic_material(box, 900, 1e4));
  guests.add_particles("dust", std::vector<Eigen::Vector3d>{{0.03, 0, 0}, {0.03, 0.01, 0}}, 1e-5);
  solver.tissue().apply({.new_bodies = guests});
  const Index dust = solver.tissue().body(4).first_vertex;
  solver.tissue().apply(
      {.remove_bodies = {1},
       .new_links = {{0, solver.tissue().body(3).first_vertex, 0.01F, {0.5F, 1e-3F}},
                     {dust, 2, 0.01F, {0.5F, 1e-3F}}}});
  if (mode == ProjectionMode::compliance) {
    solver.tissue().apply({.rest_volumes = {{solver.tissue().body(2).first_tet + 1, 3e-9F}}});
  }
}

Renumbering compact(Solver& solver) {
  Compaction compaction(solver);
  compaction.build();
  return compaction.finish(solver);
}

}  // namespace

// Would catch a compaction that gives a solver the options, copies and rest values of another.
TEST_CASE("compaction: is refused by another solver of the same tissue", "[edit][compaction]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3), testing::kSprings);
  Tissue tissue(scene);
  auto origin = std::make_unique<Solver>(tissue, testing::small_steps());
  Compaction compaction(*origin);
  compaction.build();
  origin.reset();
  Solver other(tissue, testing::small_steps({.copies = 2}));
  CHECK_THROWS_WITH(compaction.finish(other), ContainsSubstring("this is another"));
  CHECK_NOTHROW(other.step(1e-3F));
}

// Would catch tissue, numbers, links or state that go missing or to others, and dead ones that
// stay.
TEST_CASE("compaction: all that lives goes over, and nothing else", "[property]") {
  const Variant variant = GENERATE(from_range(compaction_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  Solver solver(scene, serial_options(variant, 2)), before(scene, serial_options(variant, 2));
  for (Solver* each : {&solver, &before}) {
    edit_much(*each, variant.mode);
    const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0, 0.016F, 0.006F);
    each->add_tool({&capsule, 1}, pose);
    each->add_tool({}, ToolPose::Identity());
    each->grasp(
        ToolId{1},
        std::array{each->tissue().body(2).first_vertex + 1, each->tissue().body(4).first_vertex},
        1e-4F, 1);
    each->watch(std::array{each->tissue().body(2).first_vertex, Index{1}});
    each->step(kEventfulTimeStep);
  }
  REQUIRE(digest_of(inspect(solver)) == digest_of(inspect(before)));
  const std::size_t bytes = solver.memory_bytes();
  const Renumbering ids = compact(solver);
  CHECK(solver.memory_bytes() < bytes);
  CHECK(is_plan_valid(inspect(solver)));
  CHECK(solver.tissue().version() == ids.version);
  CHECK(ids.version == before.tissue().version() + 1);

  CHECK(ids.bodies == std::vector<Index>{0, kInvalidIndex, 1, 2, 3});
  for (Index b = 0; b < 5; ++b) {
    CHECK((ids.bodies[b] == kInvalidIndex ||
           solver.tissue().body(ids.bodies[b]).name == before.tissue().body(b).name));
  }
  const SolverData& a = inspect(before);
  const SolverData& c = inspect(solver);
  const auto mapped = [&](auto vertices) {
    std::ranges::transform(vertices, vertices.begin(), [&](Index v) { return ids.vertices[v]; });
    return vertices;
  };
  Index count = 0;
  for (Index v = 0; v < before.vertex_count(); ++v) {
    REQUIRE((ids.vertices[v] != kInvalidIndex) == before.tissue().has_tissue(v));
    if (ids.vertices[v] != kInvalidIndex) {
      ++count;
      const Index now = ids.vertices[v];
      REQUIRE(c.tissue->masses()[now] == a.tissue->masses()[v]);
      REQUIRE(c.particle(now).w == a.particle(v).w);
      REQUIRE(solver.tissue().body_of_vertex(now) == ids.bodies[before.tissue().body_of_vertex(v)]);
      for (Index copy = 0; copy < 2; ++copy) {
        const Index place = c.place_of_vertex[now], old_place = a.place_of_vertex[v];
        REQUIRE(c.copy(copy).particles[place].x == a.copy(copy).particles[old_place].x);
        REQUIRE(c.copy(copy).velocities[place].y == a.copy(copy).velocities[old_place].y);
        if (!c.carries.empty()) {
          REQUIRE(c.copy(copy).carries[place].x == a.copy(copy).carries[old_place].x);
          REQUIRE(c.copy(copy).carries[place].falling == a.copy(copy).carries[old_place].falling);
        }
      }
    }
  }
  CHECK(count == solver.vertex_count());
  count = 0;
  for (Index t = 0; t < static_cast<Index>(before.tissue().tets().size()); ++t) {
    REQUIRE((ids.tets[t] != kInvalidIndex) == before.tissue().is_tet_alive(t));
    if (const Index now = ids.tets[t]; now != kInvalidIndex) {
      ++count;
      REQUIRE(solver.tissue().is_tet_alive(now));
      REQUIRE(solver.tissue().tets()[now] == mapped(before.tissue().tets()[t]));
      REQUIRE(c.tissue->tet_mass(now) == a.tissue->tet_mass(t));
      REQUIRE(solver.tissue().body_of_tet(now) == ids.bodies[before.tissue().body_of_tet(t)]);
      const TetNumbers x = a.sets.numbers_of_tet(t), y = c.sets.numbers_of_tet(now);
      REQUIRE(x.volume == y.volume);
      REQUIRE(x.neo_hookean == y.neo_hookean);
      for (std::size_t e = 0; e < 6; ++e) {
        REQUIRE(solver.tissue().tet_edges(now)[e] == ids.edges[before.tissue().tet_edges(t)[e]]);
      }
    }
  }
  CHECK(count == static_cast<Index>(solver.tissue().tets().size()));
  count = 0;
  for (Index e = 0; e < static_cast<Index>(before.tissue().edges().size()); ++e) {
    REQUIRE((ids.edges[e] != kInvalidIndex) == before.tissue().is_edge_alive(e));
    if (const Index now = ids.edges[e]; now != kInvalidIndex) {
      ++count;
      Edge ends = mapped(before.tissue().edges()[e]);
      std::ranges::sort(ends);
      REQUIRE(solver.tissue().edges()[now] == ends);
      const EdgeNumbers x = a.sets.numbers_of_edge(e), y = c.sets.numbers_of_edge(now);
      REQUIRE(x.distance == y.distance);
      REQUIRE(x.limit == y.limit);
    }
  }
  CHECK(count == static_cast<Index>(solver.tissue().edges().size()));
  count = 0;
  for (Index l = 0; l < static_cast<Index>(before.tissue().links().size()); ++l) {
    REQUIRE((ids.links[l] != kInvalidIndex) == before.tissue().is_link_alive(l));
    if (const Index now = ids.links[l]; now != kInvalidIndex) {
      REQUIRE(now == count++);
      REQUIRE(solver.tissue().is_link_alive(now));
      REQUIRE(solver.tissue().links()[now].first == ids.vertices[before.tissue().links()[l].first]);
      REQUIRE(solver.tissue().links()[now].second ==
              ids.vertices[before.tissue().links()[l].second]);
      const Index i = a.sets.distance_ids.of_link(l), j = c.sets.distance_ids.of_link(now);
      REQUIRE(a.sets.of<DistanceConstraint>().record(i).parameters ==
              c.sets.of<DistanceConstraint>().record(j).parameters);
    }
  }
  CHECK(count == static_cast<Index>(solver.tissue().links().size()));
  for (Index copy = 0; copy < 2; ++copy) {
    CHECK(std::ranges::equal(solver.watched_positions(copy), before.watched_positions(copy)));
    CHECK(solver.last_report(copy).contacts == before.last_report(copy).contacts);
    for (Index tool = 0; tool < 2; ++tool) {
      CHECK(solver.tool_force(ToolId(tool), copy) == before.tool_force(ToolId(tool), copy));
    }
  }
  CHECK(c.copy(1).tools[1].attachments.size() == 2);
}

// Would catch a solver that is pulled, held or pushed otherwise from then on.
TEST_CASE("compaction: steps go on as they would have", "[equivalence]") {
  Variant variant = GENERATE(from_range(compaction_variants()));
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const TetMesh block = testing::make_box({4, 4, 3}, testing::kEventfulEdge, 0.1);
  Material soft = elastic_material(block, 1000, 20e3);
  soft.damping = variant.damping;
  Scene scene;
  scene.add_body("gone", testing::make_box({1, 1, 1}, testing::kEventfulEdge), soft);
  scene.add_body("block", block, soft);
  scene.fix_where(1, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  scene.add_particles("bead", std::vector<Eigen::Vector3d>{{0.016, 0.02, 0}}, 1e-5);
  const Index first = scene.body(1).first_vertex, bead = scene.body(2).first_vertex;
  scene.add_link({bead, first + block.vertex_count() - 1, 0.013F, {0.5F, 1e-3F}});
  SolverOptions options = serial_options(variant, 2);
  options.executor = executor;
  options.substeps = 10;
  options.iterations = 10;  // sweeps in another order come to the same
  Solver solver(scene, options), unchanged(scene, options);
  for (Solver* each : {&solver, &unchanged}) {
    each->tissue().apply({.remove_bodies = {0}});
    for (Index round = 0; round < 6; ++round) {
      each->tissue().apply(testing::part_vertex(*each, first + 30 + 7 * round, 7));
      each->tissue().apply(
          testing::split_edge(*each, each->tissue().tet_edges(20 + 9 * round)[1], 0.4F));
    }
    each->add_tool({}, ToolPose::Identity());
    each->grasp(ToolId{0}, std::array{first + block.vertex_count() - 1}, 1e-4F, 1);
    each->step(kEventfulTimeStep);
  }
  const Renumbering ids = compact(solver);
  for (int i = 0; i < 5; ++i) {
    solver.step(kEventfulTimeStep);
    unchanged.step(kEventfulTimeStep);
  }
  for (Index copy = 0; copy < 2; ++copy) {
    const auto now = solver.positions(copy), expected = unchanged.positions(copy);
    double farthest = 0;
    for (std::size_t v = 0; v < expected.size(); ++v) {
      if (ids.vertices[v] != kInvalidIndex) {
        farthest = std::max(farthest, double{(now[ids.vertices[v]] - expected[v]).norm()});
      }
    }
    CHECK(farthest < 0.02 * testing::kEventfulEdge);
  }
  const Eigen::Vector3f force = solver.tool_force(ToolId{0}, 1),
                        other = unchanged.tool_force(ToolId{0}, 1);
  CHECK((force - other).norm() < 0.1F * other.norm());
}

// Would catch another order of vertices, constraints or rows than that of a fresh solver.
TEST_CASE("compaction: without edits, at rest, all bits are those of a fresh solver",
          "[equivalence]") {
  const Variant variant = GENERATE(from_range(compaction_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  Solver solver(scene, serial_options(variant, 2)), fresh(scene, serial_options(variant, 2));
  const Renumbering ids = compact(solver);
  std::vector<Index> same(static_cast<std::size_t>(scene.vertex_count()));
  std::iota(same.begin(), same.end(), 0);
  CHECK(ids.vertices == same);
  CHECK(digest_of(inspect(solver)) == digest_of(inspect(fresh)));
  for (int i = 0; i < 3; ++i) {
    solver.step(kEventfulTimeStep);
    fresh.step(kEventfulTimeStep);
  }
  CHECK(solver.state_hash(1) == fresh.state_hash(1));
}

// Would catch triangles that change slots, pieces that change ids, and either of them misled in
// edits and undos from then on; those of a body that is gone, or came late, included.
TEST_CASE("compaction: surfaces keep their slots and pieces their ids", "[property]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  const SolverOptions options = testing::small_steps({.executor = executor::serial()});
  Solver solver(scene, options);
  edit_much(solver, ProjectionMode::compliance);
  LivePieces pieces(solver.tissue());
  std::vector<LiveSurface> surfaces;
  for (Index b = 0; b < static_cast<Index>(solver.tissue().bodies().size()); ++b) {
    surfaces.emplace_back(solver.tissue(), b);
  }
  std::vector<Index> bodies(surfaces.size());  // of the surfaces, as they are numbered now
  std::iota(bodies.begin(), bodies.end(), 0);
  for (Index round = 0; round < 4; ++round) {
    for (Index i = 0; i < 4; ++i) {
      for (const TopologyEdit& edit : {testing::eventful_edit(solver, 4 * round + i),
                                       testing::part_vertex(solver, 20 + 3 * i + 5 * round, 7)}) {
        solver.tissue().apply(edit);
        solver.tissue().undo();
        solver.tissue().apply(edit);
      }
    }
    const LivePieces old_pieces = pieces;
    const std::vector<LiveSurface> old_surfaces = surfaces;
    const Renumbering ids = compact(solver);
    REQUIRE(pieces.count() == old_pieces.count());
    for (std::size_t t = 0; t < ids.tets.size(); ++t) {
      const Index piece = old_pieces.piece_of(static_cast<Index>(t));
      REQUIRE((ids.tets[t] == kInvalidIndex ? piece == kInvalidIndex
                                            : pieces.piece_of(ids.tets[t]) == piece));
    }
    for (Index piece = 0; piece < pieces.count(); ++piece) {
      const std::vector<Index> tets = pieces.tets(piece);
      REQUIRE(pieces.tet_count(piece) == old_pieces.tet_count(piece));
      REQUIRE(static_cast<Index>(tets.size()) == pieces.tet_count(piece));
      REQUIRE(pieces.is_anchored(piece) == old_pieces.is_anchored(piece));
      REQUIRE((tets.empty() || pieces.body(piece) == solver.tissue().body_of_tet(tets[0])));
    }
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      LiveSurface& now = surfaces[s];
      const LiveSurface& before = old_surfaces[s];
      std::vector<SlotRange> ranges;
      now.collect_changes(before.version(), ranges);
      REQUIRE((ranges.size() == 1 && ranges[0].end == now.slot_count()));
      REQUIRE(now.slot_count() == before.slot_count());
      for (Index slot = 0; slot < now.slot_count(); ++slot) {
        const TetFace from = before.origins()[slot], to = now.origins()[slot];
        REQUIRE(to.tet == (from.tet == kInvalidIndex ? kInvalidIndex : ids.tets[from.tet]));
        REQUIRE(to.face == from.face);
      }
      bodies[s] = bodies[s] == kInvalidIndex ? kInvalidIndex : ids.bodies[bodies[s]];
      std::vector<std::pair<Index, Triangle>> shown, expected;
      for (Index slot = 0; slot < now.slot_count(); ++slot) {
        if (now.origins()[slot].tet != kInvalidIndex) {
          shown.emplace_back(now.origins()[slot].tet, now.triangles()[slot]);
        }
      }
      if (bodies[s] != kInvalidIndex) {
        for (const BoundaryTriangle& triangle : find_live_boundary(solver.tissue(), bodies[s])) {
          expected.emplace_back(triangle.tet, triangle.vertices);
          REQUIRE(now.is_on_surface(triangle.vertices[0]));
        }
      }
      std::ranges::sort(shown);
      std::ranges::sort(expected);
      REQUIRE(shown == expected);
    }
  }
  CHECK(std::ranges::count(bodies, kInvalidIndex) == 1);
}

// Would catch a build that touches the solver, which thread sanitizer sees, or depends on when it
// runs.
TEST_CASE("compaction: builds in another thread while the solver steps", "[property]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  const SolverOptions options =
      testing::small_steps({.executor = executor::threads(2), .math = MathMode::strict});
  Solver solver(scene, options), other(scene, options);
  edit_much(solver, ProjectionMode::compliance);
  edit_much(other, ProjectionMode::compliance);
  Compaction compaction(solver), in_turn(other);
  std::thread worker([&] { compaction.build(); });
  for (int i = 0; i < 5; ++i) {
    solver.step(kEventfulTimeStep);
  }
  worker.join();
  in_turn.build();
  for (int i = 0; i < 5; ++i) {
    other.step(kEventfulTimeStep);
  }
  CHECK(compaction.finish(solver).vertices == in_turn.finish(other).vertices);
  solver.step(kEventfulTimeStep);
  other.step(kEventfulTimeStep);
  CHECK(solver.state_hash() == other.state_hash());
  solver.tissue().apply(testing::part_vertex(solver, 20, 3));
  CHECK(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
}

TEST_CASE("compaction: what does not fit is refused and changes nothing", "[unit]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  const SolverOptions options = testing::small_steps({.executor = executor::serial()});
  Solver solver(scene, options), other(scene, options);
  const TopologyEdit edit{.remove_bodies = {1}};
  solver.tissue().apply(edit);
  const Snapshot snapshot = solver.snapshot();
  LivePieces pieces(solver.tissue());
  Compaction compaction(solver);
  const auto refuse = [&](Solver& of, const std::string& why) {
    const std::uint64_t before = digest_of(inspect(of));
    CHECK_THROWS_WITH(static_cast<void>(compaction.finish(of)), ContainsSubstring(why));
    CHECK(digest_of(inspect(of)) == before);
  };
  refuse(solver, "finished once, after build()");
  compaction.build();
  refuse(other, "this is another");
  const Index watched = solver.tissue().body(1).first_vertex;
  solver.watch(std::array{Index{3}, watched});
  refuse(solver, "vertex " + std::to_string(watched) + " is watched and has no tissue");
  solver.watch({});
  const TopologyEdit more{.remove_tets = {3}};
  solver.tissue().apply(more);
  refuse(solver, "was edited since");
  solver.tissue().undo();
  {
    const Solver second(solver.tissue(), options);
    refuse(solver, "another solver follows the tissue");
  }
  LivePieces copy = pieces;
  CHECK(compaction.finish(solver).bodies[2] == 1);
  refuse(solver, "finished once");
  CHECK_THROWS_AS(solver.tissue().undo(), InvalidArgument);
  CHECK_THROWS_AS(solver.restore(snapshot), InvalidArgument);
  TopologyEdit crumbs{.remove_tets = {3}};
  CHECK_NOTHROW(pieces.add_crumbs(solver.tissue(), crumbs, 2));
  CHECK_THROWS_WITH(copy.add_crumbs(solver.tissue(), crumbs, 2),
                    ContainsSubstring("does not follow this tissue"));
  CHECK_NOTHROW(solver.tissue().apply({.remove_tets = {3}}));
}

// Would catch a solver taken for another that was at its address before.
TEST_CASE("compaction: is of no other solver, wherever that lies", "[unit]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  const SolverOptions options = testing::small_steps({.executor = executor::serial()});
  auto solver = std::make_unique<Solver>(scene, options);
  Compaction compaction(*solver);
  Solver moved = std::move(*solver);
  compaction.build();
  CHECK_NOTHROW(static_cast<void>(compaction.finish(moved)));

  compaction = Compaction(moved);
  compaction.build();
  moved = Solver(Scene{}, options);
  solver.reset();
  for (int i = 0; i < 8; ++i) {
    Solver next(scene, options);
    next.tissue().apply({});  // to the same version
    CHECK_THROWS_WITH(static_cast<void>(compaction.finish(next)),
                      ContainsSubstring("this is another"));
  }
}

// Would catch a solver of which nothing is left.
TEST_CASE("compaction: an empty solver stays one", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 1, 1}, 4e-3), testing::kSprings);
  Solver solver(scene, testing::small_steps());
  solver.tissue().apply({.remove_bodies = {0}});
  compact(solver);
  CHECK(solver.vertex_count() == 0);
  CHECK(solver.tissue().bodies().empty());
  CHECK(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
}

}  // namespace pbdsurg
