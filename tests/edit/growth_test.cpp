// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/plan_checks.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::is_plan_valid;
using testing::kEventfulTimeStep;
using testing::Variant;

std::vector<Link> random_links(const Solver& solver, std::uint64_t seed, int count) {
  std::vector<Link> links;
  for (int i = 0; i < count; ++i) {
    Index ends[2];
    for (int k = 0; k < 2; ++k) {
      ends[k] = static_cast<Index>(random_bits(seed, i, k) % solver.vertex_count());
    }
    if (ends[0] != ends[1] && solver.tissue().has_tissue(ends[0]) &&
        solver.tissue().has_tissue(ends[1])) {
      links.push_back({ends[0], ends[1], 0.01F, {0.3F, 1e-2F}});
    }
  }
  return links;
}

// A nested plan of several domains.
Scene make_large_scene() {
  const TetMesh mesh = testing::make_box({28, 21, 12}, 4e-3, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  return scene;
}

}  // namespace

// Would catch a new link in a colour that is taken at one of its vertices, or of one domain alone;
// and a plan without it.
TEST_CASE("growth: a link that comes later is projected, and colours stay valid", "[property]") {
  const bool is_nested = GENERATE(false, true);
  const Variant variant =
      is_nested ? Variant{.composition = PlanComposition::nested}
                : GENERATE(Variant{}, Variant{.composition = PlanComposition::joint},
                           Variant{.mode = ProjectionMode::fraction, .max_colors = 9});
  const Scene scene =
      is_nested ? make_large_scene() : testing::make_eventful_scene(variant.mode, 0);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  Solver solver(scene, options);
  const SolverData& data = inspect(solver);
  REQUIRE((!is_nested || data.sets.domain_counts.size() > 1));
  REQUIRE(is_plan_valid(data));
  for (std::uint64_t round = 0; round < 12; ++round) {
    TopologyEdit edit{.new_links = random_links(solver, round, 20)};
    if (round % 3 == 2) {
      edit.remove_tets = {static_cast<Index>(7 * round), static_cast<Index>(11 * round)};
      edit.new_links.clear();
    }
    if (round > 0) {
      edit.remove_links = {static_cast<Index>(solver.tissue().links().size()) -
                           static_cast<Index>(round)};
    }
    const TissueChange result = solver.tissue().apply(edit);
    REQUIRE(is_plan_valid(data));
    for (std::size_t i = 0; i < edit.new_links.size(); ++i) {
      const Index id = result.first_new_link + static_cast<Index>(i);
      REQUIRE(solver.tissue().is_link_alive(id));
      REQUIRE(solver.tissue().links()[id].first == edit.new_links[i].first);
      const Index group =
          data.sets.of<DistanceConstraint>().group_of(data.sets.distance_ids.of_link(id));
      const auto is_of_link = [&](const Phase& phase) {
        return phase.kind == PhaseKind::distance && phase.color == group && !phase.serial;
      };
      REQUIRE(std::ranges::count_if(solver.plan().phases, is_of_link) == 1);
    }
    REQUIRE(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
  }
}

// Would catch a link that pulls in another way for having come late.
TEST_CASE("growth: a link that comes later holds as one from the start", "[equivalence]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  Scene without;
  const TetMesh block = testing::make_box({2, 2, 2}, 4e-3);
  const Material soft = elastic_material(block, 1000, 20e3);
  without.add_body("left", block, soft);
  without.add_body("right", block, soft);
  without.fix_where(0, [](const Eigen::Vector3d&) { return true; });
  Scene with = without;
  const Link link{3, block.vertex_count() + 3, 2e-3F, {1, 1e-3F}};
  with.add_link(link);
  const SolverOptions options{
      .method = method, .substeps = 20, .damping = 20, .executor = executor};
  Solver late(without, options), early(with, options);
  late.tissue().apply({.new_links = {link}});
  for (int i = 0; i < 300; ++i) {
    late.step(5e-3F);
    early.step(5e-3F);
  }
  const auto a = late.positions();
  const auto b = early.positions();
  double farthest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    farthest = std::max(farthest, double{(a[v] - b[v]).norm()});
  }
  CHECK(farthest < 2e-5);  // m
  CHECK((a[3] - a[block.vertex_count() + 3]).norm() < 3e-3F);
}

// Would catch what growth leaves behind when it is taken back: ids, colours, phases, rows.
TEST_CASE("growth: undo leaves no trace of new links", "[property]") {
  const Variant variant = GENERATE(
      Variant{}, Variant{.composition = PlanComposition::joint},
      Variant{.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
      Variant{.max_colors = 5}, Variant{.method = SolverMethod::vertex_block},
      Variant{.method = SolverMethod::vertex_block, .damping = 0.01F},
      Variant{.method = SolverMethod::vertex_block, .coarse_correction = CoarseCorrection::on});
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  Solver solver(scene, options), unedited(scene, options);
  for (std::uint64_t round = 0; round < 20; ++round) {
    INFO("round " << round);
    if (round % 4 == 3) {
      const auto links = random_links(solver, 100 + round, 5);
      solver.tissue().apply({.new_links = links});
      unedited.tissue().apply({.new_links = links});
    }
    solver.step(kEventfulTimeStep);
    unedited.step(kEventfulTimeStep);
    const std::uint64_t before = digest_of(inspect(solver));
    TopologyEdit edit = testing::eventful_edit(solver, static_cast<Index>(round));
    for (const Link& link : random_links(solver, round, 50)) {
      const auto is_end = [&](Index t) {
        return std::ranges::count(solver.tissue().tets()[t], link.first) > 0 ||
               std::ranges::count(solver.tissue().tets()[t], link.second) > 0;
      };
      if (std::ranges::none_of(edit.remove_tets, is_end)) {
        edit.new_links.push_back(link);
      }
    }
    edit.remove_links = {static_cast<Index>(round)};
    solver.tissue().apply(edit);
    REQUIRE(digest_of(inspect(solver)) != before);
    solver.tissue().undo();
    REQUIRE(digest_of(inspect(solver)) == before);
    solver.step(kEventfulTimeStep);
    unedited.step(kEventfulTimeStep);
    REQUIRE(solver.state_hash() == unedited.state_hash());
  }
}

TEST_CASE("growth: a bad link is refused by name and changes nothing", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, 4e-3);
  scene.add_body("block", block, elastic_material(block, 1000, 20e3));
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Solver solver(scene, {.method = method});
  TopologyEdit corner;  // the whole of a vertex
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    if (std::ranges::count(solver.tissue().tets()[t], 0) > 0) {
      corner.remove_tets.push_back(t);
    }
  }
  const auto refuse = [&](TopologyEdit edit, const std::string& why) {
    const std::uint64_t before = digest_of(inspect(solver));
    edit.new_links.insert(edit.new_links.begin(), {1, 5, 0, {1, 1e-3F}});
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(why));
    CHECK(digest_of(inspect(solver)) == before);
  };
  const Index count = solver.vertex_count();
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refuse({.new_links = {{4, 4, 0, {}}}}, "link 1 joins vertex 4 to itself");
  refuse({.new_links = {{4, count, 0, {}}}}, "link 1 refers to vertex 27");
  refuse({.new_links = {{-1, 4, 0, {}}}}, "link 1 refers to vertex -1");
  refuse({.new_links = {{3, 4, nan, {1, 1}}}}, "link 1 has rest length nan");
  refuse({.new_links = {{3, 4, -1, {1, 1}}}}, "link 1 has rest length -1");
  refuse({.new_links = {{3, 4, 0, {2, 0.1F}}}}, "link 1: fraction is 2");
  refuse({.new_links = {{3, 4, 0, {1, -1}}}}, "link 1: compliance is -1");
  refuse({.remove_tets = corner.remove_tets, .new_links = {{0, 4, 0, {1, 1}}}},
         "link 1 refers to vertex 0, which has no tissue left");
  solver.tissue().apply(corner);
  refuse({.new_links = {{0, 4, 0, {1, 1}}}}, "link 1 refers to vertex 0, which has no tissue left");
}

}  // namespace pbdsurg
