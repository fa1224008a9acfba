// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/sheet_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>

#include "pbdsurg/base/random.h"

#include "bench/contact/blocks.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::bench {
namespace {

// Whether a triangle lies across the line upwards from a tip.
bool crosses(const std::vector<Eigen::Vector3f>& positions, const std::vector<Triangle>& triangles,
             const Eigen::Vector3f& tip) {
  return std::ranges::any_of(triangles, [&](const Triangle& t) {
    const Eigen::Vector3f& origin = positions[t[0]];
    Eigen::Matrix<float, 3, 2> sides;
    sides << positions[t[1]] - origin, positions[t[2]] - origin;
    const Eigen::Vector2f share = sides.topRows<2>().inverse() * (tip - origin).head<2>();
    return share.minCoeff() >= 0 && share.sum() <= 1 &&
           origin.z() + sides.row(2).dot(share.transpose()) > tip.z();
  });
}

// Of rods that fly at a sheet's faces, edges and vertices, those on its other side at the end.
// @param step  s
ContactOutcome shoot(const SolverOptions& options, int shots, float step) {
  constexpr Index kCells = 8;
  constexpr double kEdge = 5e-3;
  const testing::SheetMesh mesh = testing::make_sheet({kCells, kCells}, kEdge);
  Scene scene;
  const BodyId sheet = scene.add_sheet("sheet", mesh.positions, mesh.triangles, {});
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.fix_vertices(sheet, testing::rim_of_sheet({kCells, kCells}));
  int passed = 0;
  for (int shot = 0; shot < shots; ++shot) {
    const auto random = [&](int k) { return static_cast<float>(random_unit(7, shot, k)); };
    Solver solver(scene, options);
    const Capsule rod{{0, 0, 0}, {0, 0, 50e-3F}, 0.5e-3F};
    // every third at a vertex, every third at an edge
    Eigen::Vector2f cell(2 + 4 * random(0), 2 + 4 * random(1));
    for (int axis = 0; axis < shot % 3; ++axis) {
      cell[axis] = std::round(cell[axis]);
    }
    const float speed = 0.1F + 0.9F * random(2);
    const Eigen::Vector3f start(5e-3F * cell.x(), 5e-3F * cell.y(), 5e-3F);
    const ToolId tool = solver.add_tool({&rod, 1}, at(start), kSmooth);
    Eigen::Vector3f place = start;
    while (place.z() > -5e-3F) {
      place.z() = std::max(place.z() - speed * step, -5e-3F);
      solver.move_tool(tool, at(place));
      solver.step(step);
    }
    for (int i = 0; i < 10; ++i) {
      solver.step(step);
    }
    passed += crosses(solver.positions(), mesh.triangles, place) ? 1 : 0;
  }
  return compare_to_zero(passed, shots);
}

// A rod in a tube whose four walls have two triangles each, and which is as wide as twenty rods
// (Newton's issue 4280): thrust against a wall, then against the one across, and back.
constexpr double kTubeWidth = 10e-3, kTubeLength = 60e-3;  // m

// Calls visit(place) after each step, with where the rod is to be.
template <class Visit>
void thrust(Solver& solver, ToolId rod, int shot, float step, const Visit& visit) {
  testing::for_each_thrust(11, static_cast<std::uint64_t>(shot), step,
                           [&](const Eigen::Vector3f& place) {
                             solver.move_tool(rod, at(place));
                             solver.step(step);
                             visit(place);
                           });
}

Scene make_tube(bool stands_fast) {
  const testing::SheetMesh mesh = testing::make_square_tube(kTubeWidth, kTubeLength);
  Scene scene;
  const BodyId tube = scene.add_sheet("tube", mesh.positions, mesh.triangles, {});
  if (stands_fast) {
    scene.fix_vertices(tube, std::array{0, 1, 2, 3, 4, 5, 6, 7});
  }
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

// The rod takes the tube along. It is too long to slip out at an end, so where the tube is not
// around it any more, it has passed.
ContactOutcome thrust_in_free_tube(const SolverOptions& options, int shots, float step) {
  const Scene scene = make_tube(false);
  const Capsule rod{{0, 0, -1}, {0, 0, 1}, 0.5e-3F};
  int passed = 0;
  for (int shot = 0; shot < shots; ++shot) {
    Solver solver(scene, options);
    const ToolId tool = solver.add_tool({&rod, 1}, at(Eigen::Vector3f::Zero()), kSmooth);
    bool is_inside = true;
    thrust(solver, tool, shot, step, [&](const Eigen::Vector3f& place) {
      is_inside = is_inside && testing::is_around(solver.positions(), place);
    });
    passed += is_inside ? 0 : 1;
  }
  return compare_to_zero(passed, shots);
}

// The tube stays, and the rod is on a spring.
ContactOutcome thrust_in_fast_tube(const SolverOptions& options, int shots, float step) {
  const Scene scene = make_tube(true);
  const Capsule rod{{0, 0, -kTubeLength / 3}, {0, 0, kTubeLength / 3}, 0.5e-3F};
  int passed = 0;
  for (int shot = 0; shot < shots; ++shot) {
    Solver solver(scene, options);
    const ToolId tool =
        solver.add_tool({&rod, 1}, at(Eigen::Vector3f::Zero()), {ContactFeatures::all, 0.2F});
    solver.couple_tool(tool, {500});
    bool is_inside = true;
    thrust(solver, tool, shot, step, [&](const Eigen::Vector3f& /*place*/) {
      const Eigen::Vector3f place = solver.tool_pose(tool).translation();
      is_inside = is_inside && place.head<2>().cwiseAbs().maxCoeff() < kTubeWidth / 2;
    });
    passed += is_inside ? 0 : 1;
  }
  return compare_to_zero(passed, shots);
}

// A belt half around a pulley that does not turn, pulled at both ends (Euler's belt formula). One
// pull grows until the other end gives way.
ContactOutcome pull_belt(SolverOptions options) {
  constexpr float kFriction = 0.3F, kStep = 5e-3F;
  constexpr double kRadius = 5e-3, kEdge = 1.25e-3, kStraight = 15e-3, kPull = 0.02;  // m, N
  constexpr Index kAcross = 3;
  options.damping = 20;
  const double arc = std::numbers::pi * kRadius;
  const auto cells = static_cast<Index>(std::lround((arc + 2 * kStraight) / kEdge));
  testing::SheetMesh belt = testing::make_sheet({cells, kAcross}, kEdge);
  std::vector<Index> left, right;
  for (std::size_t v = 0; v < belt.positions.size(); ++v) {
    Eigen::Vector3d& x = belt.positions[v];
    const double s = x.x() * (arc + 2 * kStraight) / (cells * kEdge) - kStraight;
    const double turned = std::clamp(s / kRadius, 0.0, std::numbers::pi);
    const double down = std::max({0.0, -s, s - arc});
    if (x.x() < kEdge / 2) {
      left.push_back(static_cast<Index>(v));
    } else if (x.x() > (cells - 0.5) * kEdge) {
      right.push_back(static_cast<Index>(v));
    }
    x = {-kRadius * std::cos(turned), x.y(), kRadius * std::sin(turned) - down};
  }
  Scene scene;
  scene.add_sheet("belt", belt.positions, belt.triangles,
                  {.thickness = 0.5e-3F, .density = 1e4F, .youngs_modulus = 200e3F});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, options);
  const Capsule pulley{{0, -0.05F, 0}, {0, 0.05F, 0}, static_cast<float>(kRadius)};
  solver.add_tool({&pulley, 1}, ToolPose::Identity(), {ContactFeatures::all, kFriction});
  const auto pull = [&](const std::vector<Index>& end, double force) {
    const Eigen::Vector3f each(0, 0, static_cast<float>(-force / static_cast<double>(end.size())));
    solver.set_forces(end, std::vector<Eigen::Vector3f>(end.size(), each));
  };
  const auto height = [&] { return double{solver.positions()[left[0]].z()}; };
  const double expected = std::exp(kFriction * std::numbers::pi);
  pull(left, kPull);
  pull(right, kPull);
  for (int i = 0; i < 200; ++i) {
    solver.step(kStep);
  }
  const double before = height();
  double ratio = 1;
  while (height() < before + kEdge / 2 && ratio < 2 * expected) {
    ratio += 4e-3;
    pull(right, ratio * kPull);
    solver.step(kStep);
  }
  return compare(ratio, expected);
}

}  // namespace

std::vector<ContactCase> sheet_cases() {
  std::vector<ContactCase> cases{
      {"belt half around a pulley: ratio of pulls at which it slips", "", "exp(mu pi)", 10, false,
       pull_belt},
      {"rods of 0.5 mm through a sheet, 0.1 to 1 m/s, steps of 5 ms", "passed", "none of 30", 0,
       true, [](const SolverOptions& options) { return shoot(options, 30, 5e-3F); }}};
  for (const auto& [step, name] :
       {std::pair(1e-3F, "1 ms"), std::pair(5e-3F, "5 ms"), std::pair(16e-3F, "16 ms")}) {
    cases.push_back(
        {"rods of 0.5 mm through a sheet, 0.1 to 1 m/s, steps of " + std::string(name), "passed",
         "none of 340", 0, false,
         [step = step](const SolverOptions& options) { return shoot(options, 340, step); }});
    cases.push_back({"rods of 0.5 mm in a free tube of eight triangles, 0.1 to 1 m/s, steps of " +
                         std::string(name),
                     "passed", "none of 100", 0, true, [step = step](const SolverOptions& options) {
                       return thrust_in_free_tube(options, 100, step);
                     }});
    cases.push_back(
        {"rods of 0.5 mm on a spring in a tube of eight triangles that stands fast, 0.1 to 1 m/s, "
         "steps of " +
             std::string(name),
         "passed", "none of 100", 0, true, [step = step](const SolverOptions& options) {
           return thrust_in_fast_tube(options, 100, step);
         }});
  }
  return cases;
}

}  // namespace pbdsurg::bench
