// SPDX-License-Identifier: Apache-2.0
// What forces at vertices, gravity at run time and pressure in a lumen do, against closed forms and
// static solutions of the same mesh in double precision, and what a step with them costs, in pairs
// by turns.
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/lumen.h"

#include "apps/support/executors.h"
#include "bench/support/neo_hookean.h"
#include "bench/support/program.h"
#include "bench/support/static_energy.h"
#include "bench/support/table_files.h"
#include "bench/support/timing.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kEdge = 4e-3;  // m
constexpr float kStep = 2e-3F;  // s

struct Arguments {
  std::filesystem::path out = "out/tables";
  std::vector<std::string> executors{"serial", "threads:1", "best"};
  bool quick = false;
};

struct Method {
  const char* name;
  SolverOptions options;
};

// With those numbers that bring each to rest.
const std::array kMethods{
    Method{"default", {}},
    Method{"vertex blocks, 30 sweeps", {.method = SolverMethod::vertex_block, .iterations = 30}},
    Method{"vertex blocks, BDF2", {.integration = TimeIntegration::bdf2}},
    Method{"projections, 10 sweeps", {.method = SolverMethod::projection, .iterations = 10}},
    Method{"explicit steps", {.method = SolverMethod::explicit_steps}}};

// What a method on a backend comes to, and what it should.
struct Outcome {
  double value, expected;
};

struct Case {
  const char* name;
  const char* unit;
  std::function<Outcome(SolverOptions)> run;
  bool has_lumen = false;  // which takes sweeps
};

std::vector<Index> vertices_where(const Scene& scene,
                                  const std::function<bool(const Eigen::Vector3d&)>& is_in) {
  std::vector<Index> found;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (is_in(scene.positions()[v])) {
      found.push_back(v);
    }
  }
  return found;
}

Scene make_block(std::array<Index, 3> cells) {
  Scene scene;
  scene.add_body("block", testing::make_box(cells, kEdge, 0.1), neo_hookean(10e3, 0.4));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 0.5 * kEdge; });
  return scene;
}

void step(Solver& solver, int count) {
  for (int i = 0; i < count; ++i) {
    solver.step(kStep);
  }
}

// mm, of the vertices' mean way along a direction.
template <class Places>
double mean_way(const Scene& scene, const Places& places, const std::vector<Index>& vertices,
                const Eigen::Vector3d& along) {
  double sum = 0;
  for (const Index v : vertices) {
    sum += along.dot(places[v].template cast<double>() - scene.positions()[v]);
  }
  return 1e3 * sum / static_cast<double>(vertices.size());
}

// Of a block whose top is pulled aside by 0.05 N, 20 % of that across.
Outcome pull_block(SolverOptions options) {
  const Scene scene = make_block({4, 4, 4});
  std::vector<Index> pulled =
      vertices_where(scene, [](const Eigen::Vector3d& x) { return x.y() > 3.5 * kEdge; });
  for (const Index v : vertices_where(scene, [](const Eigen::Vector3d& x) {
         return std::abs(x.y() - 3 * kEdge) < 0.5 * kEdge && x.x() > 3.5 * kEdge;
       })) {
    pulled.push_back(v);
  }
  const Eigen::Vector3d pull =
      0.05 / static_cast<double>(pulled.size()) * Eigen::Vector3d(1, 0.2, 0).normalized();
  StaticEnergy energy(scene);
  for (const Index v : pulled) {
    energy.pull(v, pull);
  }
  const Positions rest =
      find_equilibrium(energy, Positions(scene.positions().begin(), scene.positions().end()));
  options.damping = 30;
  Solver solver(scene, options);
  solver.set_forces(pulled, std::vector<Eigen::Vector3f>(pulled.size(), pull.cast<float>()));
  step(solver, 400);
  const Eigen::Vector3d along = pull.normalized();
  return {mean_way(scene, solver.positions(), pulled, along), mean_way(scene, rest, pulled, along)};
}

// Gravity of a block that is turned to its side while it moves.
Outcome turn_block(SolverOptions options) {
  const Eigen::Vector3f turned(9.81F, 0, 0);
  Scene scene = make_block({3, 6, 3});
  options.damping = 30;
  Solver solver(scene, options);
  step(solver, 20);
  solver.set_gravity(0, turned);
  step(solver, 600);
  scene.set_gravity(turned);
  const StaticEnergy energy(scene);
  const Positions rest =
      find_equilibrium(energy, Positions(scene.positions().begin(), scene.positions().end()));
  const std::vector<Index> top =
      vertices_where(scene, [](const Eigen::Vector3d& x) { return x.y() > 5.5 * kEdge; });
  return {mean_way(scene, solver.positions(), top, {1, 0, 0}),
          mean_way(scene, rest, top, {1, 0, 0})};
}

// A strip along x without holds or weight, whose fibres lie along a direction.
Scene make_strip(const Eigen::Vector3f& direction) {
  Scene scene;
  scene.add_body("strip", testing::make_box({6, 2, 2}, kEdge), neo_hookean(10e3, 0.4));
  scene.set_fibres(0, std::vector<Fibre>(scene.tets().size(), {direction, 20e3F}));
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

// %, by which a strip stretches that is pulled by its ends.
// @param fibre_stiffness  Pa, along the strip
Outcome pull_strip(SolverOptions options, const Eigen::Vector3f& direction,
                   double fibre_stiffness) {
  constexpr double kLength = 6 * kEdge;
  const Scene scene = make_strip(direction);
  const NeoHookeanModuli moduli(scene.body(0).material);
  const double stress = uniaxial_stress(moduli, fibre_stiffness, 1.25);
  const std::vector<Index> all = vertices_where(scene, [](const Eigen::Vector3d&) { return true; });
  std::vector<Eigen::Vector3f> loads(all.size(), Eigen::Vector3f::Zero());
  for (const Tet& tet : scene.tets()) {  // of each triangle's traction a third at its corners
    for (const auto& [a, b, c] : kTetTriangles) {
      const std::array<Index, 3> face{tet[a], tet[b], tet[c]};
      const Eigen::Vector3d &x = scene.positions()[face[0]], &y = scene.positions()[face[1]],
                            &z = scene.positions()[face[2]];
      for (const double end : {0.0, kLength}) {
        if (std::abs(x.x() - end) + std::abs(y.x() - end) + std::abs(z.x() - end) < 1e-9) {
          const double pull = (end > 0 ? 1 : -1) * stress * (y - x).cross(z - x).norm() / 6;
          for (const Index v : face) {
            loads[v].x() += static_cast<float>(pull);
          }
        }
      }
    }
  }
  options.damping = 30;
  Solver solver(scene, options);
  solver.set_forces(all, loads);
  step(solver, 400);
  const auto x = solver.positions();
  const auto end_at = [&](double end) {
    const std::vector<Index> face = vertices_where(
        scene, [&](const Eigen::Vector3d& at) { return std::abs(at.x() - end) < 1e-9; });
    double sum = 0;
    for (const Index v : face) {
      sum += x[v].x();
    }
    return sum / static_cast<double>(face.size());
  };
  return {100 * ((end_at(kLength) - end_at(0)) / kLength - 1), 25};
}

// Of a bar of oblique fibres that sags.
Outcome hang_bar(SolverOptions options) {
  Scene scene;
  scene.add_body("bar", testing::make_box({6, 2, 2}, kEdge, 0.1), neo_hookean(10e3, 0.4));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kEdge; });
  scene.set_fibres(0, std::vector<Fibre>(scene.tets().size(),
                                         {Eigen::Vector3f(2, 1, 0.5F).normalized(), 100e3F}));
  const Positions rest = find_equilibrium(
      StaticEnergy(scene), Positions(scene.positions().begin(), scene.positions().end()));
  options.damping = 30;
  Solver solver(scene, options);
  step(solver, 800);
  const std::vector<Index> end =
      vertices_where(scene, [](const Eigen::Vector3d& x) { return x.x() > 5.5 * kEdge; });
  return {mean_way(scene, solver.positions(), end, {0, -1, 0}),
          mean_way(scene, rest, end, {0, -1, 0})};
}

// m/s, of a free body after 50 ms of a force of five times its weight.
Outcome push_free_body(SolverOptions options) {
  Scene scene;
  scene.add_body("cube", testing::make_box({3, 3, 3}, kEdge, 0.1), neo_hookean(10e3, 0.4));
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, options);
  solver.set_forces([&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
    return static_cast<float>(scene.masses()[v]) * Eigen::Vector3f(0, 50, 0);
  });
  step(solver, 25);
  double momentum = 0, mass = 0;
  const std::vector<Eigen::Vector3f> velocities = solver.velocities();
  for (std::size_t v = 0; v < velocities.size(); ++v) {
    momentum += scene.masses()[v] * velocities[v].y();
    mass += scene.masses()[v];
  }
  return {momentum / mass, 50 * 25 * double{kStep}};
}

// A hollow ball, with a line to a lumen.
struct Ball {
  static constexpr double kInner = 20e-3, kOuter = 26e-3;  // m

  Scene scene;
  Solver solver;
  std::shared_ptr<Lumen> lumen;

  Ball(const SolverOptions& options, const LumenOptions& contents)
      : scene(make_scene()), solver(scene, options) {
    lumen =
        std::make_shared<Lumen>(solver.tissue(), find_cavities(solver.tissue(), 0).at(0), contents);
    solver.add_constraints(lumen);
  }

  [[nodiscard]] double volume() const { return lumen->cavity().volume(solver.positions()); }

 private:
  static Scene make_scene() {
    TetrahedralizeOptions options;
    options.spacing = kEdge;
    const ImplicitShape ball = sphere_shape({0, 0, 0}, kOuter);
    Scene scene;
    scene.add_body("ball", tetrahedralize(shell_shape(ball, kOuter - kInner), options).mesh,
                   neo_hookean(10e3, 0.3));
    scene.set_gravity(Eigen::Vector3f::Zero());
    return scene;
  }
};

constexpr LumenOptions kWater{.contents = LumenContents::liquid, .density = 1000};

// Pa, in a ball that water widens by 1 %; by Lame's solution of small strains.
Outcome widen_ball(SolverOptions options) {
  options.damping = 30;
  Ball ball(options, kWater);
  const double before = ball.volume(), wider = 0.01 * before;
  ball.lumen->set_inflow(static_cast<float>(wider / (100 * double{kStep})));
  step(ball.solver, 100);
  ball.lumen->set_inflow(0);
  step(ball.solver, 200);
  constexpr double kA = Ball::kInner, kB = Ball::kOuter, kYoung = 10e3, kPoisson = 0.3;
  const double way = std::pow(kA, 3) / (kYoung * (std::pow(kB, 3) - std::pow(kA, 3))) *
                     ((1 - 2 * kPoisson) * kA + (1 + kPoisson) * std::pow(kB, 3) / (2 * kA * kA));
  return {ball.lumen->pressure(), wider / (4 * std::numbers::pi * kA * kA * way)};
}

// ml, of air in a ball that is squeezed flat, times its absolute pressure over ambient.
Outcome squeeze_ball(SolverOptions options) {
  options.damping = 30;
  Ball ball(options, {});
  step(ball.solver, 1);
  const auto x = ball.solver.tissue().rest_positions();
  ball.solver.set_forces([&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
    return {0, x[v].y() > 0.022 ? -2e-4F : x[v].y() < -0.022 ? 2e-4F : 0, 0};
  });
  step(ball.solver, 100);
  const LumenState state = ball.lumen->state();
  const double absolute =
      1 + double{state.pressure} / double{ball.lumen->options().ambient_pressure};
  return {1e6 * ball.volume() * absolute, 1e6 * state.amount};
}

// ms, of a step with a lumen and of one without.
Outcome time_lumen(const SolverOptions& options, bool quick) {
  Ball filled(options, {});
  Solver plain(filled.scene, options);
  std::vector<double> with, without;
  for (int pair = 0; pair < (quick ? 10 : 150); ++pair) {
    without.push_back(time_of([&] { plain.step(kStep); }));
    with.push_back(time_of([&] { filled.solver.step(kStep); }));
  }
  constexpr double kShare = 0.1;
  return {quantile(with, kShare), quantile(without, kShare)};
}

// ms, of a step with a force at each vertex, or a gravity of the body's own, and of one without.
Outcome time_steps(const SolverOptions& options, bool has_forces, bool quick) {
  const Scene scene =
      make_block(quick ? std::array<Index, 3>{6, 6, 6} : std::array<Index, 3>{16, 16, 12});
  Scene other = scene;
  other.add_body("far", testing::make_box({1, 1, 1}, kEdge), neo_hookean(10e3, 0.4));
  Solver plain(other, options), loaded(other, options);
  if (has_forces) {
    loaded.set_forces([&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
      return static_cast<float>(other.masses()[v]) * Eigen::Vector3f(1, 0, 0);
    });
  } else {
    loaded.set_gravity(0, {0, -9.8F, 0});
  }
  std::vector<double> with, without;
  for (int pair = 0; pair < (quick ? 10 : 150); ++pair) {
    without.push_back(time_of([&] { plain.step(kStep); }));
    with.push_back(time_of([&] { loaded.step(kStep); }));
  }
  constexpr double kShare = 0.1;  // of turns, which others on the machine disturb the least
  return {quantile(with, kShare), quantile(without, kShare)};
}

void run(Arguments arguments) {
  if (arguments.quick) {
    arguments.executors = {"threads:1"};
  }
  const std::vector<Case> cases{
      {"block pulled aside by 0.05 N at 30 vertices", "mm", pull_block},
      {"gravity turned by a quarter in motion", "mm", turn_block},
      {"free body pushed for 50 ms", "m/s", push_free_body},
      {"time of a step with a force at each vertex", "ms",
       [&](const SolverOptions& options) { return time_steps(options, true, arguments.quick); }},
      {"time of a step with a body's own gravity", "ms",
       [&](const SolverOptions& options) { return time_steps(options, false, arguments.quick); }},
      {"pressure of a hollow ball that water widens by 1 %", "Pa", widen_ball, true},
      {"strip pulled along its fibres, by the closed form", "%",
       [](const SolverOptions& options) {
         return pull_strip(options, Eigen::Vector3f::UnitX(), 20e3);
       }},
      {"strip pulled across its fibres, by the closed form", "%",
       [](const SolverOptions& options) {
         return pull_strip(options, Eigen::Vector3f::UnitY(), 0);
       }},
      {"bar of oblique fibres that sags", "mm", hang_bar},
      {"air in a hollow ball that is squeezed, by p V", "ml", squeeze_ball, true},
      {"time of a step with a lumen of gas", "ms",
       [&](const SolverOptions& options) { return time_lumen(options, arguments.quick); }, true}};
  const std::vector<Column> columns{{"method", "method", 0},     {"backend", "backend", 0},
                                    {"unit", "unit", 0},         {"value", "value", 4},
                                    {"expected", "expected", 4}, {"error_percent", "error, %", 2}};
  Json rows = Json::array();
  std::string text =
      "# Forces\n\n- value: of the solver; expected: of the static solution of the same mesh by "
      "Newton's method in double precision, or of the closed form (of pressure Lame's, of small "
      "strains); of time, that of a step "
      "without, of pairs by turns the quickest tenth\n\n" +
      markdown_header("case", columns);
  for (const Case& each : cases) {
    for (const Method& method : kMethods) {
      for (const std::string& executor : arguments.executors) {
        SolverOptions options = method.options;
        options.executor = programs::executor_named(executor);
        if (each.has_lumen && options.method == SolverMethod::explicit_steps) {
          continue;
        }
        const Outcome outcome = each.run(options);
        rows.push_back(
            {{"case", each.name},
             {"method", method.name},
             {"backend", options.executor.name()},
             {"unit", each.unit},
             {"value", rounded(outcome.value, 1e5)},
             {"expected", rounded(outcome.expected, 1e5)},
             {"error_percent", rounded(100 * (outcome.value / outcome.expected - 1), 1e3)}});
        text += markdown_line(each.name, rows.back(), columns);
      }
    }
  }
  std::fputs(text.c_str(), stdout);
  write_table(arguments.out, "forces", rows, text);
}

}  // namespace
}  // namespace pbdsurg::bench

int main(int argc, char** argv) {
  CLI::App app("What forces and gravity from outside do to tissue, and cost.", "forces");
  pbdsurg::bench::Arguments arguments;
  auto* const executors = app.add_option("--executor", arguments.executors,
                                         "such as threads:1 or cuda; may be several");
  app.add_flag("--quick", arguments.quick, "one thread, a small block for times: to see it work")
      ->excludes(executors);
  return pbdsurg::bench::run_program(app, argc, argv, arguments.out,
                                     [&] { pbdsurg::bench::run(arguments); });
}
