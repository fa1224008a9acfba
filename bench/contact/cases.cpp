// SPDX-License-Identifier: Apache-2.0
#include "bench/contact/cases.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "bench/contact/blocks.h"
#include "bench/support/neo_hookean.h"
#include "bench/support/static_energy.h"
#include "tests/support/meshes.h"

namespace pbdsurg::bench {
namespace {

constexpr double kModulus = 10e3, kRatio = 0.45;

Scene scene_of(TetMesh mesh, const Material& material) {
  Scene scene;
  scene.add_body("block", std::move(mesh), material);
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

SolverOptions damped(SolverOptions options) {
  options.damping = 20;
  return options;
}

// A cube between two smooth plates: any mesh has the closed form, as its strain is the same
// everywhere.
ContactOutcome press_between_plates(const SolverOptions& options) {
  constexpr double kSide = 20e-3, kDepth = 0.4e-3;
  const Material material = neo_hookean(kModulus, kRatio);
  const Scene scene = scene_of(testing::make_box({5, 5, 5}, kSide / 5, 0), material);
  Solver solver(scene, damped(options));
  solver.add_half_space({});
  const ToolId plate = solver.add_half_space({{0, 0, 0}, {0, 0, -1}}, 0, at({0, 0, kSide}));
  press(solver, plate, {0, 0, kSide}, kDepth);
  const double stress =
      uniaxial_stress(NeoHookeanModuli(scene.bodies()[0].material), 0, 1 - kDepth / kSide);
  return compare(solver.tool_force(plate).z(), -stress * kSide * kSide);
}

// A ball, a bar or a plate that is pressed into a block whose bottom is fixed.
class PressedBlock {
 public:
  PressedBlock(const SolverOptions& options, TetMesh mesh, const Capsule& capsule,
               const Eigen::Vector2f& place, double depth)
      : scene_(block_of(std::move(mesh))), solver_(scene_, damped(options)) {
    const Eigen::Vector3f touch(place.x(), place.y(), capsule.radius);
    tool_ = solver_.add_tool({&capsule, 1}, at(touch), kSmooth);
    press(solver_, tool_, touch, depth);
  }

  // N, with which it answers.
  [[nodiscard]] double force() const { return solver_.tool_force(tool_).z(); }

  // Beside the static solution of the same mesh, with what the tool touches held where it is.
  [[nodiscard]] ContactOutcome beside_statics() const {
    std::vector<Index> held;
    for (const ToolContact& contact : solver_.tool_contacts(tool_)) {
      for (std::size_t k = 0; k < 3 && contact.force.norm() > 0; ++k) {
        if (contact.vertices[k] != kInvalidIndex) {
          held.push_back(contact.vertices[k]);
        }
      }
    }
    std::ranges::sort(held);
    const auto repeated = std::ranges::unique(held);
    held.erase(repeated.begin(), repeated.end());
    return compare(force(), rest_with_held(scene_, held, solver_.positions()).force.z());
  }

 private:
  static Scene block_of(TetMesh mesh) {
    Scene scene = scene_of(std::move(mesh), neo_hookean(kModulus, kRatio));
    double bottom = 0;
    for (const Eigen::Vector3d& x : scene.positions()) {
      bottom = std::min(bottom, x.z());
    }
    scene.fix_vertices(0, vertices_below(scene, bottom + 1e-9));
    return scene;
  }

  Scene scene_;
  Solver solver_;
  ToolId tool_{};
};

// A smooth ball on a half space (Hertz 1882; Johnson, "Contact Mechanics", 4.2).
// @param edges  that the radius of the contact has
ContactOutcome press_ball(const SolverOptions& options, int edges) {
  constexpr double kRadius = 5e-3, kDepth = 1e-3;
  const double contact = std::sqrt(kRadius * kDepth);
  const double force =
      4.0 / 3 * kModulus / (1 - kRatio * kRatio) * std::sqrt(kRadius) * std::pow(kDepth, 1.5);
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, static_cast<float>(kRadius)};
  const TetMesh mesh =
      make_graded_block({contact / edges, 1.3 * contact, 10 * contact, 10 * contact});
  return compare(PressedBlock(options, mesh, ball, {0, 0}, kDepth).force(), force);
}

constexpr float kCoarseEdge = 3e-3F;

// A block of such edges.
TetMesh coarse_block() {
  constexpr double kEdge = kCoarseEdge;
  const TetMesh cubes = testing::make_box({10, 10, 5}, kEdge);
  std::vector<Eigen::Vector3d> positions;
  for (const Eigen::Vector3d& x : cubes.positions()) {
    positions.push_back(x - Eigen::Vector3d(5 * kEdge, 5 * kEdge, 5 * kEdge));
  }
  return TetMesh(std::move(positions), {cubes.tets().begin(), cubes.tets().end()});
}

// A hook of 1 mm in edges of 3 mm, beside edges of 0.3 mm in a block of that size.
ContactOutcome press_hook(const SolverOptions& options, const Capsule& hook,
                          const Eigen::Vector2f& place) {
  constexpr double kDepth = 1e-3;
  const TetMesh fine = make_graded_block({0.3e-3, 1.5e-3, 15e-3, 15e-3});
  return compare(PressedBlock(options, coarse_block(), hook, kCoarseEdge * place, kDepth).force(),
                 PressedBlock(options, fine, hook, {0, 0}, kDepth).force());
}

// What the tissue of a coarse mesh answers is its own statics.
ContactOutcome press_coarse_block(const SolverOptions& options, const Capsule& capsule,
                                  const Eigen::Vector2f& place) {
  constexpr double kDepth = 1e-3;
  return PressedBlock(options, coarse_block(), capsule, kCoarseEdge * place, kDepth)
      .beside_statics();
}

constexpr float kFriction = 0.3F;
constexpr double kSlideEdge = 5e-3;

// Of a block on a table that leans by a share of the angle of friction.
struct Slope {
  explicit Slope(double share) : angle(share * std::atan(kFriction)) {}

  [[nodiscard]] Eigen::Vector3f gravity() const {
    return kGravity * Eigen::Vector3f(std::sin(angle), 0, -std::cos(angle));
  }

  double angle;
};

Solver block_on_table(const SolverOptions& options, const Eigen::Vector3f& gravity) {
  Scene scene = scene_of(testing::make_box({4, 4, 2}, kSlideEdge),
                         {.youngs_modulus = 20e3F, .poissons_ratio = 0.4F, .damping = 0.01F});
  scene.set_gravity(gravity);
  return Solver(scene, options);
}

void step_for(Solver& solver, double seconds) {
  for (int i = 0; i * double{kCaseStep} < seconds; ++i) {
    solver.step(kCaseStep);
  }
}

ContactOutcome stick(const SolverOptions& options) {
  Solver solver = block_on_table(options, Slope(0.95).gravity());
  solver.add_half_space({}, kFriction);
  step_for(solver, 1);
  const Eigen::Vector3d before = center_of(solver);
  step_for(solver, 1);
  return compare_to_zero(1e3 * (center_of(solver) - before).norm(), 1e3 * kSlideEdge);
}

ContactOutcome slide(const SolverOptions& options) {
  const Slope slope(1.3);
  Solver solver = block_on_table(options, {0, 0, slope.gravity().z()});
  solver.add_half_space({}, kFriction);
  step_for(solver, 0.5);
  const Eigen::Vector3d before = center_of(solver);
  solver.set_gravity(slope.gravity());
  step_for(solver, 1);
  const double way = kGravity / 2 * (std::sin(slope.angle) - kFriction * std::cos(slope.angle));
  return compare(1e3 * (center_of(solver) - before).x(), 1e3 * way);
}

ContactOutcome slide_to_a_stop(const SolverOptions& options) {
  constexpr float kSpeed = 0.5F;
  Solver solver = block_on_table(options, {0, 0, -kGravity});
  solver.add_half_space({}, kFriction);
  step_for(solver, 0.5);
  const Eigen::Vector3d before = center_of(solver);
  std::vector<Eigen::Vector3f> velocities = solver.velocities();
  for (Eigen::Vector3f& v : velocities) {
    v.x() += kSpeed;
  }
  solver.write_velocities(velocities);
  step_for(solver, 0.5);
  return compare(1e3 * (center_of(solver) - before).x(),
                 1e3 * kSpeed * kSpeed / (2 * kFriction * kGravity));
}

ContactOutcome weigh(const SolverOptions& options) {
  Solver solver = block_on_table(options, {0, 0, -kGravity});
  const ToolId table = solver.add_half_space({}, kFriction);
  step_for(solver, 2);
  const double mass = 1000 * 4 * 4 * 2 * std::pow(kSlideEdge, 3);
  return compare(-solver.tool_force(table).z(), mass * kGravity);
}

ContactOutcome overlap(const SolverOptions& options) {
  Scene scene = scene_of(coarse_block(), neo_hookean(kModulus, kRatio));
  scene.fix_vertices(0, vertices_below(scene, -15e-3 + 1e-9));
  Solver solver(scene, damped(options));
  const Capsule bar{{-20e-3F, 0, 0}, {20e-3F, 0, 0}, 1e-3F};
  const Eigen::Vector3f touch(0.7e-3F, 1.1e-3F, bar.radius);
  const ToolId tool = solver.add_tool({&bar, 1}, at(touch), kSmooth);
  press(solver, tool, touch, 2e-3);
  return compare_to_zero(1e3 * overlap_of(solver, tool), 1e3 * kCoarseEdge);
}

}  // namespace

ContactOutcome compare(double value, double expected) {
  return {value, expected, 100 * (value / expected - 1)};
}

ContactOutcome compare_to_zero(double value, double unit) {
  return {value, 0, 100 * value / unit};
}

std::vector<ContactCase> contact_cases() {
  const Capsule tip{{0, 0, 0}, {0, 0, 20e-3F}, 1e-3F};
  const Capsule shaft{{-10e-3F, 0, 0}, {10e-3F, 0, 0}, 1e-3F};
  const Capsule ball{{0, 0, 0}, {0, 0, 0}, 5e-3F};
  const Capsule plate{{-4e-3F, -3e-3F, 0}, {4e-3F, -3e-3F, 0}, 1e-3F, {0, 6e-3F, 0}};
  const char* const hertz = "Hertz 1882, ball of 5 mm, 1 mm deep, 10 kPa, 0.45";
  const char* const finer = "edges of 0.3 mm";
  std::vector<ContactCase> cases{
      {"cube between plates, 2 %", "N", "uniaxial Neo-Hookean", 1, true, press_between_plates}};
  for (const auto& [edges, limit] : {std::pair(4, 15.0), std::pair(8, 7.0)}) {
    cases.push_back(
        {"ball, " + std::to_string(edges) + " edges a contact's radius", "N", hertz, limit, false,
         [edges = edges](const SolverOptions& options) { return press_ball(options, edges); }});
  }
  struct Place {
    const char* name;
    Eigen::Vector2f cells;
  };
  for (const Place& place : {Place{"a vertex", {0, 0}}, Place{"an edge", {0.5F, 0}},
                             Place{"a triangle", {0.6F, 0.3F}}}) {
    cases.push_back({"hook's tip of 1 mm above " + std::string(place.name) + " of 3 mm", "N", finer,
                     35, false, [tip, place](const SolverOptions& options) {
                       return press_hook(options, tip, place.cells);
                     }});
    cases.push_back({"hook's shaft of 1 mm above " + std::string(place.name) + " of 3 mm", "N",
                     finer, 20, false, [shaft, place](const SolverOptions& options) {
                       return press_hook(options, shaft, place.cells);
                     }});
    for (const auto& [name, capsule] : {std::pair("tip", tip), std::pair("shaft", shaft),
                                        std::pair("ball", ball), std::pair("plate", plate)}) {
      cases.push_back({std::string(name) + " above " + place.name + " of 3 mm, on that mesh", "N",
                       "statics of the mesh", 1, true,
                       [capsule = capsule, place](const SolverOptions& options) {
                         return press_coarse_block(options, capsule, place.cells);
                       },
                       2.5});
    }
  }
  cases.push_back({"block sticks at 0.95 of the angle of friction, 1 s", "mm", "none of an edge",
                   0.1, true, stick});
  cases.push_back(
      {"block slides at 1.3 of it, 1 s", "mm", "g (sin - mu cos) t^2 / 2", 2, true, slide});
  cases.push_back(
      {"block slides to a stop from 0.5 m/s", "mm", "v^2 / (2 mu g)", 2, true, slide_to_a_stop});
  cases.push_back({"weight of a block", "N", "m g", 1, true, weigh});
  cases.push_back(
      {"overlap of a bar of 1 mm, 2 mm deep", "mm", "none of an edge", 1, true, overlap});
  return cases;
}

}  // namespace pbdsurg::bench
