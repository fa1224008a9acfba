// SPDX-License-Identifier: Apache-2.0
#include "bench/statics/cases.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include "pbdsurg/mesh/implicit_shape.h"
#include "pbdsurg/mesh/tetrahedralize.h"
#include "pbdsurg/tissue/library.h"

#include "bench/support/neo_hookean.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr float kGravity = 9.81F;  // m/s^2

std::string in_kilopascals(double pascals) {
  return std::to_string(std::lround(pascals / 1000)) + " kPa";
}

// @param gravity  m/s^2, downwards along y
Case make_case(const std::string& name, TetMesh mesh, const Material& material, float gravity) {
  Case each;
  each.name = name;
  each.scene.add_body("first", std::move(mesh), material);
  each.scene.set_gravity({0, -gravity, 0});
  return each;
}

std::vector<Index> vertices_where(const Scene& scene,
                                  const std::function<bool(const Eigen::Vector3d&)>& is_in) {
  std::vector<Index> result;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (is_in(scene.positions()[v])) {
      result.push_back(v);
    }
  }
  return result;
}

// 2 omega of the lowest mode of a bar that is held at one end.
double critical_drag(double youngs_modulus, double length) {
  return std::numbers::pi * std::sqrt(youngs_modulus / 1000) / length;
}

// Of 10 x 60 x 10 mm, held at the top, under its weight.
Case hanging_bar(const std::string& name, const Material& material, std::vector<double> steps_ms) {
  constexpr double kEdge = 10e-3 / 3;
  Case each =
      make_case("hanging bar, " + name, testing::make_box({3, 18, 3}, kEdge), material, kGravity);
  const double top = 18 * kEdge;
  each.scene.fix_where(0, [&](const Eigen::Vector3d& x) { return x.y() > top - 0.5 * kEdge; });
  each.tip = vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  each.drag = critical_drag(material.youngs_modulus, top);
  each.steps_ms = std::move(steps_ms);
  return each;
}

// Of a usual material, but for one number.
std::vector<Case> hanging_bars() {
  std::vector<Case> cases;
  for (const double pascals : {5e3, 20e3, 80e3, 320e3}) {
    cases.push_back(
        hanging_bar(in_kilopascals(pascals), neo_hookean(pascals, 0.45), {1, 2, 5, 10, 33}));
  }
  const std::vector<double> some{1, 5, 16};
  cases.push_back(hanging_bar("20 kPa, Poisson's ratio 0.3", neo_hookean(20e3, 0.3), some));
  cases.push_back(hanging_bar("20 kPa, Poisson's ratio 0.49", neo_hookean(20e3, 0.49), some));
  Material rubs = neo_hookean(20e3, 0.45);
  rubs.damping = 5e-3F;
  cases.push_back(hanging_bar("20 kPa, friction of 5 ms", rubs, some));
  return cases;
}

// A solid ellipsoid of 100 x 30 x 60 mm, of the stiffness of a gallbladder's wall, pulled by a
// grasp.
Case pulled_ellipsoid() {
  const ImplicitShape shape = ellipsoid_shape({0, 0, 0}, {50e-3, 15e-3, 30e-3});
  TetrahedralizeOptions options;
  options.spacing = 6e-3;
  Case each = make_case("ellipsoid of 250 kPa, pulled by 20 mm",
                        tetrahedralize(shape, options).mesh, neo_hookean(250e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < -40e-3; });
  each.pull =
      Pull{vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.x() > 43e-3; }),
           {0, 20e-3, 0}};
  each.drag = critical_drag(250e3, 0.1);
  each.steps_ms = {1, 5, 16};
  return each;
}

// Half of the length more, by all vertices of an end.
Case stretched_block(double youngs_modulus) {
  constexpr double kEdge = 5e-3;
  Case each = make_case("block of " + in_kilopascals(youngs_modulus) + ", stretched by 50 %",
                        testing::make_box({6, 4, 4}, kEdge), neo_hookean(youngs_modulus, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 1e-6; });
  each.pull = Pull{
      vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.x() > 6 * kEdge - 1e-6; }),
      {15e-3, 0, 0}};
  each.drag = critical_drag(youngs_modulus, 30e-3);
  each.steps_ms = {1, 5, 10};
  return each;
}

// Of the friction that its tissue has, lifted by a grasp as examples/tools.cpp does; without the
// limit to its stretch, which the static solution does not know.
Case lifted_liver() {
  const ImplicitShape box = rounded_box_shape({0, -15e-3, 0}, {30e-3, 15e-3, 30e-3}, 2e-3);
  TetrahedralizeOptions options;
  options.spacing = 4e-3;
  Material liver = tissues::liver().mechanics;
  liver.max_stretch = std::numeric_limits<float>::infinity();
  Case each = make_case("liver with its friction, lifted by 8 mm",
                        tetrahedralize(box, options).mesh, liver, kGravity);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < -28e-3; });
  each.pull =
      Pull{vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.norm() < 6e-3; }),
           {0, 8e-3, 0}};
  each.drag = critical_drag(liver.youngs_modulus, 30e-3);
  each.steps_ms = {1, 5, 16};
  return each;
}

Case ball_on_block() {
  constexpr double kEdge = 2e-3;
  Case each = make_case("ball of 15 mm, 1 mm deep in 10 kPa", testing::make_box({16, 8, 16}, kEdge),
                        neo_hookean(10e3, 0.45), 0);
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 1e-6; });
  const double top = 8 * kEdge;
  each.ball = Ball{15e-3, {16e-3, top + 15e-3 + 0.1e-3, 16e-3}, {0, -1.1e-3, 0}};
  each.drag = critical_drag(10e3, top);
  each.steps_ms = {1, 2, 5};
  return each;
}

// Filled to the brim with what hardly changes its volume; walls and floor hold it.
Case bath() {
  constexpr double kEdge = 5e-3;
  Case each = make_case("bath of 5 kPa, Poisson's ratio 0.49", testing::make_box({8, 8, 8}, kEdge),
                        neo_hookean(5e3, 0.49), kGravity);
  const double side = 8 * kEdge;
  each.scene.fix_where(0, [&](const Eigen::Vector3d& x) {
    return x.y() < 1e-6 || std::min(x.x(), x.z()) < 1e-6 || std::max(x.x(), x.z()) > side - 1e-6;
  });
  each.tip = vertices_where(each.scene, [&](const Eigen::Vector3d& x) {
    return x.y() > side - 1e-6 && std::abs(x.x() - side / 2) < 11e-3 &&
           std::abs(x.z() - side / 2) < 11e-3;
  });
  each.drag = critical_drag(5e3, side);
  each.steps_ms = {1, 5, 16};
  return each;
}

// A thousand times stiffer, hung on by links that hardly give.
Case linked_blocks() {
  constexpr double kEdge = 5e-3;
  const TetMesh upper = testing::make_box({4, 4, 4}, kEdge);
  std::vector<Eigen::Vector3d> lower(upper.positions().begin(), upper.positions().end());
  for (Eigen::Vector3d& x : lower) {
    x.y() -= 20e-3;
  }
  const auto count = static_cast<Index>(lower.size());
  Case each = make_case("5 MPa hung on 5 kPa by links of 1e-5 m/N", upper, neo_hookean(5e3, 0.45),
                        kGravity);
  each.scene.add_body("lower",
                      TetMesh(std::move(lower), {upper.tets().begin(), upper.tets().end()}),
                      neo_hookean(5e6, 0.45));
  each.scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() > 20e-3 - 1e-6; });
  for (Index v = 0; v < count; ++v) {
    const Eigen::Vector3d& x = each.scene.positions()[v];
    for (Index w = count; w < 2 * count && x.y() < 1e-6; ++w) {
      if ((each.scene.positions()[w] - x).norm() < 1e-6) {
        Link link{v, w, 0, {}};
        link.stiffness.compliance = 1e-5F;
        each.scene.add_link(link);
      }
    }
  }
  each.tip =
      vertices_where(each.scene, [](const Eigen::Vector3d& x) { return x.y() < -20e-3 + 1e-6; });
  each.drag = critical_drag(5e3, 40e-3);
  each.steps_ms = {1, 5, 16};
  return each;
}

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

}  // namespace

std::vector<Case> make_cases(bool quick) {
  if (quick) {
    return {hanging_bar("20 kPa", neo_hookean(20e3, 0.45), {5})};
  }
  std::vector<Case> cases = hanging_bars();
  cases.push_back(pulled_ellipsoid());
  for (const double kilopascals : {5, 50, 500}) {
    cases.push_back(stretched_block(1000 * kilopascals));
  }
  cases.push_back(lifted_liver());
  cases.push_back(ball_on_block());
  cases.push_back(bath());
  cases.push_back(linked_blocks());
  return cases;
}

double expected_value(const Case& each) {
  StaticEnergy energy(each.scene);
  constexpr int kLoadSteps = 10;
  if (each.pull) {
    energy.hold(each.pull->vertices);
    Positions places = rest_of(each.scene);
    for (const Index v : each.pull->vertices) {
      places[v] += each.pull->way;
    }
    const Positions x = find_equilibrium_by_steps(energy, places, kLoadSteps);
    return energy.holding_force(each.pull->vertices, x).dot(each.pull->way.normalized());
  }
  if (each.ball) {
    energy.press(each.ball->start + each.ball->way, each.ball->radius);
    const Positions x = find_equilibrium(energy, rest_of(each.scene));
    return energy.pressing_force(x).dot(each.ball->way.normalized());
  }
  const Positions x = find_equilibrium(energy, rest_of(each.scene));
  return mean_sag(each, [&](Index v) { return x[v]; });
}

Outcome measure(const Case& each, SolverOptions options, double dt, double seconds) {
  options.damping = static_cast<float>(each.drag);
  Solver solver(each.scene, options);
  std::optional<ToolId> tool;
  Eigen::Vector3d start = Eigen::Vector3d::Zero(), way = start;
  if (each.pull) {
    way = each.pull->way;
    tool = solver.add_tool({}, pose_at(start));
    solver.grasp(*tool, each.pull->vertices);
  } else if (each.ball) {
    start = each.ball->start;
    way = each.ball->way;
    const Capsule ball{{0, 0, 0}, {0, 0, 0}, static_cast<float>(each.ball->radius)};
    tool = solver.add_tool({&ball, 1}, pose_at(start));
  }
  const int steps = std::max(20, static_cast<int>(std::lround(seconds / dt)));
  double last_tenth = 0, before = 0;
  for (int step = 0; step < steps; ++step) {
    if (tool) {  // there after a tenth of the time
      const double share = std::min(1.0, (step + 1) / (0.1 * steps));
      solver.move_tool(*tool, pose_at(start + share * way));
    }
    solver.step(static_cast<float>(dt));
    double value = 0;
    if (tool) {
      value = -solver.tool_force(*tool).cast<double>().dot(way.normalized());
    } else {
      const std::vector<Eigen::Vector3f> x = solver.positions();
      value = mean_sag(each, [&](Index v) { return x[v].cast<double>().eval(); });
    }
    last_tenth += step >= 9 * steps / 10 ? value : 0;
    before += step >= 8 * steps / 10 && step < 9 * steps / 10 ? value : 0;
  }
  last_tenth /= steps - 9 * steps / 10;
  before /= 9 * steps / 10 - 8 * steps / 10;
  return {last_tenth, (last_tenth - before) / last_tenth};
}

}  // namespace pbdsurg::bench
