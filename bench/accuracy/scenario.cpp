// SPDX-License-Identifier: Apache-2.0
#include "bench/accuracy/scenario.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>
#include <utility>

#include "pbdsurg/base/error.h"

#include "bench/support/neo_hookean.h"
#include "bench/support/paper_step.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr double kSeconds = 0.04;
constexpr double kTipShare = 0.05;  // of the vertices

Scene make_scene(const TetMesh& organ, const Material& material) {
  Scene scene = make_organ_scene(organ, material);
  scene.set_gravity({0, 0, -9.81F});
  return scene;
}

Positions shifted(std::span<const Eigen::Vector3d> positions, double by) {
  Positions result(positions.begin(), positions.end());
  for (Eigen::Vector3d& x : result) {
    x += Eigen::Vector3d::Constant(by);
  }
  return result;
}

Motion at_rest(const Positions& x) {
  return {x, Positions(x.size(), Eigen::Vector3d::Zero())};
}

Eigen::Vector3d mean_tip(const Scene& scene, const Positions& x) {
  std::vector<Index> order(x.size());
  for (std::size_t v = 0; v < x.size(); ++v) {
    order[v] = static_cast<Index>(v);
  }
  const auto count =
      std::max<std::size_t>(1, std::lround(kTipShare * static_cast<double>(x.size())));
  std::ranges::nth_element(order, order.begin() + static_cast<std::ptrdiff_t>(count) - 1,
                           std::greater<>(), [&](Index v) { return scene.positions()[v].x(); });
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < count; ++i) {
    sum += x[order[i]];
  }
  return sum / static_cast<double>(count);
}

}  // namespace

Scenario::Scenario(const TetMesh& organ, std::string mesh_name, double youngs_modulus,
                   double reference_substep, bool quick)
    : name("organ of " + std::to_string(std::lround(youngs_modulus / 1000)) + " kPa"),
      mesh(std::move(mesh_name)),
      scene(make_scene(organ, neo_hookean(youngs_modulus, 0.45))),
      seconds(quick ? kSeconds / 10 : kSeconds) {
  for (const Eigen::Vector3d& x : organ.positions()) {
    start.push_back({1.1 * x.x(), x.y(), x.z()});
  }
  reference = integrate(scene, start, seconds, reference_substep);
  const double energy = total_energy(scene, reference) / total_energy(scene, at_rest(start));
  if (!(std::abs(energy - 1) < 0.01)) {
    throw Error("the reference of " + name + ", " + mesh + ", ends with " + std::to_string(energy) +
                " of its energy: substeps of " + std::to_string(reference_substep) +
                " s are too long");
  }
}

Scenario Scenario::moved(double by) const {
  Scenario result = *this;
  result.away += by;
  result.scene = make_scene(
      TetMesh(shifted(scene.positions(), by), {scene.tets().begin(), scene.tets().end()}),
      scene.bodies()[0].material);
  result.start = shifted(start, by);
  result.reference.x = shifted(reference.x, by);
  return result;
}

std::vector<Setting> make_settings() {
  const auto blocks = [](int substeps, int sweeps, float over_relaxation) {
    SolverOptions options;
    options.method = SolverMethod::vertex_block;
    options.substeps = substeps;
    options.iterations = sweeps;
    options.over_relaxation = over_relaxation;
    return options;
  };
  const auto projections = [](int substeps, int sweeps) {
    SolverOptions options;
    options.method = SolverMethod::projection;
    options.substeps = substeps;
    options.iterations = sweeps;
    return options;
  };
  const auto bdf2 = [](SolverOptions options) {
    options.integration = TimeIntegration::bdf2;
    return options;
  };
  const auto corrected = [](SolverOptions options) {
    options.coarse_correction = CoarseCorrection::on;
    return options;
  };
  const auto explicit_steps = [](int substeps) {
    SolverOptions options;
    options.method = SolverMethod::explicit_steps;
    options.substeps = substeps;
    options.longest_step = substeps == kAutomatic ? 5e-3F : options.longest_step;
    return options;
  };
  return {{"default", {}},
          {"explicit", explicit_steps(kAutomatic)},
          {"explicit", explicit_steps(10)},
          {"projections", projections(5, 1)},
          {"projections", projections(10, 1)},
          {"projections", projections(20, 1)},
          {"projections", projections(1, 10)},
          {"vertex blocks", blocks(1, 2, 1.3F)},
          {"vertex blocks", blocks(1, 5, 1)},
          {"vertex blocks", blocks(1, 10, 1)},
          {"vertex blocks", blocks(1, 10, 1.7F)},
          {"vertex blocks", blocks(2, 3, 1.7F)},
          {"vertex blocks", blocks(5, 2, 1.3F)},
          {"vertex blocks", blocks(10, 2, 1.3F)},
          {"projections", bdf2(projections(10, 1))},
          {"vertex blocks", bdf2(blocks(1, 5, 1))},
          {"vertex blocks", bdf2(blocks(1, 10, 1))},
          {"vertex blocks", bdf2(blocks(5, 2, 1.3F))},
          {"vertex blocks", bdf2(blocks(10, 2, 1.3F))},
          {"coarse correction", corrected(blocks(1, 2, 1))},
          {"coarse correction", bdf2(corrected(blocks(1, 2, 1)))},
          {"coarse correction", bdf2(corrected(blocks(1, 3, 1.2F)))},
          {"coarse correction", bdf2(corrected(blocks(2, 2, 1)))},
          {"coarse correction", bdf2(corrected(blocks(5, 2, 1)))}};
}

Accuracy measure(const Scenario& scenario, SolverOptions options, double dt) {
  Solver solver(scenario.scene, std::move(options));
  std::vector<Eigen::Vector3f> start;
  for (const Eigen::Vector3d& x : scenario.start) {
    start.push_back(x.cast<float>());
  }
  solver.write_positions(start);
  solver.step(static_cast<float>(dt));  // warm, then again from the start
  solver.write_positions(start);
  std::vector<double> times;
  const auto steps = static_cast<int>(std::lround(scenario.seconds / dt));
  for (int i = 0; i < steps; ++i) {
    times.push_back(time_of([&] { solver.step(static_cast<float>(dt)); }));
  }
  Motion end;
  for (const Eigen::Vector3f& x : solver.positions()) {
    end.x.push_back(x.cast<double>());
  }
  for (const Eigen::Vector3f& v : solver.velocities()) {
    end.v.push_back(v.cast<double>());
  }
  if (solver.last_report().non_finite_vertices > 0) {
    throw Error(scenario.name + ", " + scenario.mesh + ", steps of " + std::to_string(1e3 * dt) +
                " ms: the end is not finite");
  }
  double sum = 0;
  for (std::size_t v = 0; v < end.x.size(); ++v) {
    sum += (end.x[v] - scenario.reference.x[v]).squaredNorm();
  }
  return {
      median(times), 1e3 * std::sqrt(sum / static_cast<double>(end.x.size())),
      1e3 *
          (mean_tip(scenario.scene, end.x) - mean_tip(scenario.scene, scenario.reference.x)).norm(),
      total_energy(scenario.scene, end) / total_energy(scenario.scene, at_rest(scenario.start))};
}

}  // namespace pbdsurg::bench
