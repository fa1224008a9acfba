// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/hook_cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>

#include "pbdsurg/base/random.h"

#include "bench/contact/blocks.h"
#include "bench/support/neo_hookean.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr int kPlaces = 16;      // where hooks are pressed
constexpr double kEdge = 2e-3;   // m
constexpr double kDepth = 2e-3;  // m, of hooks

// Between -0.5 and 0.5.
class Numbers {
 public:
  explicit Numbers(std::uint64_t seed) : seed_(seed) {}
  Eigen::Vector3f next_point() {
    const float x = next(), y = next(), z = next();
    return {x, y, z};
  }

 private:
  float next() { return static_cast<float>(random_unit(seed_, count_++) - 0.5); }

  std::uint64_t seed_, count_ = 0;
};

// A block that is fixed below, its vertices away from a grid by a tenth of an edge at most.
Scene make_block(float modulus, Numbers& numbers) {
  const TetMesh cubes = testing::make_box({12, 12, 5}, kEdge);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& x : cubes.positions()) {
    positions.push_back(x + 0.2 * kEdge * numbers.next_point().cast<double>());
  }
  Scene scene;
  scene.add_body("tissue",
                 TetMesh(std::move(positions), {cubes.tets().begin(), cubes.tets().end()}),
                 neo_hookean(modulus, 0.45));
  scene.fix_vertices(0, vertices_below(scene, 0.5 * kEdge));
  return scene;
}

struct Rest {
  double force;  // N, in the last half second
  double moved;  // m, what the fastest vertex moves in 5 ms, likewise
};

// The demo's hook, pressed within a second and held for another three.
Rest rest(const SolverOptions& options, float modulus, double step, std::uint64_t place) {
  const std::array<Capsule, 3> hook{Capsule{{0, 0, 0}, {3e-3F, 0, 1e-3F}, 0.5e-3F},
                                    Capsule{{3e-3F, 0, 1e-3F}, {3e-3F, 0, 12e-3F}, 0.6e-3F},
                                    Capsule{{3e-3F, 0, 14e-3F}, {3e-3F, 0, 0.25F}, 2.5e-3F}};
  Numbers numbers(place);
  Solver solver(make_block(modulus, numbers), options);
  Eigen::Vector3f touch = Eigen::Vector3f(12e-3F, 12e-3F, 0) + 8e-3F * numbers.next_point();
  touch.z() = 11.5e-3F;
  const Eigen::Vector3f turn = numbers.next_point();
  ToolPose pose(Eigen::Translation3f(touch) *
                Eigen::AngleAxisf(6.28F * turn.z(), Eigen::Vector3f::UnitZ()) *
                Eigen::AngleAxisf(0.8F * turn.x(), Eigen::Vector3f::UnitX()) *
                Eigen::AngleAxisf(0.4F * turn.y(), Eigen::Vector3f::UnitY()));
  const ToolId tool = solver.add_tool(hook, pose);
  Rest rest{};
  int counted = 0;
  for (int i = 1; i * step < 4; ++i) {
    const auto sunk = static_cast<float>((kDepth + 1.5e-3) * std::min(1.0, i * step));
    pose.translation() = touch - Eigen::Vector3f(0, 0, sunk);
    solver.move_tool(tool, pose);
    const std::vector<Eigen::Vector3f> before = solver.positions();
    solver.step(static_cast<float>(step));
    if (i * step > 3.5) {
      const std::vector<Eigen::Vector3f> after = solver.positions();
      float most = 0;
      for (std::size_t v = 0; v < before.size(); ++v) {
        most = std::max(most, (after[v] - before[v]).norm());
      }
      rest.moved += most * (5e-3 / step);
      rest.force += solver.tool_force(tool).norm();
      ++counted;
    }
  }
  return {rest.force / counted, rest.moved / counted};
}

Rest mean_rest(SolverOptions options, float modulus, double step) {
  options.damping = 20;
  Rest mean{};
  for (std::uint64_t place = 0; place < kPlaces; ++place) {
    const Rest each = rest(options, modulus, step, place);
    mean.force += each.force / kPlaces;
    mean.moved += each.moved / kPlaces;
  }
  return mean;
}

// N, of a rod that is pressed at 0.1 m/s, lying flat, to a depth of eight of its radii, and held:
// after a tenth of a second.
double press_rod(SolverOptions options, double step) {
  constexpr float kDeep = 4e-3F, kAbove = 1e-3F, kSpeed = 0.1F;  // m, m, m/s
  const Capsule rod{{-8e-3F, 0, 0}, {8e-3F, 0, 0}, 0.5e-3F};
  options.damping = 20;
  double force = 0;
  for (std::uint64_t place = 0; place < kPlaces; ++place) {
    Numbers numbers(place);
    Solver solver(make_block(10e3F, numbers), options);
    Eigen::Vector3f touch = Eigen::Vector3f(12e-3F, 12e-3F, 0) + 3e-3F * numbers.next_point();
    touch.z() = 10e-3F + rod.radius + kAbove;
    ToolPose pose(Eigen::Translation3f(touch) *
                  Eigen::AngleAxisf(3 * numbers.next_point().z(), Eigen::Vector3f::UnitZ()));
    const ToolId tool = solver.add_tool({&rod, 1}, pose);
    const auto steps = static_cast<int>(std::lround(0.15 / step));
    for (int i = 1; i <= steps; ++i) {
      const float gone = kSpeed * static_cast<float>(i * step);
      pose.translation() = touch - Eigen::Vector3f(0, 0, std::min(gone, kDeep + kAbove));
      solver.move_tool(tool, pose);
      solver.step(static_cast<float>(step));
    }
    force += solver.tool_force(tool).z() / kPlaces;
  }
  return force;
}

}  // namespace

std::vector<ContactCase> hook_cases() {
  constexpr double kStep = 5e-3;
  const std::string rod = "rod of 0.5 mm that lies 4 mm deep in edges of 2 mm, 10 kPa: force";
  const auto press = [=](const SolverOptions& options) {
    return compare(press_rod(options, kStep), press_rod(options, kStep / 16));
  };
  std::vector<ContactCase> cases{
      {rod, "N", "steps of 0.31 ms", 10, false, press},
      {rod + ", ten sweeps", "N", "steps of 0.31 ms", 10, false, [=](SolverOptions options) {
         options.iterations = 10;
         return press(options);
       }}};
  for (const float modulus : {2e3F, 10e3F}) {
    const std::string hook = "hook of 0.5 mm, 2 mm deep in edges of 2 mm, " +
                             std::to_string(std::lround(modulus / 1e3F)) + " kPa: ";
    cases.push_back(
        {hook + "force", "N", "steps of 1.25 ms", 3, false, [=](const SolverOptions& options) {
           return compare(mean_rest(options, modulus, kStep).force,
                          mean_rest(options, modulus, kStep / 4).force);
         }});
    cases.push_back({hook + "the fastest vertex moves, in 5 ms", "mm", "rest; error in edges", 1,
                     false, [=](const SolverOptions& options) {
                       return compare_to_zero(1e3 * mean_rest(options, modulus, kStep).moved,
                                              1e3 * kEdge);
                     }});
  }
  return cases;
}

}  // namespace pbdsurg::bench
