// SPDX-License-Identifier: Apache-2.0
#include "tests/haptics/simulated_tissue.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pbdsurg/contact/between_jaws.h"

#include "bench/support/static_energy.h"
#include "tests/support/meshes.h"

namespace pbdsurg::testing {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr double kBlockEdge = 5e-3;  // m
constexpr double kPointedEdge = 4e-3;
constexpr float kPlateRadius = 2e-3F, kRodRadius = 2e-3F, kBallRadius = 3e-3F;

Material soft(float youngs_modulus) {
  return {.model = ElasticModel::neo_hookean,
          .youngs_modulus = youngs_modulus,
          .poissons_ratio = 0.4F,
          .damping = 1e-3F};
}

// A box of cubes with a place of its top at the origin, fixed below.
Scene box(const std::array<Index, 3>& cells, double edge, const Vector3d& top,
          const Material& material) {
  const TetMesh mesh = make_box(cells, edge);
  std::vector<Vector3d> positions(mesh.positions().begin(), mesh.positions().end());
  for (Vector3d& x : positions) {
    x -= top;
  }
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  const BodyId body = scene.add_body(
      "block", TetMesh(std::move(positions), {mesh.tets().begin(), mesh.tets().end()}), material);
  const double bottom = -cells[1] * edge + 1e-6;
  scene.fix_where(body, [&](const Vector3d& x) { return x.y() < bottom; });
  return scene;
}

ToolPose at_height(double y) {
  ToolPose pose = ToolPose::Identity();
  pose.translation().y() = static_cast<float>(y);
  return pose;
}

std::vector<Index> all_bodies(const Solver& solver) {
  std::vector<Index> bodies;
  for (Index body = 0; body < static_cast<Index>(solver.tissue().bodies().size()); ++body) {
    bodies.push_back(body);
  }
  return bodies;
}

}  // namespace

SimulatedTissue::SimulatedTissue(const Scene& scene, const FeltTool& tool)
    : solver_(scene),
      tool_(solver_.add_tool(tool.capsules, at_height(kAbove), tool.surface)),
      probe_(solver_, all_bodies(solver_), tool.points) {}

void SimulatedTissue::operator()(ContactPacket& packet, double time) {
  solver_.move_tool(tool_, pose_of(packet));
  if (grip_ && time >= kEngaged) {
    constexpr float kOpening = 30e-3F, kSpacing = 2e-3F;
    solver_.grasp(tool_, find_points_between(solver_, 0, tool_, grip_->pad, kOpening, kSpacing),
                  *grip_);
    grip_.reset();
  }
  constexpr double kLongest = 0.1;  // s
  const double passed = std::clamp(time - time_, Rig::kTick, kLongest);
  solver_.step(static_cast<float>(passed));
  time_ = time;
  forces_.push_back(solver_.tool_force(tool_));
  packet = make_contact_packet(probe_, solver_, tool_, grasp(), packet.sequence, packet.time);
}

GraspState SimulatedTissue::grasp() const {
  const GripState state = solver_.tool_grip(tool_).state;
  if (state == GripState::holding || state == GripState::slipping) {
    return GraspState::held;
  }
  return state == GripState::torn ? GraspState::torn : GraspState::open;
}

FakeTissue felt(std::shared_ptr<SimulatedTissue> tissue) {
  return
      [tissue = std::move(tissue)](ContactPacket& packet, double time) { (*tissue)(packet, time); };
}

Scene spring_block() {
  return box({4, 5, 4}, kBlockEdge, {2 * kBlockEdge, 5 * kBlockEdge, 2 * kBlockEdge}, soft(5e3F));
}

FeltTool plate() {
  constexpr float kHalf = 15e-3F, kPoint = 8e-3F;
  FeltTool tool;
  tool.capsules = {{.start = {-kHalf, kPlateRadius, -kHalf},
                    .end = {kHalf, kPlateRadius, -kHalf},
                    .radius = kPlateRadius,
                    .across = {0, 0, 2 * kHalf}}};
  for (const float x : {-kPoint, kPoint}) {
    for (const float z : {-kPoint, kPoint}) {
      tool.points.push_back({{x, kPlateRadius, z}, kPlateRadius});
    }
  }
  tool.surface.friction = 2;
  return tool;
}

double plate_force(double depth) {
  const Scene scene = spring_block();
  std::vector<Index> top;
  bench::Positions places(scene.positions().begin(), scene.positions().end());
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (places[v].y() > -1e-6) {
      places[v].y() = -depth;
      top.push_back(v);
    }
  }
  bench::StaticEnergy energy(scene);
  energy.hold(top);
  constexpr int kSteps = 8;
  double sum = 0;
  for (const Vector3d& force :
       energy.holding_forces(top, bench::find_equilibrium_by_steps(energy, places, kSteps))) {
    sum -= force.y();
  }
  return sum;
}

Scene pointed_block(Place place) {
  constexpr double kMiddle = 3 * kPointedEdge, kTop = 6 * kPointedEdge;
  Vector3d top(kMiddle, kTop, kMiddle);
  if (place == Place::edge) {
    top.x() += kPointedEdge / 2;
  } else if (place == Place::face) {
    top += Vector3d(kPointedEdge / 3, 0, kPointedEdge * 2 / 3);
  }
  return box({6, 6, 6}, kPointedEdge, top, soft(8e3F));
}

FeltTool rod() {
  constexpr float kLength = 40e-3F;
  FeltTool tool;
  tool.capsules = {{{0, kRodRadius, 0}, {0, kLength, 0}, kRodRadius}};
  tool.points = {{{0, kRodRadius, 0}, kRodRadius}};
  return tool;
}

std::vector<PressedScene> pressed_scenes() {
  return {{"plate with four points", spring_block, plate},
          {"rod on a face", [] { return pointed_block(Place::face); }, rod},
          {"rod on an edge", [] { return pointed_block(Place::edge); }, rod},
          {"rod on a vertex", [] { return pointed_block(Place::vertex); }, rod},
          {"ball on a sheet", held_sheet, ball}};
}

std::vector<Case> simulated_grid() {
  std::vector<Case> cases;
  for (const double mass : {0.03, 0.06}) {
    for (const double damping : {0.1, 1.0}) {
      for (const int delay : {0, 20}) {
        for (const bool has_hand : {false, true}) {
          cases.push_back({{.mass = mass,
                            .damping = damping,
                            .has_hand = has_hand,
                            .is_guided = !has_hand,
                            .position = {0, kAbove, 0}},
                           delay});
        }
      }
    }
  }
  return cases;
}

Pressed press(const PressedScene& scene, const Case& one) {
  const auto tissue = std::make_shared<SimulatedTissue>(scene.scene(), scene.tool());
  Pressed pressed{pushed(one, felt(tissue)), 0, 0, 0};
  constexpr std::ptrdiff_t kTicks = 1000, kPackets = 100;
  const Rig& rig = pressed.rig;
  for (std::size_t i = rig.positions.size() - kTicks; i < rig.positions.size(); ++i) {
    pressed.depth -= rig.positions[i].y() / kTicks;
    pressed.felt += double{rig.commanded[i].y()} / kTicks;
  }
  const std::vector<Vector3f>& forces = tissue->forces();
  for (std::size_t i = forces.size() - kPackets; i < forces.size(); ++i) {
    pressed.simulated += double{forces[i].y()} / kPackets;
  }
  return pressed;
}

Scene standing_slab() {
  constexpr double kEdge = 4e-3;
  return box({10, 8, 3}, kEdge, {5 * kEdge, 8 * kEdge, 1.5 * kEdge}, soft(10e3F));
}

FeltTool jaws() {
  FeltTool tool;
  tool.points = {{{0, 0, 0}, kRodRadius}};
  return tool;
}

Grip slab_grip() {
  Grip grip{.clamp_force = 10};
  grip.pad.center = {0, -5e-3F, 0};
  grip.pad.half_length = 8e-3F;
  grip.pad.half_width = 4e-3F;
  return grip;
}

Rig pulled_slab(const Grip& grip) {
  const auto tissue = std::make_shared<SimulatedTissue>(standing_slab(), jaws());
  tissue->close_jaws(grip);
  Rig rig = in_the_air(felt(tissue));
  constexpr double kSpeed = 14e-3, kPull = 1;  // m/s, s
  guide(rig, kPull, [](double time) { return Vector3d(0, kAbove + kSpeed * time, 0); });
  rig.run(1);
  return rig;
}

Scene held_sheet() {
  constexpr Index kCells = 10;
  constexpr double kEdge = 4e-3, kHalf = kCells * kEdge / 2;
  std::vector<Vector3d> points;
  std::vector<Triangle> triangles;
  std::vector<Index> rim;
  for (Index i = 0; i <= kCells; ++i) {
    for (Index j = 0; j <= kCells; ++j) {
      if (i == 0 || j == 0 || i == kCells || j == kCells) {
        rim.push_back(static_cast<Index>(points.size()));
      }
      points.emplace_back(kEdge * i - kHalf, 0, kEdge * j - kHalf);
    }
  }
  for (Index i = 0; i < kCells; ++i) {
    for (Index j = 0; j < kCells; ++j) {
      const Index a = i * (kCells + 1) + j, b = a + kCells + 1;
      triangles.push_back({a, a + 1, b + 1});
      triangles.push_back({a, b + 1, b});
    }
  }
  Scene scene;
  scene.set_gravity(Vector3f::Zero());
  const BodyId sheet = scene.add_sheet("sheet", points, triangles, {.damping = 1e-3F});
  scene.fix_vertices(sheet, rim);
  return scene;
}

FeltTool ball() {
  FeltTool tool;
  const Vector3f center(0, kBallRadius, 0);
  tool.capsules = {{center, center, kBallRadius}};
  tool.points = {{center, kBallRadius}};
  return tool;
}

}  // namespace pbdsurg::testing
