// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <string>
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

// A clot of springs, a thread, and in compliance mode a solid, linked.
Scene make_guests(ProjectionMode mode, const std::string& suffix = "") {
  constexpr double kAside = 0.05;  // m, from the eventful scene
  const auto mesh_at = [&](double y) {
    const TetMesh box = testing::make_box({3, 3, 2}, testing::kEventfulEdge, 0.1, 5);
    std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& x : positions) {
      x += Eigen::Vector3d(kAside, y, 0);
    }
    return TetMesh(positions, {box.tets().begin(), box.tets().end()});
  };
  Scene scene;
  const TetMesh clot = mesh_at(0);
  Material soft = elastic_material(clot, 1000, 10e3);
  soft.damping = mode == ProjectionMode::compliance ? 2e-3F : 0;
  soft.max_stretch = 1.2F;
  Material solid{.model = ElasticModel::neo_hookean, .youngs_modulus = 3000};
  scene.add_body("clot" + suffix, clot, soft);
  scene.add_particles("thread" + suffix,
                      std::vector<Eigen::Vector3d>{{kAside, 0.02, 0}, {kAside, 0.022, 0}}, 1e-5);
  scene.add_body("swab" + suffix, mesh_at(0.024),
                 mode == ProjectionMode::compliance ? solid : soft);
  const Index thread = scene.body(1).first_vertex;
  scene.add_link({0, thread, 0.02F, {0.5F, 1e-3F}});
  scene.add_link({thread, thread + 1, 2e-3F, {0.5F, 1e-3F}});
  scene.fix_vertices(2, std::array{Index{0}, Index{1}, Index{2}});
  return scene;
}

// What a solver would be of a scene and its guests, from the start.
Scene with_guests(Scene scene, ProjectionMode mode) {
  const Scene guests = make_guests(mode);
  const Index first = scene.vertex_count();
  for (const Body& body : guests.bodies()) {
    const auto positions = guests.positions().subspan(body.first_vertex, body.vertex_count);
    if (body.tet_count == 0) {
      scene.add_particles(body.name, positions, 1e-5);
      continue;
    }
    std::vector<Tet> tets;
    for (Tet tet : guests.tets().subspan(body.first_tet, body.tet_count)) {
      for (Index& v : tet) {
        v -= body.first_vertex;
      }
      tets.push_back(tet);
    }
    const Index id = scene.add_body(body.name, TetMesh({positions.begin(), positions.end()}, tets),
                                    body.material);
    for (Index v = 0; v < body.vertex_count; ++v) {
      if (guests.is_fixed(body.first_vertex + v)) {
        scene.fix_vertices(id, std::array{v});
      }
    }
  }
  for (Link link : guests.links()) {
    link.first += first;
    link.second += first;
    scene.add_link(link);
  }
  return scene;
}

std::vector<Variant> guest_variants() {
  return {{},
          {.damping = 0.01F},
          {.composition = PlanComposition::joint},
          {.composition = PlanComposition::nested},
          {.mode = ProjectionMode::fraction},
          {.max_colors = 5},
          {.method = SolverMethod::vertex_block},
          {.method = SolverMethod::vertex_block, .damping = 0.01F}};
}

// Would catch a guest that weighs, resists or is held otherwise than a body of the scene.
void check_same_tissue(const Solver& late, const Solver& early) {
  REQUIRE(late.tissue().bodies().size() == early.tissue().bodies().size());
  REQUIRE(late.vertex_count() == early.vertex_count());
  REQUIRE(std::ranges::equal(late.tissue().tets(), early.tissue().tets()));
  REQUIRE(std::ranges::equal(late.tissue().edges(), early.tissue().edges()));
  const SolverData& a = inspect(late);
  const SolverData& b = inspect(early);
  const TissueData& c = inspect(late.tissue());
  const TissueData& d = inspect(early.tissue());
  CHECK(std::ranges::equal(c.masses.values(), d.masses.values()));
  CHECK(std::ranges::equal(c.tet_masses.values(), d.tet_masses.values()));
  CHECK(std::ranges::equal(c.tissue_counts.values(), d.tissue_counts.values()));
  CHECK(a.sets.has_damping == b.sets.has_damping);
  for (std::size_t i = 0; i < late.tissue().bodies().size(); ++i) {
    CHECK(late.tissue().bodies()[i].name == early.tissue().bodies()[i].name);
    CHECK(late.tissue().bodies()[i].first_vertex == early.tissue().bodies()[i].first_vertex);
    CHECK(late.tissue().bodies()[i].first_tet == early.tissue().bodies()[i].first_tet);
  }
  for (Index v = 0; v < late.vertex_count(); ++v) {
    REQUIRE(late.tissue().body_of_vertex(v) == early.tissue().body_of_vertex(v));
    REQUIRE(a.particle(v).w == b.particle(v).w);
  }
  const auto equal_slots = [](const auto& slots, const auto& others, Index count) {
    for (Index id = 0; id < count; ++id) {
      if (slots.is_alive(id) != others.is_alive(id) ||
          (slots.is_alive(id) && slots.record(id).parameters != others.record(id).parameters)) {
        return false;
      }
    }
    return true;
  };
  const auto tet_count = static_cast<Index>(late.tissue().tets().size());
  CHECK(equal_slots(a.sets.of<VolumeConstraint>(), b.sets.of<VolumeConstraint>(), tet_count));
  CHECK(
      equal_slots(a.sets.of<NeoHookeanConstraint>(), b.sets.of<NeoHookeanConstraint>(), tet_count));
  for (Index t = 0; t < tet_count; ++t) {
    REQUIRE(late.tissue().body_of_tet(t) == early.tissue().body_of_tet(t));
    REQUIRE(std::ranges::equal(late.tissue().tet_edges(t), early.tissue().tet_edges(t)));
  }
  const auto edge_count = static_cast<Index>(late.tissue().edges().size());
  CHECK(equal_slots(a.sets.of<StrainLimitConstraint>(), b.sets.of<StrainLimitConstraint>(),
                    edge_count));
  for (Index e = 0; e < edge_count; ++e) {
    const Index i = a.sets.distance_ids.of_edge(e), j = b.sets.distance_ids.of_edge(e);
    REQUIRE(a.sets.of<DistanceConstraint>().is_alive(i) ==
            b.sets.of<DistanceConstraint>().is_alive(j));
    REQUIRE((!a.sets.of<DistanceConstraint>().is_alive(i) ||
             a.sets.of<DistanceConstraint>().record(i).parameters ==
                 b.sets.of<DistanceConstraint>().record(j).parameters));
  }
  for (Index l = 0; l < static_cast<Index>(late.tissue().links().size()); ++l) {
    const auto record = a.sets.of<DistanceConstraint>().record(a.sets.distance_ids.of_link(l));
    const auto other = b.sets.of<DistanceConstraint>().record(b.sets.distance_ids.of_link(l));
    REQUIRE(record.parameters == other.parameters);
    REQUIRE(late.tissue().links()[l].first == early.tissue().links()[l].first);
    REQUIRE(late.tissue().links()[l].second == early.tissue().links()[l].second);
  }
}

double farthest_apart(const Solver& a, const Solver& b, Index copy = 0) {
  const auto x = a.positions(copy), y = b.positions(copy);
  double farthest = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    farthest = std::max(farthest, double{(x[v] - y[v]).norm()});
  }
  return farthest;
}

}  // namespace

TEST_CASE("bodies: one that comes in is what it would be in the scene", "[equivalence]") {
  const Variant variant = GENERATE(from_range(guest_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  Solver late(scene, serial_options(variant, 2));
  const Solver early(with_guests(scene, variant.mode), serial_options(variant, 2));
  const TissueChange result = late.tissue().apply({.new_bodies = make_guests(variant.mode)});
  CHECK(result.first_new_body == 3);
  CHECK(result.first_new_vertex == scene.vertex_count());
  CHECK(is_plan_valid(inspect(late)));
  check_same_tissue(late, early);
  CHECK(farthest_apart(late, early, 0) == 0);
  CHECK(farthest_apart(late, early, 1) == 0);
}

// Would catch constraints of a guest that no phase projects, or that are in one with others at
// their vertices, and a falling guest that has not the scene's gravity.
TEST_CASE("bodies: one that comes in moves as one that was there", "[equivalence]") {
  const Variant variant = GENERATE(from_range(guest_variants()));
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  Scene scene;
  const TetMesh block = testing::make_box({4, 4, 3}, testing::kEventfulEdge, 0.1);
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-3; });
  SolverOptions options = serial_options(variant);
  options.executor = executor;
  options.substeps = 10;
  options.iterations = 10;  // sweeps in another order come to the same
  Solver late(scene, options), early(with_guests(scene, variant.mode), options);
  late.tissue().apply({.new_bodies = make_guests(variant.mode)});
  const auto start = late.positions();
  for (int i = 0; i < 10; ++i) {
    CHECK(late.step(kEventfulTimeStep).non_finite_vertices == 0);
    early.step(kEventfulTimeStep);
  }
  CHECK(farthest_apart(late, early) < 0.02 * testing::kEventfulEdge);
  const Index thread = late.tissue().body(2).first_vertex;
  CHECK((late.positions()[thread] - start[thread]).norm() > 2e-4F);
}

// Would catch arrays that stay empty because they were, and all that a first body needs.
TEST_CASE("bodies: the first ones can come into an empty solver", "[equivalence]") {
  const Variant variant = GENERATE(from_range(guest_variants()));
  SolverOptions options = serial_options(variant, 2);
  options.substeps = 10;
  options.iterations = 10;
  const Scene guests = make_guests(variant.mode);
  Solver late(Scene{}, options), early(guests, options);
  late.step(kEventfulTimeStep);
  late.tissue().apply({.new_bodies = guests});
  CHECK(is_plan_valid(inspect(late)));
  check_same_tissue(late, early);
  for (int i = 0; i < 10; ++i) {
    CHECK(late.step(kEventfulTimeStep).non_finite_vertices == 0);
    early.step(kEventfulTimeStep);
  }
  CHECK(farthest_apart(late, early, 1) < 0.02 * testing::kEventfulEdge);
}

// Would catch undo that leaves a body, its colours or a damped plan behind, and followers or
// ids of later edits that a body confuses.
TEST_CASE("bodies: undo leaves no trace, in or out, after cuts as before", "[property]") {
  const Variant variant = GENERATE(from_range(guest_variants()));
  const Index copies = GENERATE(1, 3);
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  Solver solver(scene, serial_options(variant, copies));
  Solver unedited(scene, serial_options(variant, copies));
  for (Solver* each : {&solver, &unedited}) {
    each->add_tool({}, ToolPose::Identity());
  }
  for (Index round = 0; round < 8; ++round) {
    INFO("round " << round);
    const std::string suffix = std::to_string(round);
    for (Solver* each : {&solver, &unedited}) {
      if (round % 2 == 1) {  // stays
        each->tissue().apply({.new_bodies = make_guests(variant.mode, suffix + " stays")});
        const Index last = static_cast<Index>(each->tissue().bodies().size()) - 1;
        each->tissue().apply(
            testing::part_vertex(*each, each->tissue().body(last).first_vertex + 21, round));
        each->tissue().apply(testing::split_edge(*each, each->tissue().tet_edges(round)[0], 0.5F));
        REQUIRE(each->tissue().body_of_vertex(each->vertex_count() - 1) == 0);
        each->release(ToolId{0});
        each->grasp(ToolId{0}, std::array{Index{7}, each->tissue().body(last - 1).first_vertex},
                    1e-4F);
      }
      each->step(kEventfulTimeStep);
    }
    const std::uint64_t before = digest_of(inspect(solver));
    REQUIRE(before == digest_of(inspect(unedited)));
    TopologyEdit edit{.new_bodies = make_guests(variant.mode, suffix)};
    const Index first = solver.vertex_count();
    edit.new_links.push_back(
        {Index{9}, first + edit.new_bodies.body(1).first_vertex, 0.03F, {0.5F, 1e-3F}});
    if (round > 1) {
      edit.remove_bodies = {0, 3, 4};
      edit.new_links.clear();
    }
    solver.tissue().apply(edit);
    REQUIRE(digest_of(inspect(solver)) != before);
    REQUIRE(is_plan_valid(inspect(solver)));
    if (round % 4 == 2) {
      solver.grasp(ToolId{0}, std::array{solver.vertex_count() - 1});
    }
    solver.tissue().undo();
    REQUIRE(digest_of(inspect(solver)) == before);
    solver.step(kEventfulTimeStep);
    unedited.step(kEventfulTimeStep);
    for (Index copy = 0; copy < copies; ++copy) {
      REQUIRE(solver.state_hash(copy) == unedited.state_hash(copy));
    }
  }
}

// Would catch tissue, mass, constraints, links or grasps that stay behind.
TEST_CASE("bodies: of one that goes out nothing is left but its name", "[unit]") {
  const Variant variant = GENERATE(from_range(guest_variants()));
  const Scene scene =
      with_guests(testing::make_eventful_scene(variant.mode, variant.damping), variant.mode);
  Solver solver(scene, serial_options(variant));
  solver.tissue().apply(testing::part_vertex(solver, scene.body(5).first_vertex + 21, 3));
  solver.tissue().apply(testing::split_edge(solver, solver.tissue().tet_edges(0)[0], 0.5F));
  solver.add_tool({}, ToolPose::Identity());
  solver.grasp(ToolId{0}, std::array{scene.body(4).first_vertex, Index{5}, Index{60}});
  const TissueChange result = solver.tissue().apply({.remove_bodies = {4, 0, 5}});
  for (Index b = 0; b < 6; ++b) {
    CHECK(solver.tissue().is_body_alive(b) == (b == 1 || b == 2 || b == 3));
    CHECK(solver.tissue().body(b).name == scene.body(b).name);
  }
  Index gone = 0;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    const bool lives = solver.tissue().is_body_alive(solver.tissue().body_of_vertex(v));
    REQUIRE(solver.tissue().has_tissue(v) == lives);
    gone += lives ? 0 : 1;
  }
  CHECK(static_cast<Index>(result.emptied_vertices.size()) == gone);
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    REQUIRE((!solver.tissue().is_tet_alive(t) ||
             solver.tissue().is_body_alive(solver.tissue().body_of_tet(t))));
  }
  for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    REQUIRE((!solver.tissue().is_edge_alive(e) ||
             solver.tissue().has_tissue(solver.tissue().edges()[e][0])));
  }
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    CHECK(!solver.tissue().is_link_alive(l));  // each joined one of them
  }
  CHECK(inspect(solver).tools[0].attachments.empty());
  CHECK(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
  solver.tissue().apply({.remove_bodies = {1, 2, 3}});
  CHECK((solver.plan().phases.empty() || variant.method == SolverMethod::vertex_block));
  CHECK(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
}

// Would catch a body that dies bit by bit and is taken for alive.
TEST_CASE("bodies: one is alive while any of it is", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({1, 1, 1}, 4e-3), testing::kSprings);
  Solver solver(scene, testing::small_steps());
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    CHECK(solver.tissue().is_body_alive(0));
    solver.tissue().apply({.remove_tets = {t}});
  }
  CHECK(!solver.tissue().is_body_alive(0));
  CHECK_THROWS_AS(static_cast<void>(solver.tissue().is_body_alive(1)), InvalidArgument);
  CHECK_THROWS_WITH(solver.tissue().apply({.remove_bodies = {0}}),
                    ContainsSubstring("body 0 was removed before"));
}

// Would catch a view that takes another body's tetrahedra for its own, or misses those of its own.
TEST_CASE("bodies: surfaces and pieces follow those that come and go", "[property]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  std::vector<LiveSurface> surfaces;
  for (Index b = 0; b < 3; ++b) {
    surfaces.emplace_back(solver.tissue(), b);
  }
  LivePieces pieces(solver.tissue());
  const auto check_views = [&] {
    for (std::size_t s = 0; s < surfaces.size(); ++s) {
      const Index body = s < 3 ? static_cast<Index>(s) : static_cast<Index>(2 * s - 3);
      std::vector<Triangle> shown, expected;
      for (const Triangle& triangle : surfaces[s].triangles()) {
        if (triangle != LiveSurface::kEmptyTriangle) {
          shown.push_back(triangle);
        }
      }
      for (const BoundaryTriangle& triangle : find_live_boundary(solver.tissue(), body)) {
        expected.push_back(triangle.vertices);
      }
      for (std::vector<Triangle>* triangles : {&shown, &expected}) {
        for (Triangle& triangle : *triangles) {
          std::rotate(triangle.begin(), std::ranges::min_element(triangle), triangle.end());
        }
        std::ranges::sort(*triangles);
      }
      REQUIRE(shown == expected);
    }
    const LivePieces fresh(solver.tissue());
    std::vector<std::array<Index, 3>> a, b;
    for (Index i = 0; i < pieces.count(); ++i) {
      if (pieces.tet_count(i) > 0) {
        a.push_back({pieces.tets(i)[0], pieces.tet_count(i), pieces.body(i)});
        REQUIRE(pieces.is_anchored(i) == fresh.is_anchored(fresh.piece_of(a.back()[0])));
      }
    }
    for (Index i = 0; i < fresh.count(); ++i) {
      b.push_back({fresh.tets(i)[0], fresh.tet_count(i), fresh.body(i)});
    }
    std::ranges::sort(a);
    std::ranges::sort(b);
    REQUIRE(a == b);
  };
  for (Index round = 0; round < 6; ++round) {
    INFO("round " << round);
    TopologyEdit edit{.new_bodies = make_guests(ProjectionMode::compliance, std::to_string(round))};
    if (round < 4) {
      edit.remove_tets = {3 * round, 3 * round + 1};
    } else if (round == 4) {
      edit.remove_bodies = {0, 5};
    }
    solver.tissue().apply(edit);
    check_views();
    solver.tissue().undo();
    check_views();
    solver.tissue().apply(edit);
    CHECK(pieces.count() - pieces.first_freed() >= 2);
    if (round == 0) {  // of clot and swab
      surfaces.emplace_back(solver.tissue(), 3);
      surfaces.emplace_back(solver.tissue(), 5);
    }
    check_views();
    const Index vertex =
        solver.tissue().body(static_cast<Index>(solver.tissue().bodies().size()) - 1).first_vertex;
    for (const Index v : {vertex + 20 + round, solver.tissue().body(1).first_vertex + round}) {
      solver.tissue().apply(testing::part_vertex(solver, v, round));
      check_views();
    }
  }
}

TEST_CASE("bodies: what does not fit is refused by name and changes nothing", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto mode = GENERATE(ProjectionMode::compliance, ProjectionMode::fraction);
  if (method == SolverMethod::vertex_block && mode == ProjectionMode::fraction) {
    return;
  }
  const Scene scene = testing::make_eventful_scene(mode, 0);
  Solver solver(scene, testing::small_steps(
                           {.method = method, .mode = mode, .executor = executor::serial()}));
  solver.tissue().apply({.remove_bodies = {1}});
  const auto refuse = [&](const TopologyEdit& edit, const std::string& why) {
    const std::uint64_t before = digest_of(inspect(solver));
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(why));
    CHECK(digest_of(inspect(solver)) == before);
  };
  const TetMesh box = testing::make_box({1, 1, 1}, 4e-3);
  const auto scene_of = [&](const std::string& name, const Material& material = testing::kSprings) {
    Scene bodies;
    bodies.add_body(name, box, material);
    return bodies;
  };
  const Material soft = elastic_material(box, 1000, 1e4);
  refuse({.new_bodies = scene_of("block", soft)}, "there is a body named 'block' already");
  refuse({.new_bodies = scene_of("tube", soft)}, "there is a body named 'tube' already");
  if (mode == ProjectionMode::fraction) {
    refuse({.new_bodies = scene_of("solid 2", {.model = ElasticModel::neo_hookean})},
           "body 'solid 2' is Neo-Hookean");
  }
  if (method == SolverMethod::vertex_block) {
    refuse({.new_bodies = scene_of("rigid")}, "body 'rigid': stretch compliance is 0");
  }
  refuse({.remove_bodies = {3}}, "body 3 does not exist");
  refuse({.remove_bodies = {-1}}, "body -1 does not exist");
  refuse({.remove_bodies = {1}}, "body 1 was removed before");
  refuse({.remove_bodies = {0, 2, 0}}, "body 0 is listed twice");
  refuse({.remove_tets = {4}, .remove_bodies = {0}},
         "tet 4 is of body 'block', which the same edit removes");
  TopologyEdit edit = testing::part_vertex(solver, 5, 0);
  edit.remove_bodies = {0};
  refuse(edit, "is of body 'block', which the same edit removes");
  edit = testing::split_edge(solver, solver.tissue().tet_edges(0)[0], 0.5F);
  edit.remove_bodies = {0};
  refuse(edit, "is of body 'block', which the same edit removes");
  const Index other = scene.body(2).first_vertex;
  refuse({.remove_bodies = {0}, .new_links = {{5, other, 0, {1, 1}}}},
         "refers to vertex 5, which has no tissue left");
  edit = {.new_links = {{5, solver.vertex_count() + box.vertex_count(), 0, {1, 1}}},
          .new_bodies = scene_of("clot", soft)};
  refuse(edit, "refers to vertex");
  edit.new_links[0].second -= 1;
  CHECK_NOTHROW(solver.tissue().apply(edit));
}

}  // namespace pbdsurg
