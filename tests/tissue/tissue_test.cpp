// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/tissue/tissue.h"

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/library.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/live_model.h"
#include "tests/support/model_difference.h"
#include "tests/support/plan_checks.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::kEventfulEdge;
using testing::Variant;

constexpr float kTimeStep = testing::kEventfulTimeStep;

// Removals, parted vertices, split edges, bodies that come and go, links.
TopologyEdit make_edit(const Solver& solver, Index round) {
  switch (round % 5) {
    case 0: {
      Index edge = 11 * round;
      while (!solver.tissue().is_edge_alive(edge)) {
        ++edge;
      }
      return testing::split_edge(solver, edge, 0.4F);
    }
    case 1:
      return testing::part_vertex(solver, 60 + 4 * round, 7);
    case 2: {
      TopologyEdit edit{.remove_links = {round}};
      for (Index t = 5 * round; edit.remove_tets.size() < 3; ++t) {
        if (solver.tissue().is_tet_alive(t)) {
          edit.remove_tets.push_back(t);
        }
      }
      return edit;
    }
    case 3: {
      TopologyEdit edit;
      const TetMesh box = testing::make_box({2, 2, 2}, kEventfulEdge, 0.1, 5);
      edit.new_bodies.add_body("guest " + std::to_string(round), box,
                               elastic_material(box, 900, 1e4));
      edit.new_links = {{0, solver.vertex_count(), 0.01F, {0.5F, 1e-3F}}};
      return edit;
    }
    default:
      return {.remove_bodies = {round / 5 + 1}};
  }
}

}  // namespace

// Would catch a follower that takes the other's part, or state that both share.
TEST_CASE("tissue: two solvers follow one, each as if it were alone", "[equivalence]") {
  const Variant other_variant =
      GENERATE(Variant{}, Variant{.composition = PlanComposition::joint},
               Variant{.method = SolverMethod::vertex_block, .damping = 0.01F});
  const Scene scene =
      testing::make_eventful_scene(ProjectionMode::compliance, other_variant.damping);
  const SolverOptions options = testing::serial_options({});
  const SolverOptions other_options = testing::serial_options(other_variant);
  Tissue tissue(scene);
  Solver one(tissue, options), other(tissue, other_options);
  Solver one_alone(scene, options), other_alone(scene, other_options);
  const std::array all{&one, &other, &one_alone, &other_alone};
  one.add_tool({}, ToolPose::Identity());
  one_alone.add_tool({}, ToolPose::Identity());
  for (Solver* const each : {&one, &one_alone}) {
    each->grasp(ToolId{0}, std::array{Index{30}, Index{31}}, 1e-4F);
  }
  for (Index round = 0; round < 10; ++round) {
    INFO("round " << round);
    const TopologyEdit edit = make_edit(one, round);
    for (Solver* const each : {&one, &one_alone, &other_alone}) {
      each->tissue().apply(edit);
      if (round % 3 == 0) {
        each->tissue().undo();
        each->tissue().apply(edit);
      }
    }
    for (Solver* const each : all) {
      REQUIRE(each->step(kTimeStep).non_finite_vertices == 0);
    }
    REQUIRE(digest_of(inspect(one)) == digest_of(inspect(one_alone)));
    REQUIRE(digest_of(inspect(other)) == digest_of(inspect(other_alone)));
  }
  CHECK(one.state_hash() != other.state_hash());  // they do not move alike
  CHECK(&one.tissue() == &tissue);
  CHECK(&other.tissue() == &tissue);
}

// Would catch an edit that one solver's rules refuse and another has followed.
TEST_CASE("tissue: what one solver refuses, none follows", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, kEventfulEdge);
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  Tissue tissue(scene);
  Solver by_constraints(tissue, testing::small_steps({.executor = executor::serial()}));
  Solver by_vertices(tissue, testing::small_steps({.method = SolverMethod::vertex_block,
                                                   .executor = executor::serial()}));
  const std::uint64_t before = digest_of(inspect(by_constraints));
  TopologyEdit rigid;
  rigid.new_bodies.add_body("rigid", block, testing::kSprings);  // springs of compliance 0
  CHECK_THROWS_WITH(tissue.apply(rigid), ContainsSubstring("the vertex-block method needs > 0"));
  CHECK(digest_of(inspect(by_constraints)) == before);
  CHECK(tissue.bodies().size() == 1);
  { const Solver gone = std::move(by_vertices); }
  CHECK_NOTHROW(tissue.apply(rigid));  // now that nobody minds
  CHECK(by_constraints.step(kTimeStep).non_finite_vertices == 0);
}

// Would catch a state put into tissue whose ids mean something else.
TEST_CASE("tissue: a snapshot of another, or of another version, is refused", "[unit]") {
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  const SolverOptions options = testing::serial_options({});
  Tissue tissue(scene);
  Solver solver(tissue, options), shares(tissue, options), other(scene, options);
  solver.step(kTimeStep);
  const Snapshot snapshot = solver.snapshot();
  CHECK(snapshot.tissue == tissue.identified_version());
  const std::uint64_t untouched = other.state_hash();
  CHECK_THROWS_AS(other.restore(snapshot), InvalidArgument);
  CHECK(other.state_hash() == untouched);
  other.tissue().apply({});
  tissue.apply({});
  REQUIRE(other.tissue().version() == tissue.version());
  CHECK_THROWS_AS(other.restore(solver.snapshot()), InvalidArgument);
  CHECK_THROWS_AS(solver.restore(snapshot), InvalidArgument);
  tissue.undo();
  CHECK_NOTHROW(solver.restore(snapshot));
  CHECK(shares.tissue().identified_version() == snapshot.tissue);
}

// Would catch a solver that takes tissue as the scene had it: with what has gone, without what
// came, with the numbers of what was divided, or where tissue lay before.
TEST_CASE("tissue: a solver may be made of what edits have left, at rest", "[property]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  if (method == SolverMethod::vertex_block && composition == PlanComposition::nested) {
    return;
  }
  const Scene scene = testing::make_eventful_scene(ProjectionMode::compliance, 0);
  SolverOptions options = testing::serial_options({.method = method});
  options.composition = composition;
  options.copies = 2;
  Solver early(scene, options);
  Tissue& tissue = early.tissue();
  testing::LiveModel model(scene);
  const auto apply = [&](const TopologyEdit& edit) {
    model.apply(early, edit);
    tissue.apply(edit);
  };
  for (Index round = 0; round < 5; ++round) {
    apply(make_edit(early, round));
    early.step(kTimeStep);  // which does not move the rest positions
  }
  Solver late(tissue, options);
  CHECK(testing::difference(model, late) == "");
  CHECK(testing::is_plan_valid(inspect(late)));
  for (Index copy = 0; copy < 2; ++copy) {
    const std::vector<Eigen::Vector3f> x = late.positions(copy);
    REQUIRE(x.size() == tissue.rest_positions().size());
    for (std::size_t v = 0; v < x.size(); ++v) {
      REQUIRE(x[v] == tissue.rest_positions()[v].cast<float>());
      REQUIRE((tissue.rest_positions()[v] - model.points[v]).norm() < 1e-6 * kEventfulEdge);
      REQUIRE(late.velocities(copy)[v].isZero(0));
    }
  }
  // from then on it follows
  for (Index round = 5; round < 10; ++round) {
    apply(make_edit(early, round));
    REQUIRE(testing::difference(model, late) == "");
    REQUIRE(testing::difference(model, early) == "");
    REQUIRE(late.step(kTimeStep).non_finite_vertices == 0);
  }
  const std::uint64_t before = digest_of(inspect(late));
  tissue.apply(make_edit(early, 10));
  CHECK(digest_of(inspect(late)) != before);
  tissue.undo();
  CHECK(digest_of(inspect(late)) == before);
}

// Would catch a plan of tetrahedra that own edges which no longer lie as a scene's do.
TEST_CASE("tissue: a joint plan is refused once it was edited", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, kEventfulEdge);
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  Tissue tissue(scene);
  const SolverOptions joint =
      testing::small_steps({.executor = executor::serial(), .composition = PlanComposition::joint});
  tissue.apply({.remove_tets = {3}});
  CHECK_THROWS_WITH(Solver(tissue, joint),
                    ContainsSubstring("a joint plan is of tissue as a scene"));
  tissue.undo();
  CHECK_NOTHROW(Solver(tissue, joint));
}

// Would catch the volumes, conductances and properties of what was divided, or of what has gone.
TEST_CASE("tissue: a heat field made after a cut conducts in what is left", "[property]") {
  const TetMesh mesh = testing::make_box({5, 4, 3}, kEventfulEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  scene.add_body("beside", testing::make_box({1, 1, 1}, kEventfulEdge), testing::kSprings);
  Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  Tissue& tissue = solver.tissue();
  const ThermalProperties& liver = tissues::liver().heat;
  const ThermalBody body{0, liver};
  const HeatField early(tissue, {&body, 1});
  testing::LiveModel model(scene);
  const auto follow = [&](const TopologyEdit& edit) {
    model.apply(solver, edit);
    tissue.apply(edit);
  };
  const float z = 1.4F * static_cast<float>(kEventfulEdge);
  const std::array instants{BladeEdge{{-1, -1, z}, {1, -1, z}}, BladeEdge{{-1, 1, z}, {1, 1, z}}};
  follow(plan_cut(solver, sweep_blade(instants)).edit);
  REQUIRE(tissue.vertex_count() > scene.vertex_count() + 20);
  follow({.remove_tets = {1, 2, 3}});
  const HeatField late(tissue, {&body, 1});
  double volume = 0;
  for (Index t = 0; t < late.mesh().tet_count(); ++t) {
    CHECK(late.mesh().tissue_of_element(t) == early.mesh().tissue_of_element(t));
    CHECK(late.mesh().is_alive(t) == early.mesh().is_alive(t));
    CHECK(late.mesh().volume(t) == early.mesh().volume(t));
    CHECK(late.mesh().edge_coefficients(t) == early.mesh().edge_coefficients(t));
    volume += late.mesh().is_alive(t) ? late.mesh().volume(t) : 0;
  }
  double expected = total_volume(mesh);
  for (const Index t : {1, 2, 3}) {
    expected -= tet_volume(model.points, model.tets[t]);
  }
  CHECK(volume == Approx(expected).epsilon(1e-6));
  CHECK(testing::difference(model, late, liver) == "");
  follow({.remove_tets = {10, 11}});
  CHECK(testing::difference(model, late, liver) == "");
}

// Would catch a field of a copy that misses what its tissue does.
TEST_CASE("tissue: a heat field of a copied mesh follows", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({3, 2, 2}, kEventfulEdge, 0.1), testing::kSprings);
  Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  const ThermalProperties& liver = tissues::liver().heat;
  const ThermalBody body{0, liver};
  const ThermalMesh mesh(solver.tissue(), {&body, 1});
  const HeatField field(mesh);
  testing::LiveModel model(scene);
  for (const TopologyEdit& edit :
       {testing::split_edge(solver, 3, 0.5F), TopologyEdit{.remove_tets = {7}}}) {
    model.apply(solver, edit);
    solver.tissue().apply(edit);
    CHECK(testing::difference(model, field, liver) == "");
  }
}

// Would catch a contact, links or heat that a cautery takes from the scene in place of the tissue.
TEST_CASE("tissue: a cautery made after a cut burns as one that followed it", "[equivalence]") {
  constexpr double kFine = 1e-3;  // m
  const TetMesh mesh = testing::make_box({8, 8, 4}, kFine, 0.05);
  Scene scene;
  scene.add_body("fat", mesh);
  scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.z() < 0.1 * kFine; });
  const ThermalBody body{0, tissues::fat().heat};
  struct World {
    World(const Scene& scene) : solver(scene, {.damping = 20, .executor = executor::serial()}) {}
    Solver solver;
    std::vector<Cautery> cautery{};
  };
  World followed(scene), late(scene);
  followed.cautery.emplace_back(followed.solver.tissue(), std::span(&body, 1));
  for (World* const each : {&followed, &late}) {
    const float x = 4.3e-3F;
    const std::array instants{BladeEdge{{x, -1, 2e-3F}, {x, 1, 2e-3F}},
                              BladeEdge{{x, -1, 1}, {x, 1, 1}}};
    const CutPlan plan = plan_cut(each->solver, sweep_blade(instants));
    REQUIRE(plan.edit.new_tets.size() > 20);
    each->solver.tissue().apply(plan.edit);
    each->solver.tissue().apply({.remove_tets = {2, 3}});
  }
  late.cautery.emplace_back(late.solver.tissue(), std::span(&body, 1));
  const Eigen::Vector3f tip(4e-3F, 4e-3F, 4.2e-3F);
  Index removed = 0;
  for (int i = 0; i < 60; ++i) {
    const CauteryReport a =
        followed.cautery[0].update(followed.solver, {tip, tip}, cut_settings(40), 5e-3);
    const CauteryReport b = late.cautery[0].update(late.solver, {tip, tip}, cut_settings(40), 5e-3);
    CHECK(a.contact_vertices == b.contact_vertices);
    CHECK(a.contact_area == Approx(b.contact_area));
    CHECK(a.energy == Approx(b.energy));
    CHECK(a.hottest == Approx(b.hottest));
    CHECK(a.edit.removed_tets == b.edit.removed_tets);
    removed += static_cast<Index>(b.edit.removed_tets.size());
    followed.solver.step(5e-3F);
    late.solver.step(5e-3F);
  }
  CHECK(removed > 5);
  CHECK(late.solver.tissue().version() == followed.solver.tissue().version());
}

}  // namespace pbdsurg
