// SPDX-License-Identifier: Apache-2.0
// A lumen through edits, undo and compaction, in copies and on threads.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/surgery/lumen.h"

#include "tests/support/lumen_cases.h"

namespace pbdsurg {
namespace {

using testing::any_lumen_recipe;
using testing::Approx;
using testing::ball_scene;
using testing::kInner;
using testing::kLumenStep;
using testing::kOuter;
using testing::LumenRecipe;
using testing::LumenSolver;
using testing::puncture;

constexpr float kLine = 1e-4F;  // m^2

LumenSolver blown_up(const LumenRecipe& recipe, float pressure = 300) {
  LumenSolver ball(ball_scene(), recipe.options, {});
  ball.lumen->set_reservoir(kLine, pressure);
  ball.run(60);
  ball.lumen->set_reservoir(0, 0);
  ball.run(10);
  REQUIRE(ball.lumen->pressure() > 0.9F * pressure);
  return ball;
}

// Runs, and adds up what should flow out of the hole, m^3.
double run_and_leak(LumenSolver& ball, int steps) {
  const LumenOptions& contents = ball.lumen->options();
  double leaked = 0;
  for (int step = 0; step < steps; ++step) {
    const double pressure = ball.lumen->pressure();
    ball.run(1);
    const double mean = std::max(0.0, (pressure + double{ball.lumen->pressure()}) / 2);
    leaked += double{kLumenStep} * double{contents.discharge} *
              ball.lumen->cavity().hole_area(ball.solver.positions()) *
              std::sqrt(2 * mean / double{contents.density});
  }
  return leaked;
}

}  // namespace

// Would catch a hole that lets nothing out, or more than its area does, and a lumen that stays open
// when the edit is taken back.
TEST_CASE("lumen: a hole through the wall empties it, and an undo closes it", "[validation]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  LumenSolver ball = blown_up(recipe);
  const double before = ball.lumen->state().amount;
  ball.solver.tissue().apply(puncture(ball.solver.tissue(), 1));
  CHECK(ball.lumen->cavity().is_open());
  CHECK(ball.lumen->cavity().hole_count() == 1);
  const double area = ball.lumen->cavity().hole_area(ball.solver.positions());
  CHECK(area > 10e-6);
  CHECK(area < 80e-6);
  const double leaked = run_and_leak(ball, 4);
  CHECK(before - ball.lumen->state().amount == Approx(leaked).epsilon(0.2));
  ball.run(60);
  CHECK(std::abs(ball.lumen->pressure()) < 3);
  ball.solver.tissue().undo();
  CHECK(!ball.lumen->cavity().is_open());
  ball.run(1);
  CHECK(std::abs(ball.lumen->pressure()) < 10);
  const double empty = ball.lumen->state().amount;
  ball.run(60);
  CHECK(ball.lumen->state().amount == empty);
  ball.lumen->set_reservoir(kLine, 300);
  ball.run(100);
  CHECK(ball.lumen->pressure() == Approx(300).epsilon(0.02));
}

// Would catch a lumen that keeps its pressure, or vertices, when the body goes.
TEST_CASE("lumen: without a wall it is empty", "[unit]") {
  LumenSolver ball = blown_up({"default", {.damping = 30}});
  ball.solver.tissue().apply({.remove_bodies = {0}});
  ball.run(2);
  CHECK(ball.lumen->state().amount == 0);
  CHECK(ball.lumen->pressure() == 0);
  CHECK(ball.lumen->vertices().empty());
  ball.solver.tissue().undo();
  ball.run(10);
  CHECK(ball.lumen->state().amount > 3e-5);
}

// Would catch a slit that does not open a lumen, and one whose lips let nothing out however far
// pressure drives them apart.
TEST_CASE("lumen: a slit opens it as far as its lips part", "[validation]") {
  const LumenRecipe recipe = any_lumen_recipe();
  const CutStyle style = GENERATE(CutStyle::along_faces, CutStyle::through_tets);
  INFO(recipe.name << ", style " << static_cast<int>(style));
  LumenSolver ball = blown_up(recipe);
  const float low = 0.5F * static_cast<float>(kInner), high = 2 * static_cast<float>(kOuter);
  const CutSurface blade{
      {{-6e-3F, low, 3e-4F}, {6e-3F, low, 3e-4F}, {6e-3F, high, 3e-4F}, {-6e-3F, high, 3e-4F}},
      {{0, 1, 2}, {0, 2, 3}}};
  ball.solver.tissue().apply(plan_cut(ball.solver, blade, {.style = style}).edit);
  REQUIRE(ball.lumen->cavity().is_open());
  const double at_first = ball.lumen->cavity().hole_area(ball.solver.positions());
  ball.run(4);
  CHECK(ball.lumen->cavity().hole_area(ball.solver.positions()) > at_first + 1e-6);
  ball.run(100);
  CHECK(std::abs(ball.lumen->pressure()) < 15);
}

// Would catch tissue that goes from the wall and leaves a vacuum.
TEST_CASE("lumen: a crater that does not go through leaves pressure as it was", "[unit]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  LumenSolver ball = blown_up(recipe);
  const float before = ball.lumen->pressure();
  const double volume = ball.volume();
  ball.solver.tissue().apply(puncture(ball.solver.tissue(), (kInner + kOuter) / 2));
  CHECK(!ball.lumen->cavity().is_open());
  CHECK(ball.volume() > volume + 5e-9);
  ball.run(1);
  CHECK(ball.lumen->pressure() == Approx(before).margin(15));
  ball.run(60);
  CHECK(ball.lumen->pressure() == Approx(before).epsilon(0.1));
}

// Would catch ids from before a compaction, and contents that it changes.
TEST_CASE("lumen: it goes along with a compaction", "[unit]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  LumenSolver ball = blown_up(recipe);
  ball.solver.tissue().apply(puncture(ball.solver.tissue(), (kInner + kOuter) / 2));
  ball.run(60);
  const LumenState before = ball.lumen->state();
  const double volume = ball.volume();
  Compaction compaction(ball.solver);
  compaction.build();
  static_cast<void>(compaction.finish(ball.solver));
  CHECK(ball.volume() == Approx(volume).epsilon(1e-6));
  CHECK(ball.lumen->state().amount == before.amount);
  CHECK(ball.lumen->pressure() == before.pressure);
  ball.run(20);
  CHECK(ball.lumen->state().amount == before.amount);
  CHECK(ball.lumen->pressure() == Approx(before.pressure).epsilon(0.01));
}

// Would catch contents that several threads change, or in another order.
TEST_CASE("lumen: the serial bits on any number of threads", "[equivalence]") {
  const LumenRecipe recipe = any_lumen_recipe();
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  options.composition = PlanComposition::separate;
  options.copies = 2;
  INFO(recipe.name);
  options.executor = executor::serial();
  LumenSolver reference(ball_scene(), options, {});
  for (const int threads : {1, 3}) {
    options.executor = executor::threads(threads);
    LumenSolver ball(ball_scene(), options, {});
    for (LumenSolver* const each : {&reference, &ball}) {
      each->lumen->set_reservoir(kLine, 200);
      if (each == &ball || threads == 1) {
        each->run(3);
        each->solver.tissue().apply(puncture(each->solver.tissue(), 1));
        each->run(3);
      }
    }
    for (Index copy = 0; copy < 2; ++copy) {
      CHECK(ball.solver.state_hash(copy) == reference.solver.state_hash(copy));
      CHECK(ball.lumen->state(copy).amount == reference.lumen->state(copy).amount);
      CHECK(ball.lumen->pressure(copy) == reference.lumen->pressure(copy));
    }
    CHECK(ball.lumen->pressure() != 0);
  }
}

// Would catch contents of one copy in another.
TEST_CASE("lumen: each copy moves as a solver of its own", "[unit]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  options.executor = executor::threads(2);
  LumenSolver plain(ball_scene(), options, {}), full(ball_scene(), options, {});
  options.copies = 2;
  LumenSolver both(ball_scene(), options, {});
  const LumenState more{.amount = 1.02 * both.volume()};
  full.lumen->set_state(more);
  both.lumen->set_state(more, 1);
  for (LumenSolver* const each : {&plain, &full, &both}) {
    each->run(4);
  }
  CHECK(both.solver.state_hash(0) == plain.solver.state_hash());
  CHECK(both.solver.state_hash(1) == full.solver.state_hash());
  CHECK(both.lumen->pressure(1) == full.lumen->pressure());
  CHECK(both.lumen->state(1).amount == more.amount);
  CHECK(both.lumen->pressure(0) != both.lumen->pressure(1));
}

// Would catch a state that lacks something of what goes on, and a probe that lets contents out.
TEST_CASE("lumen: from a snapshot and a state it goes on with the same bits", "[unit]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  LumenSolver ball = blown_up(recipe);
  ball.lumen->set_leak(1e-6F);
  ball.run(2);
  const Snapshot snapshot = ball.solver.snapshot();
  const LumenState state = ball.lumen->state();
  static_cast<void>(ball.solver.convergence(kLumenStep));
  CHECK(ball.lumen->state().amount == state.amount);
  CHECK(ball.lumen->pressure() == state.pressure);
  ball.run(3);
  const std::uint64_t expected = ball.solver.state_hash();
  const double amount = ball.lumen->state().amount;
  CHECK(amount < state.amount);
  ball.solver.restore(snapshot);
  ball.lumen->set_state(state);
  ball.run(3);
  CHECK(ball.solver.state_hash() == expected);
  CHECK(ball.lumen->state().amount == amount);
}

}  // namespace pbdsurg
