// SPDX-License-Identifier: Apache-2.0
#include "bench/convergence/measure.h"

#include <cstring>
#include <limits>
#include <utility>

#include "pbdsurg/base/error.h"

#include "bench/support/paper_step.h"
#include "bench/support/static_energy.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

Positions read(const Stepper& stepper) {
  Positions positions;
  for (const Eigen::Vector3f& x : stepper.positions()) {
    positions.push_back(x.cast<double>());
  }
  return positions;
}

// Substep by substep, so that the last can be looked at.
double step_residual(const Problem& problem, const Method& method, const Setting& setting) {
  const auto stepper = method.make({1, setting.iterations});
  stepper->write_positions(stretched_positions(problem.bar.scene));
  const double h = static_cast<double>(problem.dt) / setting.substeps;
  const double keep = 1 / (1 + problem.damping * h);
  const Eigen::Vector3d kick = h * problem.bar.scene.gravity().cast<double>();
  Positions previous = read(*stepper);
  Positions x = previous;
  Positions inertial = x;
  for (int substep = 0; substep < setting.substeps; ++substep) {
    for (std::size_t v = 0; v < x.size(); ++v) {
      inertial[v] = x[v] + keep * (x[v] - previous[v]) + h * kick;
    }
    previous = std::exchange(x, {});
    stepper->step(static_cast<float>(h));
    x = read(*stepper);
  }
  const Scene& scene = problem.bar.scene;
  const Positions elastic_and_weight = StaticEnergy(scene).forces(x);
  double sum = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    if (!scene.is_fixed(static_cast<Index>(v))) {
      const double mass = scene.masses()[v];
      // the inertial position holds the weight already
      sum += (elastic_and_weight[v] - mass * scene.gravity().cast<double>() -
              mass / (h * h) * (x[v] - inertial[v]))
                 .norm();
    }
  }
  return sum / problem.bar.weight;
}

// One setting's trajectory, and the times of all its repetitions.
struct Trajectory {
  RestCurve curve;
  std::vector<std::vector<double>> times;  // [step][repetition] ms
  std::vector<Eigen::Vector3f> end;
};

void repeat(Trajectory& trajectory, const Problem& problem, const StaticEnergy& energy) {
  RestCurve& curve = trajectory.curve;
  const Eigen::Vector3d tip = tip_displacement(problem.bar, problem.equilibrium);
  const bool is_first = curve.points.empty();
  const std::unique_ptr<Stepper> stepper = curve.method->make(curve.setting);
  trajectory.times.resize(problem.steps);
  for (int step = 0; step < problem.steps; ++step) {
    trajectory.times[step].push_back(time_of([&] { stepper->step(problem.dt); }));
    if (is_first) {
      const Positions x = read(*stepper);
      curve.points.push_back({(step + 1) * static_cast<double>(problem.dt), 0,
                              energy.imbalance(x) / problem.bar.weight,
                              (tip_displacement(problem.bar, x) - tip).norm() / tip.norm()});
    }
  }
  const std::vector<Eigen::Vector3f> end = stepper->positions();
  if (is_first) {
    trajectory.end = end;
  } else if (std::memcmp(end.data(), trajectory.end.data(), end.size() * sizeof end[0]) != 0) {
    throw Error(curve.method->name + " ends otherwise when it is repeated");
  }
}

void mark_best(std::vector<RestCurve>& curves) {
  const auto cost = [](const RestCurve& curve) {
    const auto ms = ms_until(curve, &RestCurve::Point::tip_error, kTipTolerance);
    return std::pair(ms.value_or(std::numeric_limits<double>::infinity()),
                     curve.points.back().tip_error);
  };
  for (RestCurve& curve : curves) {
    for (const RestCurve& other : curves) {
      if (other.method == curve.method && cost(other) < cost(curve)) {
        curve.is_best = false;
      }
    }
  }
}

}  // namespace

Setting with_sweeps(const Method& method, int sweeps) {
  return method.is_by_substeps ? Setting{sweeps, 1} : Setting{1, sweeps};
}

std::vector<StepCurve> measure_step(const Problem& problem, const std::vector<Method>& methods,
                                    const std::vector<int>& sweeps) {
  const std::vector<Eigen::Vector3f> start = stretched_positions(problem.bar.scene);
  std::vector<StepCurve> curves;
  for (const Method& method : methods) {
    curves.push_back({&method, {}});
  }
  for (const int count : sweeps) {
    std::vector<std::unique_ptr<Stepper>> steppers;
    std::vector<std::vector<double>> times(methods.size());
    for (const Method& method : methods) {
      steppers.push_back(method.make(with_sweeps(method, count)));
    }
    for (int repetition = 0; repetition < problem.repetitions; ++repetition) {
      for (std::size_t i = 0; i < methods.size(); ++i) {
        steppers[i]->write_positions(start);
        times[i].push_back(time_of([&] { steppers[i]->step(problem.dt); }));
      }
    }
    for (std::size_t i = 0; i < methods.size(); ++i) {
      curves[i].points.push_back(
          {count, median(times[i]),
           step_residual(problem, methods[i], with_sweeps(methods[i], count))});
    }
  }
  return curves;
}

std::vector<RestCurve> measure_rest(const Problem& problem, const std::vector<Method>& methods) {
  const StaticEnergy energy(problem.bar.scene);
  std::vector<Trajectory> trajectories;
  for (const Method& method : methods) {
    for (const Setting& setting : method.settings) {
      trajectories.push_back({{&method, setting, {}}, {}, {}});
    }
  }
  for (int repetition = 0; repetition < problem.repetitions; ++repetition) {
    for (Trajectory& trajectory : trajectories) {
      repeat(trajectory, problem, energy);
    }
  }
  std::vector<RestCurve> curves;
  for (Trajectory& trajectory : trajectories) {
    double ms = 0;
    for (int step = 0; step < problem.steps; ++step) {
      ms += median(trajectory.times[step]);
      trajectory.curve.points[step].ms = ms;
    }
    curves.push_back(std::move(trajectory.curve));
  }
  mark_best(curves);
  return curves;
}

}  // namespace pbdsurg::bench
