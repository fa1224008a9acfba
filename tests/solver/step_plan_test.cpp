// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/solver/step_plan.h"

#include <algorithm>
#include <tuple>

#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/edge_ownership.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/soft_sweep.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::kSoftEdge;

PlanComposition any_composition() {
  return GENERATE(PlanComposition::separate, PlanComposition::joint);
}

Scene make_held_bar(const Material& material = testing::kSprings) {
  Scene scene;
  scene.add_body("bar", testing::make_box({6, 3, 3}, kSoftEdge, 0.1), material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  return scene;
}

struct PhaseCounts {
  Index colors = 0;
  Index serial = 0;
};

PhaseCounts count_colors(const StepPlan& plan, PhaseKind kind) {
  PhaseCounts counts;
  for (const Phase& phase : plan.phases) {
    if (phase.kind == kind) {
      ++(phase.serial ? counts.serial : counts.colors);
    }
  }
  return counts;
}

}  // namespace

// Would catch a constraint left out, or projected by two phases: an edge that no tetrahedron owns,
// an overflow without a phase, a tube's edges given to tetrahedra that are never projected.
TEST_CASE("step plan: a sweep projects each constraint once, whatever the plan", "[property]") {
  const PlanComposition composition = any_composition();
  const ColoringOptions coloring =
      GENERATE(ColoringOptions{}, ColoringOptions{.repair = true, .balance = true},
               ColoringOptions{.algorithm = ColoringAlgorithm::random_disc},
               ColoringOptions{.repair = true, .max_colors = 9});
  const Scene scene = testing::make_soft_scene();
  Solver solver(scene, testing::soft_options(coloring, composition));
  INFO(solver.plan().name);
  CHECK(testing::count_error(solver, scene) < 0.5);
}

// Would catch another order than documented, which no property of the result shows.
TEST_CASE("step plan: the order is that of colours, then of ids", "[golden]") {
  const PlanComposition composition = any_composition();
  const ColoringOptions coloring{.repair = true};
  const Scene scene = make_held_bar();
  const std::vector<Tet> tets(scene.tets().begin(), scene.tets().end());
  const std::vector<Edge> edges = find_edges(tets);
  const auto tet_edges = find_tet_edges(tets, edges);
  const auto edge_count = static_cast<Index>(edges.size());
  const auto colors_of_edges =
      color_constraints({std::span(edges), scene.vertex_count()}, coloring).color_of;
  const auto colors_of_tets =
      color_constraints({std::span(tets), scene.vertex_count()}, coloring).color_of;
  const std::vector<Index> owner = assign_edges_to_tets(edge_count, tet_edges).owner;

  // before a colour of tetrahedra, as its first 6 places, come the edges that they own
  constexpr Index kVolume = 6;
  std::vector<std::tuple<bool, Index, Index, Index, Index>> order;  // tets, colour, tet, place, id
  for (Index t = 0; t < static_cast<Index>(tets.size()); ++t) {
    order.emplace_back(true, colors_of_tets[t], t, kVolume, t);
    for (Index place = 0; place < 6; ++place) {
      const Index edge = tet_edges[t][place];
      if (owner[edge] == t && composition == PlanComposition::joint) {
        order.emplace_back(true, colors_of_tets[t], t, place, edge);
      }
    }
  }
  for (Index e = 0; e < edge_count && composition == PlanComposition::separate; ++e) {
    order.emplace_back(false, colors_of_edges[e], kInvalidIndex, 0, e);
  }
  REQUIRE(order.size() == edges.size() + tets.size());
  std::sort(order.begin(), order.end());

  Solver solver(scene, testing::small_steps({.mode = ProjectionMode::fraction,
                                             .substeps = 1,
                                             .coloring = coloring,
                                             .composition = composition}));
  std::vector<Vec3<float>> x;
  std::vector<Eigen::Vector3f> start;
  for (const Eigen::Vector3d& p : scene.positions()) {
    start.push_back((1.1 * p).cast<float>());
    x.push_back({start.back().x(), start.back().y(), start.back().z()});
  }
  const auto project = [&]<std::size_t kArity>(auto constraint,
                                               const std::array<Index, kArity>& vertices,
                                               float rest, float stiffness) {
    Vec3<float> points[kArity];
    float weights[kArity];
    for (std::size_t k = 0; k < kArity; ++k) {
      const Index v = vertices[k];
      points[k] = x[v];
      weights[k] = scene.is_fixed(v) ? 0 : static_cast<float>(1 / scene.masses()[v]);
    }
    const float parameters[] = {rest, stiffness, 0};
    float unused[] = {0};
    decltype(constraint)::template project<ProjectionMode::fraction>(points, weights, parameters,
                                                                     Substep<float>{}, unused);
    for (std::size_t k = 0; k < kArity; ++k) {
      x[vertices[k]] = points[k];
    }
  };
  for (const auto& [is_tet, color, tet, place, id] : order) {
    if (is_tet && place == kVolume) {
      project(VolumeConstraint{}, tets[id], solver.rest_volume(id), 1);
    } else {
      project(DistanceConstraint{}, edges[id], solver.rest_length(id), 0.4F);
    }
  }

  solver.write_positions(start);
  solver.step(1e-6F);  // gravity moves nothing in so short a time

  float farthest = 0;
  const std::vector<Eigen::Vector3f> after = solver.positions();
  for (std::size_t v = 0; v < after.size(); ++v) {
    farthest = std::max(farthest, (after[v] - Eigen::Vector3f(x[v].x, x[v].y, x[v].z)).norm());
  }
  CHECK(farthest < 1e-5 * kSoftEdge);  // rounding; another order differs by hundredths of an edge
}

// Would catch multipliers that the joint plan loses between sweeps, or compliances it misreads: in
// the limit a plan has no say in what tissue does.
TEST_CASE("step plan: plans agree where sweeps have converged", "[validation][long]") {
  const TetMesh mesh = testing::make_box({6, 3, 3}, kSoftEdge, 0.1);
  const Scene scene = make_held_bar(elastic_material(mesh, 1000, 20e3));
  const auto hang = [&](PlanComposition composition) {
    Solver solver(
        scene, testing::small_steps(
                   {.substeps = 10, .iterations = 40, .damping = 40, .composition = composition}));
    for (int i = 0; i < 100; ++i) {
      solver.step(5e-3F);
    }
    return solver.positions();
  };
  const auto separate = hang(PlanComposition::separate);
  const auto joint = hang(PlanComposition::joint);

  float farthest = 0, sag = 0;
  for (std::size_t v = 0; v < joint.size(); ++v) {
    farthest = std::max(farthest, (joint[v] - separate[v]).norm());
    sag = std::max(sag, (joint[v] - scene.positions()[v].cast<float>()).norm());
  }
  CHECK(sag > 0.03 * kSoftEdge);
  CHECK(farthest < 1e-3 * kSoftEdge);
}

TEST_CASE("step plan: a joint plan has the phases of the tetrahedra alone", "[unit]") {
  const Solver separate(make_held_bar(), testing::small_steps()),
      joint(make_held_bar(), testing::small_steps({.composition = PlanComposition::joint}));
  CHECK(count_colors(separate.plan(), PhaseKind::distance).colors >= 14);
  CHECK(count_colors(joint.plan(), PhaseKind::distance).colors == 0);
  CHECK(count_colors(joint.plan(), PhaseKind::volume).colors == 0);
  CHECK(count_colors(joint.plan(), PhaseKind::joint).colors ==
        count_colors(separate.plan(), PhaseKind::volume).colors);

  // tubes and links keep phases of their own
  const Solver mixed(testing::make_soft_scene(),
                     testing::small_steps({.composition = PlanComposition::joint}));
  CHECK(count_colors(mixed.plan(), PhaseKind::distance).colors > 0);
  CHECK(count_colors(mixed.plan(), PhaseKind::joint).colors > 0);
}

TEST_CASE("step plan: what a limit of colours leaves over is one serial phase a kind", "[unit]") {
  const PlanComposition composition = any_composition();
  const PhaseKind tets =
      composition == PlanComposition::joint ? PhaseKind::joint : PhaseKind::volume;
  const Solver limited(make_held_bar(), testing::small_steps({.coloring = {.max_colors = 10},
                                                              .composition = composition}));
  CHECK(count_colors(limited.plan(), tets).colors == 10);
  CHECK(count_colors(limited.plan(), tets).serial == 1);
  const Solver unlimited(make_held_bar(), testing::small_steps({.composition = composition}));
  CHECK(count_colors(unlimited.plan(), tets).serial == 0);
}

TEST_CASE("step plan: its name tells colouring and composition", "[unit]") {
  const Scene scene = make_held_bar();
  const auto name = [&](const ColoringOptions& coloring, PlanComposition composition) {
    return Solver(scene, testing::small_steps({.coloring = coloring, .composition = composition}))
        .plan()
        .name;
  };
  CHECK(Solver(scene, testing::small_steps()).plan().name == "greedy+repair, nested");
  CHECK(name({.order = GreedyOrder::smallest_last, .balance = true}, PlanComposition::joint) ==
        "greedy by smallest_last+balance, joint");
  CHECK(name({.algorithm = ColoringAlgorithm::luby, .max_colors = 12}, PlanComposition::joint) ==
        "luby+limit 12, joint");
  CHECK(Solver(scene, SolverOptions::paper()).plan().name ==
        "random_disc by conflicts, distances then volumes");
}

TEST_CASE("step plan: bad options are refused by name", "[unit]") {
  const Scene scene = make_held_bar();
  const auto refuse = [&](const ColoringOptions& coloring, const char* option) {
    CHECK_THROWS_WITH(Solver(scene, testing::small_steps({.coloring = coloring})),
                      ContainsSubstring(option));
  };
  refuse({.max_colors = -1}, "max_colors is -1");
  refuse({.algorithm = ColoringAlgorithm::random_disc, .disc = {.shrink = 0.5}}, "shrink");
  refuse({.algorithm = static_cast<ColoringAlgorithm>(77)}, "77");
  CHECK_THROWS_WITH(
      Solver(scene, testing::small_steps({.composition = static_cast<PlanComposition>(9)})),
      ContainsSubstring("composition 9"));
}

}  // namespace pbdsurg
