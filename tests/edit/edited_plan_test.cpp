// SPDX-License-Identifier: Apache-2.0
// What edits leave of a solver's plan, beside that of a solver made anew of the same tissue. The
// figures are in docs/edits.md.
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "pbdsurg/anatomy/cholecystectomy_anatomy.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cut.h"

#include "tests/support/catch.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3f;

TetMesh small_liver() {
  OrganRecipe recipe = organ_recipe(Organ::liver);
  recipe.options.vertex_count = 1150;
  return tetrahedralize(recipe.shape, recipe.options).mesh;
}

SolverOptions serial_plan_options(SolverMethod method) {
  SolverOptions options{.method = method, .executor = executor::serial()};
  if (method == SolverMethod::projection) {
    options.composition = PlanComposition::separate;
  }
  return options;
}

// Strokes of a blade of 20 cuts each, through tissue at rest, each cut as long as a third of an
// edge.
class Strokes {
 public:
  explicit Strokes(const Solver& solver)
      : solver_(solver), tet_count_(static_cast<Index>(solver.tissue().tets().size())) {}

  TopologyEdit next() {
    for (;;) {
      if (cuts_left_-- == 0) {
        begin();
      }
      const BladeEdge before{at_ - kReach * across_, at_ + kReach * across_};
      at_ += kAdvance * along_;
      const BladeEdge now{at_ - kReach * across_, at_ + kReach * across_};
      CutPlan plan =
          plan_cut(solver_, sweep_blade(std::array{before, now}), {.front = std::move(front_)});
      front_ = std::move(plan.front);
      if (!plan.edit.new_tets.empty()) {
        return plan.edit;
      }
    }
  }

 private:
  static constexpr int kCuts = 20;
  static constexpr float kAdvance = 3e-3F, kReach = 1.2e-2F;  // m

  void begin() {
    const Tissue& tissue = solver_.tissue();
    Index tet = 0;
    do {
      tet = static_cast<Index>(random_unit(kSeed, draws_++, 0) * tet_count_);
    } while (!tissue.is_tet_alive(tet));
    at_ = tissue.rest_positions()[tissue.tets()[tet][0]].cast<float>();
    const auto any = [&](std::uint64_t which) {
      const auto share = [&](std::uint64_t axis) {
        return static_cast<float>(random_unit(kSeed, draws_, 3 * which + axis)) - 0.5F;
      };
      return Vector3f(share(1), share(2), share(3)).normalized();
    };
    along_ = any(0);
    across_ = along_.cross(any(1)).normalized();
    ++draws_;
    cuts_left_ = kCuts - 1;
    front_ = {};
  }

  static constexpr std::uint64_t kSeed = 3;

  const Solver& solver_;
  Index tet_count_;  // without what cuts make: strokes begin where nothing is cut yet
  std::uint64_t draws_ = 0;
  int cuts_left_ = 0;
  Vector3f at_, along_, across_;
  CutFront front_;
};

std::ptrdiff_t phase_count(const Solver& solver, PhaseKind kind) {
  return std::ranges::count(solver.plan().phases, kind, &Phase::kind);
}

// How many phases of a kind a solver's plan has more than that of one made anew.
std::ptrdiff_t excess(Solver& solver, PhaseKind kind) {
  const Solver fresh(solver.tissue(), solver.options());
  return phase_count(solver, kind) - phase_count(fresh, kind);
}

}  // namespace

// Would catch colours that open where one is free, and colours that stay once they are empty.
TEST_CASE("edited plan: after 200 cuts few colours more than a fresh one", "[property]") {
  Scene scene;
  scene.add_body("liver", small_liver());
  Solver solver(scene, serial_plan_options(SolverMethod::projection));
  Strokes strokes(solver);
  for (int cuts = 1; cuts <= 200; ++cuts) {
    solver.tissue().apply(strokes.next());
    if (cuts % 10 == 0) {
      INFO(cuts << " cuts");
      CHECK(excess(solver, PhaseKind::distance) <= 5);
      CHECK(excess(solver, PhaseKind::volume) <= 8);
    }
  }
}

// Would catch a colour for each vertex that finds all others taken by its neighbours, walks that
// end too early, and colours that stay once few vertices have them.
TEST_CASE("edited plan: after 200 cuts no colour of vertices more than a fresh one", "[property]") {
  const TetMesh mesh = small_liver();
  Scene scene;
  scene.add_body("liver", mesh, elastic_material(mesh, 1000, 5000));
  Solver solver(scene, serial_plan_options(SolverMethod::vertex_block));
  CHECK(phase_count(solver, PhaseKind::vertex) == 5);
  Strokes strokes(solver);
  for (int cuts = 1; cuts <= 200; ++cuts) {
    INFO(cuts << " cuts");
    solver.tissue().apply(strokes.next());
    CHECK(phase_count(solver, PhaseKind::vertex) <= 7);
    if (cuts % 10 == 0) {
      CHECK(excess(solver, PhaseKind::vertex) <= 0);
    }
  }
}

// Would catch removals that move constraints to colours of their own.
TEST_CASE("edited plan: removals open no colour", "[property]") {
  Scene scene;
  scene.add_body("liver", small_liver());
  Solver solver(scene, serial_plan_options(SolverMethod::projection));
  const auto distances = phase_count(solver, PhaseKind::distance);
  const auto volumes = phase_count(solver, PhaseKind::volume);
  const auto tet_count = static_cast<Index>(solver.tissue().tets().size());
  for (Index tet = 0; tet < tet_count / 2; tet += 2) {
    solver.tissue().apply({.remove_tets = {tet, tet + 1}});
  }
  CHECK(phase_count(solver, PhaseKind::distance) <= distances);
  CHECK(phase_count(solver, PhaseKind::volume) <= volumes);
  CHECK(excess(solver, PhaseKind::distance) <= 1);
  CHECK(excess(solver, PhaseKind::volume) <= 2);
}

}  // namespace pbdsurg
