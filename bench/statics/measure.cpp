// SPDX-License-Identifier: Apache-2.0
#include "bench/statics/measure.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <span>
#include <vector>

#include "bench/support/static_energy.h"

namespace pbdsurg::bench {
namespace {

Positions rest_of(const Scene& scene) {
  return {scene.positions().begin(), scene.positions().end()};
}

ToolPose pose_at(const Eigen::Vector3d& place) {
  ToolPose pose = ToolPose::Identity();
  pose.translation() = place.cast<float>();
  return pose;
}

double mean_sag(const Case& each, const std::function<Eigen::Vector3d(Index)>& position) {
  double sum = 0;
  for (const Index v : each.tip) {
    sum += each.scene.positions()[v].y() - position(v).y();
  }
  return 1e3 * sum / static_cast<double>(each.tip.size());
}

// How far the i-th vertex of a twist is from where it rests.
Eigen::Vector3d way_of(const Case& each, std::size_t i, double angle) {
  const Eigen::Vector3d arm = each.scene.positions()[each.twist->vertices[i]] - each.twist->center;
  return Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitX()) * arm - arm;
}

// mN mm, about the axis of a twist, of what holds its vertices, N.
double moment_of(const Case& each, std::span<const Eigen::Vector3d> forces) {
  double sum = 0;
  for (std::size_t i = 0; i < forces.size(); ++i) {
    const Eigen::Vector3d arm = each.scene.positions()[each.twist->vertices[i]] -
                                each.twist->center + way_of(each, i, each.twist->angle);
    sum += arm.cross(forces[i]).x();
  }
  return 1e6 * sum;
}

// What tools do in a case, and what they feel.
class Tools {
 public:
  Tools(const Case& each, Solver& solver) : case_(each), solver_(solver) {
    if (case_.pull) {
      hold(case_.pull->vertices);
    } else if (case_.ball) {
      const Capsule ball{{0, 0, 0}, {0, 0, 0}, static_cast<float>(case_.ball->radius)};
      // of vertices alone, as rest_under_ball() has it
      tools_.push_back(
          solver_.add_tool({&ball, 1}, pose_at(case_.ball->start), {ContactFeatures::vertices}));
    } else if (case_.twist) {
      for (const Index v : case_.twist->vertices) {
        hold({&v, 1});
      }
    }
  }

  // @param share  of the way
  void move(double share) {
    for (std::size_t i = 0; i < tools_.size(); ++i) {
      solver_.move_tool(tools_[i], pose_at(place(i, share)));
    }
  }

  // As expected_value() has it.
  [[nodiscard]] double value() const {
    std::vector<Eigen::Vector3d> forces;
    for (const ToolId tool : tools_) {
      forces.emplace_back(-solver_.tool_force(tool).cast<double>());
    }
    if (case_.twist) {
      return moment_of(case_, forces);
    }
    if (case_.pull || case_.ball) {
      return forces[0].dot((place(0, 1) - place(0, 0)).normalized());
    }
    const std::vector<Eigen::Vector3f> x = solver_.positions();
    return mean_sag(case_, [&](Index v) { return x[v].cast<double>().eval(); });
  }

 private:
  void hold(std::span<const Index> vertices) {
    tools_.push_back(solver_.add_tool({}, ToolPose::Identity()));
    solver_.grasp(tools_.back(), vertices);
  }

  // Of the i-th tool.
  [[nodiscard]] Eigen::Vector3d place(std::size_t i, double share) const {
    if (case_.twist) {
      return way_of(case_, i, share * case_.twist->angle);
    }
    if (case_.ball) {
      return case_.ball->start + share * case_.ball->way;
    }
    return share * case_.pull->way;
  }

  const Case& case_;
  Solver& solver_;
  std::vector<ToolId> tools_;
};

}  // namespace

double expected_value(const Case& each) {
  StaticEnergy energy(each.scene);
  constexpr int kLoadSteps = 10;
  Positions places = rest_of(each.scene);
  if (each.pull) {
    energy.hold(each.pull->vertices);
    for (const Index v : each.pull->vertices) {
      places[v] += each.pull->way;
    }
    const Positions x = find_equilibrium_by_steps(energy, places, kLoadSteps);
    const std::vector<Eigen::Vector3d> forces = energy.holding_forces(each.pull->vertices, x);
    return std::accumulate(forces.begin(), forces.end(), Eigen::Vector3d(0, 0, 0))
        .dot(each.pull->way.normalized());
  }
  if (each.twist) {
    energy.hold(each.twist->vertices);
    for (std::size_t i = 0; i < each.twist->vertices.size(); ++i) {
      places[each.twist->vertices[i]] += way_of(each, i, each.twist->angle);
    }
    const Positions x = find_equilibrium_by_steps(energy, places, kLoadSteps);
    return moment_of(each, energy.holding_forces(each.twist->vertices, x));
  }
  if (each.ball) {
    energy.press(each.ball->start + each.ball->way, each.ball->radius);
    const Positions x = find_equilibrium(energy, places);
    return energy.pressing_force(x).dot(each.ball->way.normalized());
  }
  const Positions x = find_equilibrium(energy, places);
  return mean_sag(each, [&](Index v) { return x[v]; });
}

Outcome measure(const Case& each, SolverOptions options, double dt, double seconds) {
  options.damping = static_cast<float>(each.drag);
  Solver solver(each.scene, options);
  Tools tools(each, solver);
  const int steps = std::max(20, static_cast<int>(std::lround(seconds / dt)));
  double last_tenth = 0, before = 0;
  for (int step = 0; step < steps; ++step) {
    tools.move(std::min(1.0, (step + 1) / (0.1 * steps)));  // there after a tenth of the time
    solver.step(static_cast<float>(dt));
    const double value = tools.value();
    last_tenth += step >= 9 * steps / 10 ? value : 0;
    before += step >= 8 * steps / 10 && step < 9 * steps / 10 ? value : 0;
  }
  last_tenth /= steps - 9 * steps / 10;
  before /= 9 * steps / 10 - 8 * steps / 10;
  const SolverOptions& taken = solver.options();
  return {taken.method, taken.coarse_correction,
          divide_step(static_cast<float>(dt), substep_rule(solver.tissue(), taken), taken),
          last_tenth, (last_tenth - before) / last_tenth};
}

}  // namespace pbdsurg::bench
