// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/frame_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr double kPower = 15;         // W
constexpr float kWireRadius = 1e-3F;  // m
constexpr float kWire = 10e-3F;       // m long
constexpr float kShaftRadius = 2.5e-3F;
constexpr float kShaft = 0.2F;
constexpr float kDepth = 1.5e-3F;  // m into the liver
constexpr float kReach = 2e-3F;    // m to either side
constexpr double kPeriod = 1;      // s, of its way to and fro
constexpr float kAway = 0.05F;     // m

Eigen::Vector3f lowest_vertex(const Scene& scene, const Body& body) {
  const auto positions = scene.positions().subspan(static_cast<std::size_t>(body.first_vertex),
                                                   static_cast<std::size_t>(body.vertex_count));
  return std::ranges::min_element(positions, {}, [](const auto& x) { return x.z(); })
      ->cast<float>();
}

// The shaft comes from below.
ToolPose at(const Eigen::Vector3f& tip) {
  ToolPose pose = ToolPose::Identity();
  pose.linear() =
      Eigen::AngleAxisf(std::numbers::pi_v<float>, Eigen::Vector3f::UnitX()).toRotationMatrix();
  pose.translation() = tip;
  return pose;
}

}  // namespace

FrameWorld::FrameWorld(const Scene& scene, const SolverOptions& options, double step)
    : world_(options),
      step_(step),
      lowest_(lowest_vertex(scene, scene.body(scene.find_body("liver")))) {
  const std::array tissues{tissues::gallbladder_wall(), tissues::liver()};
  making_.solver = time_of([&] { world_ = World(scene, tissues, {}, options); });
  pose_ = at(lowest_);
  hook_ = world_.add_tool(
      {{{0, 0, 0}, {0, 0, kWire}, kWireRadius}, {{0, 0, kWire}, {0, 0, kShaft}, kShaftRadius}},
      pose_);
  const std::array bodies{world_.find_body("gallbladder"), world_.find_body("liver")};
  making_.heat = time_of([&] { burner_ = world_.add_cautery(hook_, bodies); });
  making_.surfaces = time_of([&] {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      surfaces_[b] = &world_.surface(bodies[b]);
    }
  });
}

Frame FrameWorld::next() {
  time_ += step_;
  const float phase = static_cast<float>(2 * std::numbers::pi * time_ / kPeriod);
  pose_ = at(lowest_ + Eigen::Vector3f(kReach * std::sin(phase), 0, kDepth));
  world_.move(hook_, pose_);
  world_.energise(burner_, cut_settings(kPower));
  Frame frame = world_.step(step_);
  if (!frame.ok()) {
    throw Error(std::string("a frame on backend ") + world_.solver().backend_name() + ": " +
                frame.why());
  }
  return frame;
}

double FrameWorld::contact_ms(int rounds) {
  Solver& solver = world_.solver();
  const Snapshot start = solver.snapshot();
  const auto dt = static_cast<float>(step_);
  ToolPose away = pose_;
  away.translation().z() -= kAway;
  std::vector<double> with, without;
  for (int round = 0; round < rounds; ++round) {
    const auto timed = [&](const ToolPose& pose) {
      solver.restore(start);
      solver.move_tool(hook_, pose);
      solver.step(dt);  // takes the start to a device, and the hook to its place
      return time_of([&] { solver.step(dt); });
    };
    with.push_back(timed(pose_));
    without.push_back(timed(away));
  }
  solver.restore(start);
  return *std::ranges::min_element(with) - *std::ranges::min_element(without);
}

}  // namespace pbdsurg::bench
