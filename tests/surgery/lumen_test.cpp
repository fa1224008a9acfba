// SPDX-License-Identifier: Apache-2.0
// Contents of a hollow ball against closed forms, by each method.
#include "pbdsurg/surgery/lumen.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "bench/support/static_energy.h"
#include "tests/support/check_refused.h"
#include "tests/support/lumen_cases.h"
#include "tests/support/meshes.h"

namespace pbdsurg {
namespace {

using testing::any_lumen_recipe;
using testing::Approx;
using testing::ball_scene;
using testing::check_refused;
using testing::kInner;
using testing::kLumenStep;
using testing::kWater;
using testing::LumenRecipe;
using testing::LumenSolver;

constexpr double kAmbient = 101325;  // Pa

// Presses the ball from above and below.
void squeeze(Solver& solver, float force) {
  std::vector<Index> pressed;
  std::vector<Eigen::Vector3f> forces;
  const auto x = solver.tissue().rest_positions();
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    if (std::abs(x[v].y()) > 0.022) {
      pressed.push_back(v);
      forces.emplace_back(0, x[v].y() > 0 ? -force : force, 0);
    }
  }
  for (Eigen::Vector3f& each : forces) {
    each *= 2 / static_cast<float>(forces.size());
  }
  solver.set_forces(pressed, forces);
}

// Pa, that best balances the elastic forces on the wall, in double precision.
double resting_pressure(const Scene& scene, const LumenSolver& ball) {
  bench::Positions positions, areas(scene.positions().size(), Eigen::Vector3d::Zero());
  for (const Eigen::Vector3f& x : ball.solver.positions()) {
    positions.push_back(x.cast<double>());
  }
  for (const Triangle& triangle : ball.lumen->cavity().triangles()) {
    const Eigen::Vector3d a = positions[triangle[0]];
    const Eigen::Vector3d area = (positions[triangle[1]] - a).cross(positions[triangle[2]] - a) / 2;
    for (const Index v : triangle) {
      areas[v] += area / 3;
    }
  }
  const bench::Positions forces = bench::StaticEnergy(scene).forces(positions);
  double work = 0, square = 0;
  for (std::size_t v = 0; v < areas.size(); ++v) {
    work -= forces[v].dot(areas[v]);
    square += areas[v].squaredNorm();
  }
  return work / square;
}

// How far the contents are from their law, as a share.
double law_error(const LumenSolver& ball, bool is_gas) {
  const LumenState state = ball.lumen->state();
  const double at_ambient = ball.volume() * (is_gas ? 1 + double{state.pressure} / kAmbient : 1);
  return std::abs(at_ambient / state.amount - 1);
}

}  // namespace

// Would catch a pressure that is not a force per area, a multiplier that substeps or sweeps scale,
// and a wall that is pushed the wrong way.
TEST_CASE("lumen: a hollow ball widens as Lame's solution has it", "[validation]") {
  const LumenRecipe recipe = any_lumen_recipe();
  const bool is_gas = GENERATE(true, false);
  INFO(recipe.name << ", gas " << is_gas);
  const Scene scene = ball_scene();
  LumenSolver ball(scene, recipe.options, is_gas ? LumenOptions{} : kWater);
  const double before = ball.volume();
  constexpr double kWidening = 0.01;
  ball.lumen->set_inflow(static_cast<float>(kWidening * before / (40 * double{kLumenStep})));
  ball.run(40);
  ball.lumen->set_inflow(0);
  ball.run(60);
  const double widened = ball.volume() - before;
  CHECK(widened == Approx(kWidening * before).epsilon(is_gas ? 0.03 : 1e-3));
  CHECK(ball.lumen->pressure() ==
        Approx(widened / testing::lame_compliance(10e3, 0.3)).epsilon(0.03));
  // ten sweeps of projections leave forces within tissue some percent off
  const bool has_blocks = recipe.options.method != SolverMethod::projection;
  CHECK(ball.lumen->pressure() ==
        Approx(resting_pressure(scene, ball)).epsilon(has_blocks ? 0.005 : 0.03));
  CHECK(ball.lumen->state().amount == Approx((1 + kWidening) * before).epsilon(1e-5));
}

// Would catch contents that give way while they move, and a gas that answers late.
TEST_CASE("lumen: contents keep to their law while the ball is squeezed", "[validation]") {
  const LumenRecipe recipe = any_lumen_recipe();
  const bool is_gas = GENERATE(true, false);
  INFO(recipe.name << ", gas " << is_gas);
  LumenSolver ball(ball_scene(0.45F), recipe.options, is_gas ? LumenOptions{} : kWater);
  ball.run(1);
  const double amount = ball.lumen->state().amount;
  squeeze(ball.solver, 0.1F);
  double worst = 0;
  for (int step = 0; step < 60; ++step) {
    ball.run(1);
    worst = std::max(worst, law_error(ball, is_gas));
  }
  CHECK(worst < 1e-3);
  CHECK(ball.lumen->state().amount == amount);
  CHECK(ball.lumen->pressure() > 20);
  const auto x = ball.solver.positions();
  const auto top = std::ranges::max_element(x, {}, [](const auto& p) { return p.y(); });
  CHECK(top->y() < 0.98 * testing::kOuter);
}

// Would catch weight that squeezes a liquid out.
TEST_CASE("lumen: a liquid keeps its volume in a ball that sags", "[validation]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  Scene scene = ball_scene(0.45F);
  scene.set_gravity({0, -9.81F, 0});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -0.022; });
  LumenSolver ball(scene, recipe.options, kWater);
  const double before = ball.volume();
  double worst = 0;
  for (int step = 0; step < 60; ++step) {
    ball.run(1);
    worst = std::max(worst, std::abs(ball.volume() / before - 1));
  }
  CHECK(worst < 1e-3);
  CHECK(ball.lumen->pressure() > 10);
}

// Would catch an orifice that lets through more or less than its law, or on as pressure falls, and
// leaks that take more in long substeps. The reference knows the wall from slow filling alone.
TEST_CASE("lumen: a pricked ball empties in the time of its orifice law", "[validation][long]") {
  const LumenRecipe recipe = any_lumen_recipe();
  const bool is_gas = GENERATE(true, false);
  INFO(recipe.name << ", gas " << is_gas);
  const LumenOptions contents = is_gas ? LumenOptions{} : kWater;
  LumenSolver ball(ball_scene(), recipe.options, contents);
  // the wall at rest: amounts by pressure, from 300 Pa down
  struct Rest {
    double pressure, amount;
  };
  std::vector<Rest> curve;
  for (float pressure = 300; pressure > 8; pressure -= pressure > 40 ? 20 : 5) {
    ball.lumen->set_reservoir(1e-4F, pressure);
    ball.run(curve.empty() ? 200 : 40);
    REQUIRE(ball.lumen->pressure() == Approx(pressure).epsilon(0.01));
    curve.push_back({ball.lumen->pressure(), ball.lumen->state().amount});
  }
  const float area = is_gas ? 1e-6F : 2e-5F;  // m^2
  double expected = 0;                        // s
  for (std::size_t i = 1; i < curve.size(); ++i) {
    const double pressure = (curve[i - 1].pressure + curve[i].pressure) / 2;
    const double flow = double{contents.discharge} * double{area} *
                        std::sqrt(2 * pressure / double{contents.density});
    expected += (curve[i - 1].amount - curve[i].amount) / flow;
  }
  ball.lumen->set_reservoir(1e-4F, 300);
  ball.run(200);
  ball.lumen->set_reservoir(0, 0);
  ball.lumen->set_leak(area);
  const double last = curve.back().amount;
  double time = 0, before = ball.lumen->state().amount;
  while (true) {
    ball.run(1);
    const double now = ball.lumen->state().amount;
    if (now <= last) {
      time += double{kLumenStep} * (before - last) / (before - now);
      break;
    }
    time += double{kLumenStep};
    before = now;
    REQUIRE(time < 2 * expected);
  }
  CHECK(time == Approx(expected).epsilon(0.05));
  CHECK(expected > 20 * double{kLumenStep});
}

// Would catch forces that do not sum to zero, as of a wall that is not closed.
TEST_CASE("lumen: a free ball that is blown up stays where it is", "[property]") {
  const LumenRecipe recipe = any_lumen_recipe();
  INFO(recipe.name);
  const Scene scene = ball_scene();
  LumenSolver ball(scene, recipe.options, {});
  ball.lumen->set_reservoir(1e-4F, 300);
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero(), moment = Eigen::Vector3d::Zero();
  double size = 0, angular_size = 0, largest = 0;
  for (int step = 0; step < 20; ++step) {
    ball.run(1);
    const auto x = ball.solver.positions(), v = ball.solver.velocities();
    momentum = moment = Eigen::Vector3d::Zero();
    size = angular_size = 0;
    for (std::size_t i = 0; i < v.size(); ++i) {
      const Eigen::Vector3d own = scene.masses()[i] * v[i].cast<double>();
      const Eigen::Vector3d turn = x[i].cast<double>().cross(own);
      momentum += own;
      moment += turn;
      size += own.norm();
      angular_size += x[i].cast<double>().norm() * own.norm();
    }
    largest = std::max(largest, size);
    CHECK(momentum.norm() < 1e-4 * largest);
    CHECK(moment.norm() < 0.01 * std::max(angular_size, kInner * largest));
  }
  CHECK(ball.volume() > 1.02 * 4.18879 * kInner * kInner * kInner);
}

// Would catch a coarse correction that knows nothing of the lumen, or leaves its wall out: the ball
// would tremble for ever.
TEST_CASE("lumen: a ball that hangs comes to rest", "[validation]") {
  const bool is_gas = GENERATE(true, false);
  Scene scene = ball_scene(0.45F, 30e3F);
  scene.set_gravity({0, -9.81F, 0});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() > 0.5 * testing::kOuter; });
  LumenSolver ball(scene, {.damping = 2}, is_gas ? LumenOptions{} : kWater);
  ball.lumen->set_reservoir(1e-4F, 300);
  ball.run(300);
  CHECK(ball.lumen->pressure() == Approx(300).epsilon(0.005));
  for (const Eigen::Vector3f& velocity : ball.solver.velocities()) {
    REQUIRE(velocity.norm() < 1e-4);
  }
}

// Would catch a correction that two constraints on one volume, or more than it has room for, upset.
TEST_CASE("lumen: many lumens, some of the same hollow, keep their volumes", "[property]") {
  constexpr double kEdge = 4e-3;  // m
  Scene scene;
  Material material;
  material.youngs_modulus = 10e3F;
  const TetMesh box = testing::make_box({9, 3, 9}, kEdge);
  std::vector<Tet> tets;
  for (const Tet& tet : box.tets()) {
    Eigen::Vector3d cube = Eigen::Vector3d::Zero();
    for (const Index v : tet) {
      cube += box.positions()[v] / (4 * kEdge);
    }
    const bool is_hollow = std::lround(std::floor(cube.x())) % 2 == 1 &&
                           std::lround(std::floor(cube.z())) % 2 == 1 && cube.y() > 1 &&
                           cube.y() < 2;
    if (!is_hollow) {
      tets.push_back(tet);
    }
  }
  scene.add_body("box", TetMesh({box.positions().begin(), box.positions().end()}, std::move(tets)),
                 material);
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 0.5 * kEdge; });
  Solver solver(scene, {.damping = 10});
  const auto walls = find_cavities(solver.tissue(), 0);
  REQUIRE(walls.size() == 16);
  std::vector<std::shared_ptr<Lumen>> lumens;
  for (std::size_t i = 0; i < walls.size() + 2; ++i) {
    lumens.push_back(std::make_shared<Lumen>(solver.tissue(), walls[i / 3], kWater));
    solver.add_constraints(lumens.back());
  }
  for (int step = 0; step < 100; ++step) {
    REQUIRE(solver.step(kLumenStep).non_finite_vertices == 0);
  }
  const std::vector<Eigen::Vector3f> x = solver.positions();
  for (const std::shared_ptr<Lumen>& lumen : lumens) {
    CHECK(lumen->cavity().volume(x) == Approx(kEdge * kEdge * kEdge).epsilon(1e-3));
  }
  for (const Eigen::Vector3f& velocity : solver.velocities()) {
    REQUIRE(velocity.norm() < 1e-3);
  }
}

// Would catch contents that are taken where there are none.
TEST_CASE("lumen: nothing more comes out than there is", "[unit]") {
  LumenSolver ball(ball_scene(), {}, {});
  const double before = ball.volume();
  ball.lumen->set_inflow(static_cast<float>(-before));  // all of it within a second
  ball.run(30);
  CHECK(ball.lumen->state().amount == Approx(0.85 * before).epsilon(1e-4));
  CHECK(ball.lumen->pressure() < 0);
  CHECK(ball.volume() < 0.9 * before);
}

// Would catch numbers that are taken though they mean nothing.
TEST_CASE("lumen: what is out of range is refused", "[unit]") {
  LumenSolver ball(ball_scene(), {}, {});
  const auto refuse = [&](const LumenOptions& options, const char* what) {
    check_refused(
        [&] { const Lumen lumen(ball.solver.tissue(), ball.lumen->cavity().triangles(), options); },
        what);
  };
  refuse({.density = 0}, "density is 0 kg/m^3; it must be positive and finite");
  refuse({.ambient_pressure = -1}, "ambient_pressure is -1 Pa");
  refuse({.discharge = 1.5F}, "discharge is 1.5; it must be in (0, 1]");
  Lumen& lumen = *ball.lumen;
  check_refused([&] { lumen.set_inflow(NAN); }, "flow is nan; it must be finite");
  check_refused([&] { lumen.set_leak(-1); }, "area is -1; it must be finite and not negative");
  check_refused([&] { lumen.set_reservoir(-1, 0); }, "area is -1");
  check_refused([&] { lumen.set_reservoir(1, INFINITY); }, "pressure is inf; it must be finite");
  check_refused([&] { lumen.set_state({.amount = -1}); }, "amount is -1");
  check_refused([&] { lumen.set_state({.pressure = -2e5F}); }, "pressure is -200000");
  check_refused([&] { lumen.set_state({}, -1); }, "copy is -1");
  CHECK_THROWS_AS(lumen.pressure(-1), InvalidArgument);
  LumenSolver other(ball_scene(), {}, {});
  const auto stray = std::make_shared<Lumen>(ball.solver.tissue(), lumen.cavity().triangles());
  other.solver.add_constraints(stray);
  check_refused([&] { other.solver.step(kLumenStep); }, "a lumen");
  lumen.set_state({.amount = 1e-5}, 3);
  check_refused([&] { ball.solver.step(kLumenStep); }, "copy is 3; it must be one of the solver's");
}

}  // namespace pbdsurg
