// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_boundary.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/soft_sweep.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::inspect;
using testing::kSoftEdge;

Scene make_two_blocks() {
  Scene scene;
  const TetMesh block = testing::make_box({4, 3, 3}, kSoftEdge, 0.1);
  scene.add_body("left", block, testing::kSprings);
  scene.add_body("right", block, testing::kSprings);
  for (Index v = 0; v < block.vertex_count(); ++v) {
    scene.add_link({v, block.vertex_count() + v, 1e-3F, {}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  return scene;
}

std::vector<Index> shuffled(Index count, std::uint64_t seed) {
  std::vector<Index> order(count);
  for (Index i = 0; i < count; ++i) {
    order[i] = i;
  }
  std::sort(order.begin(), order.end(),
            [&](Index a, Index b) { return random_bits(seed, a) < random_bits(seed, b); });
  return order;
}

}  // namespace

// Would catch any constraint that survives its tissue, or tissue that loses a constraint too many.
TEST_CASE("topology edit: what is left equals what the live tetrahedra say", "[property]") {
  const Scene scene = make_two_blocks();
  Solver solver(scene, testing::small_steps({.composition = GENERATE(PlanComposition::separate,
                                                                     PlanComposition::joint)}));
  const Index tet_count = static_cast<Index>(solver.tissue().tets().size());
  const std::vector<Index> order = shuffled(tet_count, GENERATE(1, 2, 3));
  std::size_t next = 0;
  while (next < order.size()) {
    TopologyEdit edit;
    for (int i = 0; i < 29 && next < order.size(); ++i) {
      edit.remove_tets.push_back(order[next++]);
    }
    solver.tissue().apply(edit);
    CHECK(solver.step(1e-3F).non_finite_vertices == 0);

    std::vector<Tet> live;
    for (Index t = 0; t < tet_count; ++t) {
      if (solver.tissue().is_tet_alive(t)) {
        live.push_back(solver.tissue().tets()[t]);
      }
    }
    CHECK(live.size() == order.size() - next);
    const std::vector<Edge> expected_edges = find_edges(live);
    std::vector<Edge> edges;
    for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
      if (solver.tissue().is_edge_alive(e)) {
        edges.push_back(solver.tissue().edges()[e]);
      }
    }
    CHECK(edges == expected_edges);
    std::set<Index> used;
    for (const Tet& tet : live) {
      used.insert(tet.begin(), tet.end());
    }
    for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
      const Link& link = solver.tissue().links()[l];
      CHECK(solver.tissue().is_link_alive(l) ==
            (used.count(link.first) && used.count(link.second)));
    }
  }
  CHECK(find_live_boundary(solver.tissue(), 0).empty());
}

// Would catch an edge that dies with the tetrahedron that owned it, or stays where nothing projects
// it, and rest values and phases that do not follow.
TEST_CASE("topology edit: each constraint left is projected once a sweep", "[property]") {
  const ColoringOptions coloring =
      GENERATE(ColoringOptions{.repair = true}, ColoringOptions{.max_colors = 9});
  const PlanComposition composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  const Scene scene = testing::make_soft_scene();
  Solver solver(scene, testing::soft_options(coloring, composition));
  std::size_t phases = solver.plan().phases.size();
  const std::vector<Index> order = shuffled(static_cast<Index>(scene.tets().size()), 4);
  for (std::size_t next = 0; next < order.size();) {
    TopologyEdit edit;
    for (int i = 0; i < 10 && next < order.size(); ++i) {
      edit.remove_tets.push_back(order[next++]);
    }
    solver.tissue().apply(edit);
    CHECK(testing::count_error(solver, scene) < 0.5);
    CHECK(solver.plan().phases.size() <= phases);
    phases = solver.plan().phases.size();
  }
  CHECK(phases == 0);
}

// Would catch an edge handed over into a colour that touches its vertices, which a serial sweep
// does not notice and a parallel one turns into a race; and an owner that is gone.
TEST_CASE("topology edit: edges go to live tetrahedra, and colours stay valid", "[property]") {
  const Scene scene = testing::make_soft_scene();
  Solver solver(scene, testing::small_steps({.composition = PlanComposition::joint}));
  const SolverData& data = inspect(solver);
  const std::vector<Index> order = shuffled(static_cast<Index>(scene.tets().size()), 5);
  std::size_t handed_over = 0;
  for (const Index removed : order) {
    std::vector<Index> before;
    for (Index e = 0; e < static_cast<Index>(data.tissue->edges().size()); ++e) {
      before.push_back(data.sets.edge_owners[e]);
    }
    solver.tissue().apply({.remove_tets = {removed}});

    for (Index e = 0; e < static_cast<Index>(data.tissue->edges().size()); ++e) {
      const Index owner = data.sets.edge_owners[e];
      if (!data.sets.of<DistanceConstraint>().is_alive(e)) {
        continue;
      }
      if (owner == kInvalidIndex) {
        CHECK(data.tissue->edges()[e][1] < scene.body(1).first_vertex);  // of the tube
        continue;
      }
      CHECK(data.tissue->is_tet_alive(owner));
      const auto& edges = data.tissue->tet_edges()[owner];
      const auto place = std::find(edges.begin(), edges.end(), e) - edges.begin();
      REQUIRE(place < 6);
      CHECK(data.sets.of<DistanceConstraint>().group_of(e) ==
            data.sets.joint_group(data.sets.of<VolumeConstraint>().group_of(owner),
                                  static_cast<Index>(place)));
      CHECK((owner == before[e] || before[e] == removed));
      handed_over += owner != before[e];
    }
  }
  CHECK(handed_over > 100);
}

TEST_CASE("topology edit: mass goes with tissue", "[unit]") {
  // a free block that falls on a rigid grasp would pull with its weight: cut it in half, half
  // remains
  Scene scene;
  scene.add_body("block", testing::make_box({4, 4, 4}, 5e-3), testing::kSprings);
  Solver solver(scene, testing::small_steps({.substeps = 20, .damping = 30}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  std::vector<Index> top;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].y() > 0.0199) {
      top.push_back(v);
    }
  }
  solver.grasp(tool, top);
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
    const Tet& tet = scene.tets()[t];
    double middle = 0;
    for (const Index v : tet) {
      middle += scene.positions()[v].y() / 4;
    }
    if (middle < 0.01) {
      edit.remove_tets.push_back(t);
    }
  }
  REQUIRE(edit.remove_tets.size() == scene.tets().size() / 2);
  const TissueChange result = solver.tissue().apply(edit);
  CHECK(result.emptied_vertices.size() == 50);  // two of the five layers

  for (int i = 0; i < 400; ++i) {
    solver.step(5e-3F);
  }
  CHECK(solver.tool_force(tool).y() == Approx(-0.5 * 1000 * 8e-6 * 9.81).epsilon(0.02));
}

TEST_CASE("topology edit: a vertex without tissue stops and is let go", "[unit]") {
  Scene scene;
  scene.add_body("corner", testing::make_box({1, 1, 1}, kSoftEdge), testing::kSprings);
  Solver solver(scene, testing::small_steps());
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, std::vector<Index>{0});
  REQUIRE(solver.plan().phases.back().kind == PhaseKind::attachment);

  TopologyEdit edit;
  edit.remove_tets = {0, 1, 2, 3, 4, 5};
  const TissueChange result = solver.tissue().apply(edit);

  CHECK(result.emptied_vertices.size() == 8);
  CHECK(solver.plan().phases.empty());
  const auto before = solver.positions();
  solver.step(0.1F);
  CHECK(solver.positions() == before);
}

TEST_CASE("topology edit: rest values change what the solver pulls towards", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, kSoftEdge), testing::kSprings);
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.substeps = 20, .damping = 20}));
  TopologyEdit edit;
  for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    edit.rest_lengths.push_back({e, 0.8F * solver.rest_length(e)});
  }
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    edit.rest_volumes.push_back({t, 0.512F * solver.rest_volume(t)});
  }
  solver.tissue().apply(edit);
  for (int i = 0; i < 200; ++i) {
    solver.step(5e-3F);
  }

  const auto x = solver.positions();
  CHECK((x.back() - x.front()).norm() ==
        Approx(0.8 * 2 * kSoftEdge * std::sqrt(3.0)).epsilon(0.01));
}

namespace {

Scene make_neo_hookean_block() {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, kSoftEdge, 0.1),
                 {.model = ElasticModel::neo_hookean, .max_stretch = 1.5F});
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

}  // namespace

// Would catch a constraint that survives its tissue, and two of a colour at one vertex.
TEST_CASE("topology edit: neo-hookean tissue takes its constraints along", "[property]") {
  const Scene scene = make_neo_hookean_block();
  Solver solver(scene, testing::small_steps());
  const SolverData& data = inspect(solver);
  const std::vector<Index> order = shuffled(static_cast<Index>(scene.tets().size()), 5);
  for (std::size_t next = 0; next < order.size();) {
    TopologyEdit edit;
    for (int i = 0; i < 7 && next < order.size(); ++i) {
      edit.remove_tets.push_back(order[next++]);
    }
    const TissueChange result = solver.tissue().apply(edit);
    for (const Index edge : result.removed_edges) {
      CHECK_FALSE(solver.tissue().is_edge_alive(edge));
    }
    std::set<std::pair<Index, Index>> of_tets, of_edges;  // colour, vertex
    for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
      CHECK(data.sets.of<NeoHookeanConstraint>().is_alive(t) == solver.tissue().is_tet_alive(t));
      for (const Index v : scene.tets()[t]) {
        CHECK((!solver.tissue().is_tet_alive(t) ||
               of_tets.insert({data.sets.of<NeoHookeanConstraint>().group_of(t), v}).second));
      }
    }
    for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
      CHECK(data.sets.of<StrainLimitConstraint>().is_alive(e) == solver.tissue().is_edge_alive(e));
      for (const Index v : solver.tissue().edges()[e]) {
        CHECK((!solver.tissue().is_edge_alive(e) ||
               of_edges.insert({data.sets.of<StrainLimitConstraint>().group_of(e), v}).second));
      }
    }
    CHECK(solver.step(1e-3F).non_finite_vertices == 0);
  }
  CHECK(solver.plan().phases.empty());
}

TEST_CASE("topology edit: rest volumes shrink neo-hookean tissue, rest lengths are refused",
          "[unit]") {
  const Scene scene = make_neo_hookean_block();
  Solver solver(scene, testing::small_steps({.damping = 20}));
  CHECK_THROWS_WITH(solver.tissue().apply({.rest_lengths = {{3, 1e-3F}}}),
                    ContainsSubstring("edge 3 belongs to a Neo-Hookean body"));
  CHECK(solver.tissue().version() == 0);
  TopologyEdit edit;
  for (Index t = 0; t < static_cast<Index>(scene.tets().size()); ++t) {
    edit.rest_volumes.push_back({t, 0.512F * solver.rest_volume(t)});
  }
  solver.tissue().apply(edit);
  CHECK(solver.rest_volume(3) == Approx(edit.rest_volumes[3].rest_volume).epsilon(1e-5));
  StepReport report;
  for (int i = 0; i < 200; ++i) {
    report = solver.step(5e-3F);
  }
  const auto x = solver.positions();
  CHECK((x.back() - x.front()).norm() ==
        Approx(0.8 * (scene.positions().back() - scene.positions().front()).norm()).epsilon(0.001));
  CHECK(report.volume_residual < 1e-3F);
}

TEST_CASE("topology edit: a strain limit follows a changed rest length", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({1, 1, 1}, kSoftEdge),
                 {.model = ElasticModel::springs, .max_stretch = 1.5F});
  Solver solver(scene, testing::small_steps());
  const float half = 0.5F * solver.rest_length(2);
  solver.tissue().apply({.rest_lengths = {{2, half}}});
  CHECK(inspect(solver)
            .sets.of<StrainLimitConstraint>()
            .record(2)
            .parameters[StrainLimitConstraint::kLimit] == Approx(1.5 * half));
}

// Would catch limits of Neo-Hookean tissue that keep it as large as it was, or follow a tetrahedron
// that changes alone as far as if all around the edge did.
TEST_CASE("topology edit: strain limits of neo-hookean tissue follow its rest volume", "[unit]") {
  Scene scene;
  scene.add_body("solid", testing::make_box({2, 2, 2}, 4e-3, 0.1),
                 {.model = ElasticModel::neo_hookean, .max_stretch = 1.2F});
  Solver solver(scene, testing::small_steps());
  const SolverData& data = inspect(solver);
  const auto limit = [&](Index edge) {
    return data.sets.of<StrainLimitConstraint>()
        .record(edge)
        .parameters[StrainLimitConstraint::kLimit];
  };
  std::vector<float> before;
  for (std::size_t e = 0; e < data.tissue->edges().size(); ++e) {
    before.push_back(limit(static_cast<Index>(e)));
  }
  TopologyEdit all, one{.rest_volumes = {{5, 0.5F * 0.729F * solver.rest_volume(5)}}};
  for (Index t = 0; t < static_cast<Index>(data.tissue->tets().size()); ++t) {
    all.rest_volumes.push_back({t, 0.729F * solver.rest_volume(t)});
  }
  solver.tissue().apply(all);
  for (std::size_t e = 0; e < before.size(); ++e) {
    REQUIRE(limit(static_cast<Index>(e)) == Approx(0.9F * before[e]));
  }
  solver.tissue().apply(one);
  for (std::size_t e = 0; e < before.size(); ++e) {
    const bool is_of_tet =
        std::ranges::count(data.tissue->tet_edges()[5], static_cast<Index>(e)) > 0;
    const double share = is_of_tet ? 1.0 / data.tissue->edge_tets()[e] : 0;
    REQUIRE(limit(static_cast<Index>(e)) ==
            Approx(0.9 * before[e] * std::pow(0.5, share / 3)).epsilon(1e-5));
  }
}

// Would catch masses that are kept up by subtracting: what is left of a vertex when all but a
// sliver of a sliver goes would be rounding, or nothing.
TEST_CASE("topology edit: a sliver of slivers has the mass that it would have alone", "[unit]") {
  Scene scene;
  scene.add_body("tet",
                 TetMesh({{0, 0, 0}, {1e-2, 0, 0}, {0, 1e-2, 0}, {0, 0, 1e-2}}, {{0, 1, 2, 3}}),
                 testing::kSprings);
  Solver solver(scene, testing::small_steps());
  const SolverData& data = inspect(solver);
  constexpr int kSplits = 8;
  Index sliver = 0, end = 1;
  for (int i = 0; i < kSplits; ++i) {
    const Index middle = solver.vertex_count();
    TopologyEdit edit{.new_vertices = {{0, end, 0.01F}}, .new_tets = {{sliver, {0, middle, 2, 3}}}};
    edit.new_tets.push_back({sliver, {middle, end, 2, 3}});
    sliver = solver.tissue().apply(edit).first_new_tet;
    end = middle;
  }
  const double mass = data.tissue->tet_mass(sliver);
  CHECK(mass == Approx(1000.0 / 6e6 * std::pow(0.01, kSplits)).epsilon(1e-5));
  for (Index t = 0; t < static_cast<Index>(data.tissue->tets().size()); ++t) {
    if (t != sliver && solver.tissue().is_tet_alive(t)) {
      solver.tissue().apply({.remove_tets = {t}});
    }
  }
  for (const Index v : data.tissue->tets()[sliver]) {
    CHECK(data.tissue->masses()[v] == mass / 4);
    CHECK(data.particle(v).w == static_cast<float>(4 / mass));
  }
}

// Would catch half an edit: after each refusal the state must be what it was, and step alike.
TEST_CASE("topology edit: a bad edit is refused by name and changes nothing", "[unit]") {
  const Scene scene = make_two_blocks();
  Solver solver(scene, testing::small_steps()), untouched(scene, testing::small_steps());
  TopologyEdit first;
  first.remove_tets = {3};
  first.remove_links = {5};
  solver.tissue().apply(first);
  untouched.tissue().apply(first);

  const auto refuse = [&](const TopologyEdit& edit, const std::string& why) {
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(why));
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  refuse({.remove_tets = {7, 100000}}, "tet 100000 does not exist");
  refuse({.remove_tets = {7, -1}}, "tet -1 does not exist");
  refuse({.remove_tets = {7, 3}}, "tet 3 was removed before");
  refuse({.remove_tets = {7, 8, 7}}, "tet 7 is listed twice");
  refuse({.remove_tets = {7}, .remove_links = {5}}, "link 5 was removed before");
  refuse({.remove_tets = {7}, .rest_lengths = {{0, -1}}}, "edge 0: the new rest length");
  refuse({.remove_tets = {7}, .rest_lengths = {{-2, 1}}}, "edge -2 does not exist");
  refuse({.remove_tets = {7}, .rest_volumes = {{1, nan}}}, "tet 1: the new rest volume");
  refuse({.remove_tets = {7}, .rest_volumes = {{3, 1}}}, "tet 3 was removed before");

  CHECK(solver.tissue().version() == untouched.tissue().version());
  CHECK(solver.tissue().is_tet_alive(7));
  for (int i = 0; i < 5; ++i) {
    solver.step(1e-3F);
    untouched.step(1e-3F);
  }
  CHECK(solver.state_hash() == untouched.state_hash());
}

TEST_CASE("topology edit: a follower may refuse, and follows what was done", "[unit]") {
  struct Watcher : Follower {
    bool refuses = false;
    TissueChange seen;
    void validate(const Tissue&, const TopologyEdit&) const override {
      if (refuses) {
        throw InvalidArgument("not now");
      }
    }
    void follow(const Tissue&, const TissueChange& change) noexcept override { seen = change; }
    void undo(const Tissue&, const TissueChange&) noexcept override {}
    void renumber(const Tissue&, const Renumbering&) noexcept override {}
  };
  Solver solver(make_two_blocks(), testing::small_steps());
  Watcher watcher;
  solver.tissue().add_follower(watcher);

  watcher.refuses = true;
  CHECK_THROWS_AS(solver.tissue().apply({.remove_tets = {1}}), InvalidArgument);
  CHECK(solver.tissue().is_tet_alive(1));

  watcher.refuses = false;
  solver.tissue().apply({.remove_tets = {1}});
  CHECK(watcher.seen.removed_tets == std::vector<Index>{1});
  CHECK(watcher.seen.edit.remove_tets.size() == 1);
  CHECK(watcher.seen.version == 1);
}

TEST_CASE("live boundary: removing a tetrahedron opens its inner faces", "[unit]") {
  Solver solver(make_two_blocks(), testing::small_steps());
  const std::size_t before = find_live_boundary(solver.tissue(), 1).size();
  // a tetrahedron of the second body without a boundary face bares four
  std::set<Index> on_boundary;
  for (const BoundaryTriangle& triangle : find_live_boundary(solver.tissue(), 1)) {
    on_boundary.insert(triangle.tet);
    CHECK(triangle.tet >= solver.tissue().bodies()[1].first_tet);
  }
  Index inner = solver.tissue().bodies()[1].first_tet;
  while (on_boundary.count(inner)) {
    ++inner;
  }
  solver.tissue().apply({.remove_tets = {inner}});
  CHECK(find_live_boundary(solver.tissue(), 1).size() == before + 4);
  CHECK_THROWS_AS(find_live_boundary(solver.tissue(), 2), InvalidArgument);
}

}  // namespace pbdsurg
