// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/contact/proximity.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_boundary.h"

#include "lib/solver/sets/neo_hookean_record.h"
#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/eventful_program.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/plan_checks.h"
#include "tests/support/solver_digest.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::digest_of;
using testing::inspect;
using testing::is_plan_valid;
using testing::kEventfulEdge;
using testing::kEventfulTimeStep;
using testing::Variant;

using Positions = std::vector<Eigen::Vector3d>;

// Parts or splits at random; `rest` follows.
TopologyEdit random_cut(const Solver& solver, std::uint64_t seed, Positions& rest) {
  TopologyEdit edit;
  if (random_bits(seed, 0) % 2 == 0) {
    auto vertex = static_cast<Index>(random_bits(seed, 1) % solver.vertex_count());
    edit = testing::part_vertex(solver, vertex, seed);
  } else {
    auto edge = static_cast<Index>(random_bits(seed, 2) % solver.tissue().edges().size());
    while (!solver.tissue().is_edge_alive(edge)) {
      edge = (edge + 1) % static_cast<Index>(solver.tissue().edges().size());
    }
    edit = testing::split_edge(solver, edge, 0.25F + 0.125F * static_cast<float>(seed % 4));
  }
  for (const NewVertex& v : edit.new_vertices) {
    rest.push_back(rest[v.first] + v.share * (rest[v.second] - rest[v.first]));
  }
  return edit;
}

// All that a solver would have if it were made of the live tetrahedra.
void check_against_rebuild(const Solver& solver, const Positions& rest) {
  const SolverData& data = inspect(solver);
  std::map<Edge, Index> tets_of_edge;
  std::vector<double> masses(rest.size(), 0.0);
  std::vector<std::vector<Index>> tets_at(rest.size());
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    if (!solver.tissue().is_tet_alive(t)) {
      REQUIRE_FALSE(data.sets.of<VolumeConstraint>().is_alive(t));
      REQUIRE_FALSE(data.sets.of<NeoHookeanConstraint>().is_alive(t));
      continue;
    }
    const Tet& tet = solver.tissue().tets()[t];
    const Material& material = solver.tissue().body(solver.tissue().body_of_tet(t)).material;
    const double volume = tet_volume(rest, tet);
    REQUIRE(volume > 0);
    const bool is_solid = material.model == ElasticModel::neo_hookean;
    REQUIRE(data.sets.of<NeoHookeanConstraint>().is_alive(t) == is_solid);
    REQUIRE(data.sets.of<VolumeConstraint>().is_alive(t) ==
            (!is_solid && material.has_volume_constraints));
    if (is_solid || material.has_volume_constraints) {
      REQUIRE(solver.rest_volume(t) == Approx(volume).epsilon(1e-3));
    }
    if (is_solid) {
      REQUIRE(data.sets.of<NeoHookeanConstraint>().record(t).places == data.places_of(tet));
      const auto fresh = make_neo_hookean(rest, tet, data.places_of(tet), material, 1);
      for (int p = 0; p < NeoHookeanConstraint::kParameterCount; ++p) {
        REQUIRE(data.sets.of<NeoHookeanConstraint>().record(t).parameters[p] ==
                Approx(fresh.parameters[p]).epsilon(1e-2).margin(1.0));
      }
    } else if (material.has_volume_constraints) {
      REQUIRE(data.sets.of<VolumeConstraint>().record(t).places == data.places_of(tet));
    }
    for (std::size_t e = 0; e < 6; ++e) {
      const auto [i, j] = kTetEdges[e];
      const Edge ends{std::min(tet[i], tet[j]), std::max(tet[i], tet[j])};
      REQUIRE(solver.tissue().edges()[solver.tissue().tet_edges(t)[e]] == ends);
      ++tets_of_edge[ends];
    }
    for (const Index v : tet) {
      masses[v] += material.density * volume / 4;
      tets_at[v].push_back(t);
      REQUIRE(solver.tissue().body_of_vertex(v) == solver.tissue().body_of_tet(t));
    }
  }
  Index live_edges = 0;
  for (Index e = 0; e < static_cast<Index>(solver.tissue().edges().size()); ++e) {
    const Index distance = data.sets.distance_ids.of_edge(e);
    if (!solver.tissue().is_edge_alive(e)) {
      REQUIRE_FALSE(data.sets.of<DistanceConstraint>().is_alive(distance));
      REQUIRE_FALSE(data.sets.of<StrainLimitConstraint>().is_alive(e));
      continue;
    }
    ++live_edges;
    const Edge& ends = solver.tissue().edges()[e];
    REQUIRE(data.tissue->edge_tets()[e] == tets_of_edge[ends]);
    const Material& material =
        solver.tissue().body(solver.tissue().body_of_vertex(ends[0])).material;
    const double length = (rest[ends[0]] - rest[ends[1]]).norm();
    REQUIRE(data.sets.of<DistanceConstraint>().is_alive(distance) ==
            (material.model == ElasticModel::springs));
    if (material.model == ElasticModel::springs) {
      REQUIRE(data.sets.of<DistanceConstraint>().record(distance).places == data.places_of(ends));
      REQUIRE(solver.rest_length(e) == Approx(length).epsilon(1e-3));
    }
    REQUIRE(data.sets.of<StrainLimitConstraint>().is_alive(e) ==
            std::isfinite(material.max_stretch));
    if (data.sets.of<StrainLimitConstraint>().is_alive(e)) {
      REQUIRE(data.sets.of<StrainLimitConstraint>().record(e).places == data.places_of(ends));
      REQUIRE(data.sets.of<StrainLimitConstraint>()
                  .record(e)
                  .parameters[StrainLimitConstraint::kLimit] ==
              Approx(material.max_stretch * length).epsilon(1e-3));
    }
  }
  REQUIRE(live_edges == static_cast<Index>(tets_of_edge.size()));
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    REQUIRE(std::ranges::equal(data.tissue->tets_at(v), tets_at[v]));
    REQUIRE(data.tissue->masses()[v] == Approx(masses[v]).epsilon(1e-6).margin(1e-15));
    REQUIRE(solver.tissue().has_tissue(v) == !tets_at[v].empty());
  }
  for (Index l = 0; l < static_cast<Index>(solver.tissue().links().size()); ++l) {
    const Link& link = solver.tissue().links()[l];
    if (solver.tissue().is_link_alive(l)) {
      REQUIRE(solver.tissue().has_tissue(link.first));
      REQUIRE(solver.tissue().has_tissue(link.second));
      REQUIRE(data.sets.of<DistanceConstraint>().record(data.sets.distance_ids.of_link(l)).places ==
              data.places_of(Edge{link.first, link.second}));
    }
  }
  REQUIRE(is_plan_valid(data));
}

std::vector<Variant> parting_variants() {
  return {{},
          {.composition = PlanComposition::joint},
          {.composition = PlanComposition::joint, .max_colors = 9, .damping = 0.01F},
          {.mode = ProjectionMode::fraction, .composition = PlanComposition::nested},
          {.method = SolverMethod::vertex_block},
          {.method = SolverMethod::vertex_block, .damping = 0.01F}};
}

}  // namespace

// Would catch whatever an edit forgets to bring up to date: constraints, rest values, masses,
// neighbours, colours; and what undo leaves behind.
TEST_CASE("cut: after any cuts, all equals a rebuild, and undo restores every bit", "[property]") {
  const Variant variant = GENERATE(from_range(parting_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  options.copies = GENERATE(1, 2);
  if (options.copies == 2) {
    options.spare = {.vertices = 20, .tets = 100, .edges = 200, .links = 10};
  }
  Solver solver(scene, options);
  Positions rest(scene.positions().begin(), scene.positions().end());
  for (std::uint64_t round = 0; round < 40; ++round) {
    INFO("round " << round);
    const std::uint64_t before = digest_of(inspect(solver));
    Positions next = rest;
    TopologyEdit edit = random_cut(solver, round, next);
    if (round % 5 == 4) {
      for (Index t = static_cast<Index>(round);
           t < static_cast<Index>(solver.tissue().tets().size()); t += 53) {
        const auto is_used = [&](const auto& list, auto tet_of) {
          return std::ranges::any_of(list, [&](const auto& entry) { return entry.*tet_of == t; });
        };
        if (solver.tissue().is_tet_alive(t) && !is_used(edit.corner_moves, &CornerMove::tet) &&
            !is_used(edit.new_tets, &NewTet::parent)) {
          edit.remove_tets.push_back(t);
        }
      }
    }
    solver.tissue().apply(edit);
    REQUIRE(static_cast<std::size_t>(solver.vertex_count()) == next.size());
    check_against_rebuild(solver, next);
    if (round % 3 == 1) {
      solver.tissue().undo();
      REQUIRE(digest_of(inspect(solver)) == before);
      check_against_rebuild(solver, rest);
    } else {
      rest = next;
    }
    if (round % 8 == 7) {
      REQUIRE(solver.step(kEventfulTimeStep).non_finite_vertices == 0);
    }
  }
}

// Would catch a backend that reads what a cut moved, or does not see what it added.
TEST_CASE("cut: threads have the serial bits on cut tissue", "[equivalence]") {
  const Variant variant = GENERATE(from_range(parting_variants()));
  const Scene scene = testing::make_eventful_scene(variant.mode, variant.damping);
  SolverOptions options = testing::options_of(variant);
  options.executor = executor::serial();
  Solver serial(scene, options);
  options.executor = executor::threads(2);
  Solver threaded(scene, options);
  Positions rest(scene.positions().begin(), scene.positions().end());
  for (std::uint64_t round = 0; round < 20; ++round) {
    const TopologyEdit edit = random_cut(serial, 77 + round, rest);
    serial.tissue().apply(edit);
    threaded.tissue().apply(edit);
    serial.step(kEventfulTimeStep);
    threaded.step(kEventfulTimeStep);
    REQUIRE(serial.state_hash() == threaded.state_hash());
  }
}

namespace {

// Cuts a lattice along its plane of faces at x.
TopologyEdit cut_plane(const Solver& solver, const Positions& rest, double x) {
  TopologyEdit edit;
  std::map<Index, Index> copies;
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    const Tet& tet = solver.tissue().tets()[t];
    const double middle = std::accumulate(
        tet.begin(), tet.end(), 0.0, [&](double sum, Index v) { return sum + rest[v].x() / 4; });
    for (const Index v : tet) {
      if (middle > x && std::abs(rest[v].x() - x) < 0.01 * kEventfulEdge) {
        const auto next = solver.vertex_count() + static_cast<Index>(copies.size());
        const auto [copy, is_new] = copies.emplace(v, next);
        if (is_new) {
          edit.new_vertices.push_back({v, v});
        }
        edit.corner_moves.push_back({t, v, copy->second});
      }
    }
  }
  return edit;
}

}  // namespace

// Would catch any constraint that still joins the halves.
TEST_CASE("cut: a block in two falls apart, and nothing pulls across", "[validation]") {
  const auto model = GENERATE(ElasticModel::springs, ElasticModel::neo_hookean);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  if (method == SolverMethod::vertex_block && composition == PlanComposition::joint) {
    return;
  }
  const TetMesh mesh = testing::make_box({4, 3, 3}, kEventfulEdge);
  Material material = elastic_material(mesh, 1000, 20e3);
  material.model = model;
  Scene scene;
  scene.add_body("block", mesh, material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEventfulEdge; });
  Solver solver(scene, {.method = method, .composition = composition});
  const Positions rest(scene.positions().begin(), scene.positions().end());
  const TopologyEdit edit = cut_plane(solver, rest, 2 * kEventfulEdge);
  REQUIRE(edit.new_vertices.size() == 16);
  const std::size_t faces = find_live_boundary(solver.tissue(), 0).size();
  const TissueChange result = solver.tissue().apply(edit);
  CHECK(result.emptied_vertices.empty());
  CHECK(find_live_boundary(solver.tissue(), 0).size() == faces + 2 * 18);

  const int steps = 20;
  for (int i = 0; i < steps; ++i) {
    solver.step(5e-3F);
  }
  const double time = steps * 5e-3;
  const auto x = solver.positions();
  for (std::size_t v = 0; v < x.size(); ++v) {
    const bool is_free = v >= rest.size() || rest[v].x() > 2.5 * kEventfulEdge;
    const Eigen::Vector3d start =
        v < rest.size() ? rest[v] : rest[edit.new_vertices[v - rest.size()].first];
    INFO("vertex " << v);
    if (is_free) {  // free fall, up to how substeps sum it up
      CHECK(x[v].y() - start.y() == Approx(-0.5 * 9.81 * time * time).epsilon(0.03));
    } else {
      CHECK(std::abs(x[v].y() - start.y()) < 0.2 * kEventfulEdge);
    }
  }
}

// Would catch mass or momentum that a cut makes or loses.
TEST_CASE("cut: mass, rest volume and momentum stay", "[property]") {
  const auto model = GENERATE(ElasticModel::springs, ElasticModel::neo_hookean);
  const TetMesh mesh = testing::make_box({3, 3, 3}, kEventfulEdge, 0.1);
  Material material = elastic_material(mesh, 1000, 20e3);
  material.model = model;
  Scene scene;
  scene.add_body("block", mesh, material);
  Solver solver(scene, {.executor = executor::serial()});
  std::vector<Eigen::Vector3f> speeds = solver.positions();
  for (Eigen::Vector3f& v : speeds) {
    v = 10 * v.cross(Eigen::Vector3f(1, 2, 3)) + Eigen::Vector3f(0.1F, 0, 0.2F);
  }
  solver.write_velocities(speeds);
  struct Sums {
    double mass = 0, volume = 0;
    Eigen::Vector3d momentum{0, 0, 0};
  };
  const auto sums_of = [&] {
    Sums sums;
    const auto velocities = solver.velocities();
    for (Index v = 0; v < solver.vertex_count(); ++v) {
      const double mass = solver.tissue().masses()[v];
      sums.mass += mass;
      sums.momentum += mass * velocities[v].cast<double>();
    }
    for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
      sums.volume += solver.tissue().is_tet_alive(t) ? double{solver.rest_volume(t)} : 0;
    }
    return sums;
  };
  const Sums before = sums_of();
  Positions rest(scene.positions().begin(), scene.positions().end());
  for (std::uint64_t round = 0; round < 60; ++round) {
    solver.tissue().apply(random_cut(solver, round, rest));
    const Sums after = sums_of();
    REQUIRE(after.mass == Approx(before.mass).epsilon(1e-9));
    REQUIRE(after.volume == Approx(before.volume).epsilon(1e-4));
    REQUIRE((after.momentum - before.momentum).norm() < 1e-5 * before.momentum.norm());
  }
}

// Would catch a fixed vertex whose copy falls, and a copy that is fixed for being between.
TEST_CASE("cut: new vertices are fixed where all around is", "[unit]") {
  Scene scene;
  scene.add_body("block", testing::make_box({2, 1, 1}, kEventfulEdge));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEventfulEdge; });
  Solver solver(scene, {.executor = executor::serial()});
  const auto w = [&](Index v) { return inspect(solver).particle(v).w; };
  Index first = 0;  // a fixed edge, and one that is half fixed
  while (w(solver.tissue().edges()[first][0]) > 0 || w(solver.tissue().edges()[first][1]) > 0) {
    ++first;
  }
  solver.tissue().apply(testing::split_edge(solver, first, 0.5F));
  CHECK(w(solver.vertex_count() - 1) == 0);
  CHECK(solver.tissue().has_tissue(solver.vertex_count() - 1));
  Index second = 0;
  while ((w(solver.tissue().edges()[second][0]) > 0) ==
         (w(solver.tissue().edges()[second][1]) > 0)) {
    ++second;
  }
  solver.tissue().apply(testing::split_edge(solver, second, 0.5F));
  CHECK(w(solver.vertex_count() - 1) > 0);
}

TEST_CASE("cut: a bad cut is refused by name and changes nothing", "[unit]") {
  Scene scene;
  const TetMesh block = testing::make_box({2, 2, 2}, kEventfulEdge);
  scene.add_body("left", block);
  scene.add_body("right", block);
  Solver solver(scene, {.executor = executor::serial()});
  const Index n = solver.vertex_count();
  const Tet tet = solver.tissue().tets()[0];
  const auto refuse = [&](const TopologyEdit& edit, const std::string& why) {
    const std::uint64_t before = digest_of(inspect(solver));
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(why));
    CHECK(digest_of(inspect(solver)) == before);
  };
  const std::vector<NewVertex> copy{{tet[0], tet[0]}};
  const std::vector<NewVertex> middle{{tet[0], tet[1], 0.5F}};
  const CornerMove move{0, tet[0], n};
  refuse({.new_vertices = {{n, 0}}}, "refers to vertex 54");
  refuse({.new_vertices = {{0, n - 1, 0.5F}}}, "of different bodies");
  refuse({.new_vertices = {{tet[0], tet[1], 1.5F}}}, "the share is 1.5");
  refuse({.new_vertices = {{tet[0], tet[1], std::numeric_limits<float>::quiet_NaN()}}},
         "the share is nan");
  refuse({.new_vertices = copy}, "new vertex 54 would have no tetrahedron");
  const Tet& other = solver.tissue().tets()[1];
  const Index elsewhere = other[0] == tet[0] ? other[1] : other[0];
  refuse({.new_vertices = copy, .corner_moves = {move, {1, elsewhere, n}}}, "tet 1 cannot move");
  refuse({.new_vertices = copy, .corner_moves = {move, move}}, "tet 0 is moved twice");
  refuse({.new_vertices = copy, .corner_moves = {{-1, tet[0], n}}}, "tet -1 does not exist");
  refuse({.new_vertices = copy, .corner_moves = {{0, n - 1, n}}}, "tet 0 has no corner at vertex");
  refuse({.new_vertices = middle, .corner_moves = {move}}, "no new copy");
  refuse({.remove_tets = {0}, .new_vertices = copy, .corner_moves = {move}},
         "tet 0 is moved and removed");
  refuse({.new_vertices = copy, .corner_moves = {move}, .link_moves = {{0, tet[0], n}}},
         "link 0 does not exist");
  refuse({.new_tets = {{999, tet}}}, "tet 999 does not exist");
  refuse({.remove_tets = {0}, .new_tets = {{0, tet}}}, "is moved or removed by the same edit");
  refuse({.new_tets = {{0, {tet[0], tet[1], tet[2], n}}}},
         "refers to a vertex that does not exist");
  refuse({.new_tets = {{0, {tet[0], tet[1], tet[2], n - 1}}}}, "neither a corner of tet 0");
  refuse({.new_tets = {{0, {tet[1], tet[0], tet[2], tet[3]}}}}, "it must be positive");
  refuse({.new_tets = {{0, {tet[0], tet[0], tet[2], tet[3]}}}}, "it must be positive");
  refuse({.new_vertices = middle, .new_tets = {{0, {n, tet[1], tet[2], tet[3]}}}},
         "new tets fill 0.5");
}

// Would catch a vertex that takes its body from another than the one that it came from.
TEST_CASE("cut: a copy of a copy is of the same body, and a jaw finds it", "[unit]") {
  const TetMesh mesh = testing::make_box({2, 2, 2}, 4e-3);
  Scene scene;
  scene.add_body("first", mesh);
  scene.add_body("second", mesh);
  Solver solver(scene, {.executor = executor::serial()});
  Index copied = 0;
  for (int round = 0; round < 3; ++round) {
    const Index copy = solver.vertex_count();
    Index tet = 0;
    while (std::ranges::find(solver.tissue().tets()[tet], copied) ==
           solver.tissue().tets()[tet].end()) {
      ++tet;
    }
    solver.tissue().apply(
        {.new_vertices = {{copied, copied}}, .corner_moves = {{tet, copied, copy}}});
    CHECK(solver.tissue().body_of_vertex(copy) == 0);
    const std::vector<Index> near =
        find_vertices_near(solver, 0, mesh.positions()[0].cast<float>(), 1e-3F);
    CHECK(std::ranges::find(near, copy) != near.end());
    if (round == 1) {
      copied = copy;
    }
  }
}

// Would catch a tool that holds, or a list that names, a vertex that is not there any more.
TEST_CASE("undo: tools let go of what the edit brought, and nobody watches it", "[unit]") {
  const TetMesh mesh = testing::make_box({2, 2, 2}, 4e-3);
  Scene scene;
  scene.add_body("block", mesh);
  Solver solver(scene, {.executor = executor::serial()});
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  const Index copy = solver.vertex_count();
  Index tet = 0;
  while (std::ranges::find(solver.tissue().tets()[tet], 0) == solver.tissue().tets()[tet].end()) {
    ++tet;
  }
  const TopologyEdit edit{.new_vertices = {{0, 0}}, .corner_moves = {{tet, 0, copy}}};
  solver.tissue().apply(edit);
  solver.grasp(tool, std::array{copy, Index{5}});
  solver.watch(std::array{copy});
  CHECK_THROWS_WITH(solver.tissue().undo(), testing::ContainsSubstring("watched"));
  solver.watch({});
  solver.tissue().undo();
  REQUIRE(inspect(solver).tools[0].attachments.size() == 1);
  CHECK(inspect(solver).tools[0].attachments[0].vertex == 5);
  CHECK(solver.step(1e-3F).non_finite_vertices == 0);
}

}  // namespace pbdsurg
