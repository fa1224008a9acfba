// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/rest_cases.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/base/random.h"

#include "bench/contact/blocks.h"
#include "bench/support/neo_hookean.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr int kPlaces = 6;
constexpr double kEdge = 4e-3;                            // m, of the block
constexpr float kTop = 12e-3F, kMiddle = 12e-3F;          // m, of its upper face
constexpr int kDown = 100, kAfter = 300, kWatched = 100;  // steps

Scene make_block() {
  Scene scene;
  scene.add_body("tissue", testing::make_box({6, 6, 3}, kEdge), neo_hookean(10e3F, 0.45));
  scene.fix_vertices(0, vertices_below(scene, 0.5 * kEdge));
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

// What single steps of a tool at rest tell.
struct Swing {
  double least = 1e9, most = 0, sum = 0;  // N
  double off = 0;                         // N, the largest difference from its spring
  int count = 0;

  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double share() const { return (most - least) / mean(); }
};

// Presses a tool within half a second, holds it for one and a half, and looks for another half.
Swing hold(Solver& solver, ToolId tool, ToolPose pose, float depth, float spring) {
  Swing swing;
  const float start = pose.translation().z();
  for (int i = 1; i <= kDown + kAfter + kWatched; ++i) {
    pose.translation().z() = start - depth * static_cast<float>(std::min(i, kDown)) / kDown;
    solver.move_tool(tool, pose);
    solver.step(kCaseStep);
    if (i > kDown + kAfter) {
      const double force = solver.tool_force(tool).norm();
      const double pull = spring * solver.tool_displacement(tool).norm();
      swing.least = std::min(swing.least, force);
      swing.most = std::max(swing.most, force);
      swing.off = std::max(swing.off, std::abs(force - pull));
      swing.sum += force;
      ++swing.count;
    }
  }
  return swing;
}

// A plate of 8 x 6 mm, 2 mm thick, flat on the block, at places and turns by chance.
Swing hold_plate(const SolverOptions& options, float depth, float spring) {
  const Capsule plate{{-4e-3F, 0, -3e-3F}, {4e-3F, 0, -3e-3F}, 1e-3F, {0, 0, 6e-3F}};
  const Eigen::AngleAxisf flat(std::acos(-1.0F) / 2, Eigen::Vector3f::UnitX());
  Swing worst;
  for (std::uint64_t place = 0; place < kPlaces; ++place) {
    const auto random = [&](std::uint64_t k) {
      return static_cast<float>(random_unit(5, place, k) - 0.5);
    };
    Solver solver(make_block(), options);
    const ToolPose pose(Eigen::Translation3f(kMiddle + 4e-3F * random(0),
                                             kMiddle + 4e-3F * random(1), kTop + plate.radius) *
                        Eigen::AngleAxisf(3 * random(2), Eigen::Vector3f::UnitZ()) * flat);
    const ToolId tool = solver.add_tool({&plate, 1}, pose, kSmooth);
    if (spring > 0) {
      solver.couple_tool(tool, {spring});
    }
    const Swing swing = hold(solver, tool, pose, depth, spring);
    const auto badness = [&](const Swing& each) {
      return spring > 0 ? each.off / each.mean() : each.share();
    };
    if (worst.count == 0 || badness(swing) > badness(worst)) {
      worst = swing;
    }
  }
  return worst;
}

// A free sheet of 0.3 mm on the block, and a ball of 3 mm that presses both.
// @param damping  s, of the sheet
Swing hold_on_sheet(const SolverOptions& options, float damping) {
  constexpr TissueContact kOn{0.5e-3F, 0.2F};
  constexpr Index kCells = 4;
  constexpr double kCell = 5.5e-3, kRim = 1e-3;  // m
  Scene scene = make_block();
  testing::SheetMesh mesh = testing::make_sheet({kCells, kCells}, kCell);
  for (Eigen::Vector3d& x : mesh.positions) {
    x += Eigen::Vector3d(kRim, kRim, kTop + kOn.thickness);
  }
  scene.add_sheet("membrane", mesh.positions, mesh.triangles,
                  {.thickness = 0.3e-3F, .youngs_modulus = 50e3F, .damping = damping});
  Solver solver(scene, options);
  solver.set_body_contact(0, 1, kOn);
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 3e-3F};
  const ToolPose pose = at({11.3e-3F, 12.9e-3F, kTop + kOn.thickness + ball.radius});
  return hold(solver, solver.add_tool({&ball, 1}, pose, kSmooth), pose, 0.5e-3F, 0);
}

ContactOutcome swing_of(const Swing& swing) {
  return compare_to_zero(swing.most - swing.least, swing.mean());
}

}  // namespace

std::vector<ContactCase> rest_cases() {
  const std::string plate = "plate at rest, 1.5 mm deep in edges of 4 mm: single steps differ by";
  const auto press = [](const SolverOptions& options) {
    return swing_of(hold_plate(options, 1.5e-3F, 0));
  };
  std::vector<ContactCase> cases{
      {plate, "N", "none; error of the mean", 1, true, press},
      {plate + ", ten sweeps", "N", "none; error of the mean", 1, true,
       [=](SolverOptions options) {
         options.iterations = 10;
         return press(options);
       }},
      {"plate on a spring of 300 N/m at rest: force, less stiffness times way", "N",
       "none; error of the mean", 1, true, [](const SolverOptions& options) {
         const Swing worst = hold_plate(options, 4e-3F, 300);
         return compare_to_zero(worst.off, worst.mean());
       }}};
  for (const int damping : {0, 1, 10}) {  // ms
    cases.push_back({"ball at rest on a membrane of 0.3 mm on tissue, damping of " +
                         std::to_string(damping) + " ms: single steps differ by",
                     "N", "none; error of the mean", 1, true, [=](const SolverOptions& options) {
                       return swing_of(hold_on_sheet(options, 1e-3F * damping));
                     }});
  }
  return cases;
}

}  // namespace pbdsurg::bench
