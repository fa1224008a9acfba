// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_digest.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::kEventfulTimeStep;
using testing::Variant;

// Removes tetrahedra around some vertices, so that these lose all, and links, changes rest values,
// fixes vertices and lets others go.
TopologyEdit random_edit(const Solver& solver, std::uint64_t seed) {
  TopologyEdit edit = testing::eventful_edit(solver, static_cast<Index>(3 * (seed % 30)));
  const auto pick = [&](std::uint64_t what, std::size_t count) {
    return static_cast<Index>(random_bits(seed, what) % count);
  };
  const Index gone[] = {pick(0, solver.vertex_count()), pick(1, solver.vertex_count())};
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    const auto is_at = [&](Index v) {
      return std::ranges::count(solver.tissue().tets()[t], v) > 0;
    };
    if (solver.tissue().is_tet_alive(t) &&
        (is_at(gone[0]) || is_at(gone[1]) || random_bits(seed, 100 + t) % 40 == 0)) {
      edit.remove_tets.push_back(t);
    }
  }
  const Index link = pick(2, solver.tissue().links().size());
  if (solver.tissue().is_link_alive(link)) {
    edit.remove_links.push_back(link);
  }
  const Index drawn = pick(3, solver.tissue().links().size());
  if (drawn != link && solver.tissue().is_link_alive(drawn)) {
    edit.link_lengths.push_back({drawn, 2e-3F});
  }
  std::ranges::sort(edit.remove_tets);
  const auto is_removed = [&](Index t) { return std::ranges::binary_search(edit.remove_tets, t); };
  for (Index t = static_cast<Index>(seed % 5);
       t < static_cast<Index>(solver.tissue().tets().size()); t += 5) {
    const Body& body = solver.tissue().body(solver.tissue().body_of_tet(t));
    if (solver.tissue().is_tet_alive(t) && body.material.model == ElasticModel::neo_hookean) {
      edit.stiffnesses.push_back({t, 1.5F});
    }
  }
  for (Index v = static_cast<Index>(seed % 11); v < solver.vertex_count(); v += 11) {
    if (solver.tissue().has_tissue(v) &&
        std::ranges::none_of(solver.tissue().tets_at(v), is_removed)) {
      (solver.tissue().is_fixed(v) ? edit.unfix_vertices : edit.fix_vertices).push_back(v);
    }
  }
  return edit;
}

std::vector<Variant> undo_variants() {
  return {{},
          {.damping = 0.01F},
          {.composition = PlanComposition::joint},
          {.composition = PlanComposition::joint, .max_colors = 9},
          {.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
          {.mode = ProjectionMode::fraction, .max_colors = 9},
          {.method = SolverMethod::vertex_block},
          {.method = SolverMethod::vertex_block, .damping = 0.01F},
          {.method = SolverMethod::vertex_block, .coarse_correction = CoarseCorrection::on}};
}

}  // namespace

// Would catch anything that an edit changes and undo does not put back to where it was: slots,
// owners, masses, motion, grasps, rows; and what shows only in steps.
TEST_CASE("undo: all is as if the edit had never been, bit for bit", "[property]") {
  const Variant variant = GENERATE(from_range(undo_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.copies = GENERATE(1, 3);
  options.executor = executor::serial();
  Solver solver(scene, options), unedited(scene, options);
  for (Solver* each : {&solver, &unedited}) {
    for (Index copy = 0; copy < options.copies; ++copy) {
      auto velocities = each->velocities(copy);
      for (std::size_t v = 0; v < velocities.size(); ++v) {
        velocities[v].y() = 1e-2F * static_cast<float>(copy + v % 5);
      }
      each->write_velocities(velocities, copy);
    }
    each->add_tool({}, ToolPose::Identity());
    each->add_tool({}, ToolPose::Identity());
  }
  for (std::uint64_t round = 0; round < 30; ++round) {
    INFO("round " << round);
    for (Solver* each : {&solver, &unedited}) {
      if (round % 3 == 0) {  // what stays is edited, too
        each->tissue().apply(random_edit(*each, 1000 + round));
      }
      for (Index tool = 0; tool < 2; ++tool) {
        std::vector<Index> held;
        for (Index v = tool; v < each->vertex_count(); v += 4 + tool) {
          if (each->tissue().has_tissue(v)) {
            held.push_back(v);
          }
        }
        each->release(ToolId(tool), options.copies - 1);
        each->grasp(ToolId(tool), held, 1e-4F, options.copies - 1);
      }
      each->step(kEventfulTimeStep);
    }
    const std::uint64_t before = digest_of(inspect(solver));
    const std::uint64_t version = solver.tissue().version();
    REQUIRE(before == digest_of(inspect(unedited)));

    const TopologyEdit edit = random_edit(solver, round);
    solver.tissue().apply(edit);
    REQUIRE(digest_of(inspect(solver)) != before);
    REQUIRE(solver.tissue().version() > version);
    solver.tissue().undo();
    REQUIRE(digest_of(inspect(solver)) == before);
    REQUIRE(solver.tissue().version() == version);
    solver.step(kEventfulTimeStep);
    unedited.step(kEventfulTimeStep);
    REQUIRE(solver.state_hash() == unedited.state_hash());
  }
}

// Would catch workers that take rows of their own for current because the version of the tissue is
// what it was: an undo leaves vertices in other blocks.
TEST_CASE("undo: copies with damping go on as if the edit had never been", "[property]") {
  Material material = testing::neo_hookean(2e4F, 0.45F);
  material.damping = 2e-3F;
  const Scene scene = testing::make_bar(material);
  SolverOptions options = testing::vertex_options(2, 2);
  options.copies = 4;
  options.executor = executor::threads(2);
  Solver solver(scene, options), unedited(scene, options);
  for (std::uint64_t round = 0; round < 6; ++round) {
    testing::run(solver, 3, 2e-3F);
    testing::run(unedited, 3, 2e-3F);
    solver.tissue().apply(testing::part_vertex(solver, static_cast<Index>(20 + 7 * round), round));
    solver.tissue().undo();
    solver.step(2e-3F);
    unedited.step(2e-3F);
    for (Index copy = 0; copy < options.copies; ++copy) {
      CHECK(solver.state_hash(copy) == unedited.state_hash(copy));
    }
  }
}

// Would catch tissue that comes back elsewhere than where it went, or pulled along by what moved.
TEST_CASE("undo: after some steps, what had gone is where it went, and the rest stays", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({3, 2, 2}, 4e-3, 0.1));
  Solver solver(scene, {.executor = executor::serial()});
  solver.step(kEventfulTimeStep);
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()) / 2; ++t) {
    edit.remove_tets.push_back(t);
  }
  const auto at_edit = solver.positions();
  const auto speeds = solver.velocities();
  const TissueChange result = solver.tissue().apply(edit);
  REQUIRE(!result.emptied_vertices.empty());
  solver.step(kEventfulTimeStep);
  auto expected = solver.positions();
  auto expected_speeds = solver.velocities();
  CHECK(expected != at_edit);
  for (const Index v : result.emptied_vertices) {
    expected[v] = at_edit[v];
    expected_speeds[v] = speeds[v];
  }
  solver.tissue().undo();
  CHECK(solver.positions() == expected);
  CHECK(solver.velocities() == expected_speeds);
}

// Would catch a grasp that comes back after the user has let go.
TEST_CASE("undo: what a tool gave up since the edit stays given up", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({1, 1, 1}, 4e-3));
  Solver solver(scene);
  for (Index tool = 0; tool < 2; ++tool) {
    solver.add_tool({}, ToolPose::Identity());
    solver.grasp(ToolId(tool), std::array{tool, tool + 2});
  }
  TopologyEdit edit;
  edit.remove_tets = {0, 1, 2, 3, 4, 5};
  solver.tissue().apply(edit);
  solver.release(ToolId{0});
  solver.tissue().undo();
  CHECK(inspect(solver).tools[0].attachments.empty());
  CHECK(inspect(solver).tools[1].attachments.size() == 2);
}

// Would catch a snapshot of another topology that is taken for one of this.
TEST_CASE("undo: snapshots follow the topology that they are of", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3));
  Solver solver(scene);
  const Snapshot whole = solver.snapshot();
  const TopologyEdit edit{.remove_tets = {3}};
  solver.tissue().apply(edit);
  const Snapshot cut = solver.snapshot();
  CHECK_THROWS_AS(solver.restore(whole), InvalidArgument);
  solver.tissue().undo();
  CHECK_NOTHROW(solver.restore(whole));
  CHECK_THROWS_AS(solver.restore(cut), InvalidArgument);
  solver.tissue().apply({.remove_tets = {4}});
  CHECK_THROWS_AS(solver.restore(cut), InvalidArgument);
}

// Would catch an edit that is taken back twice, or under another: both corrupt the state.
TEST_CASE("undo: only the last edit is taken back, once", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3));
  Solver solver(scene);
  const TopologyEdit first{.remove_tets = {3}}, second{.remove_tets = {4}};
  const auto refuse = [&] {
    const std::uint64_t before = digest_of(inspect(solver));
    const std::uint64_t version = solver.tissue().version();
    CHECK_THROWS_WITH(solver.tissue().undo(), ContainsSubstring("there is no edit to undo"));
    CHECK(digest_of(inspect(solver)) == before);
    CHECK(solver.tissue().version() == version);
  };
  refuse();
  const std::uint64_t of_first = solver.tissue().apply(first).version;
  CHECK_THROWS_AS(solver.tissue().apply(first),
                  InvalidArgument);  // refused: the last is still the last
  solver.tissue().undo();
  CHECK(solver.tissue().is_tet_alive(3));
  refuse();
  CHECK(solver.tissue().apply(first).version != of_first);
  solver.tissue().apply(second);
  solver.tissue().undo();
  CHECK(solver.tissue().is_tet_alive(4));
  refuse();  // one edit is kept in mind
  CHECK(!solver.tissue().is_tet_alive(3));
}

// Would catch followers that are not told, that find the tissue as after the edit, or another edit.
TEST_CASE("undo: followers hear of it, each after those that it may read", "[unit]") {
  struct Watcher : Follower {
    std::vector<int>* order = nullptr;
    int name = 0;
    void follow(const Tissue&, const TissueChange&) noexcept override {}
    void undo(const Tissue& tissue, const TissueChange& change) noexcept override {
      if (tissue.is_tet_alive(change.edit.remove_tets[0]) &&
          change.removed_tets == change.edit.remove_tets) {
        order->push_back(name);
      }
    }
    void renumber(const Tissue&, const Renumbering&) noexcept override {}
  };
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, 4e-3));
  Solver solver(scene);
  std::vector<int> order;
  Watcher first, second;
  first.order = second.order = &order;
  second.name = 1;
  solver.tissue().add_follower(second, FollowerRank::surgery);
  solver.tissue().add_follower(first, FollowerRank::view);
  solver.tissue().apply({.remove_tets = {7}});
  solver.tissue().undo();
  CHECK(order == std::vector{0, 1});
}

}  // namespace pbdsurg
