// SPDX-License-Identifier: Apache-2.0
#include "bench/frames/frame_world.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr double kPower = 15;    // W
constexpr double kPeriod = 1;    // s, of the instruments' way to and fro
constexpr float kReach = 2e-3F;  // m to either side
constexpr float kAway = 0.5F;    // m, from both organs

// Of the hook, from below.
constexpr float kWireRadius = 1e-3F;
constexpr float kWire = 10e-3F;
constexpr float kDepth = 1.5e-3F;

// Of the grasper, whose closed jaws lie on the liver.
constexpr float kJawRadius = 3e-3F;
constexpr float kJaws = 20e-3F;
constexpr float kPress = 3e-3F;
const Eigen::Vector3f kBeside(12e-3F, 8e-3F, 0);  // of the hook

constexpr TissueContact kBodies{.thickness = 0.5e-3F, .friction = 0.1F};
constexpr float kShaftRadius = 2.5e-3F;
constexpr float kShaft = 0.2F;

Eigen::Vector3f lowest_vertex(const Scene& scene, const Body& body) {
  const auto positions = scene.positions().subspan(static_cast<std::size_t>(body.first_vertex),
                                                   static_cast<std::size_t>(body.vertex_count));
  return std::ranges::min_element(positions, {}, [](const auto& x) { return x.z(); })
      ->cast<float>();
}

// @param angle  by which a shaft along z turns about x
ToolPose at(const Eigen::Vector3f& tip, float angle) {
  ToolPose pose = ToolPose::Identity();
  pose.linear() = Eigen::AngleAxisf(angle, Eigen::Vector3f::UnitX()).toRotationMatrix();
  pose.translation() = tip;
  return pose;
}

}  // namespace

FrameWorld::FrameWorld(const Scene& scene, const SolverOptions& options, double step,
                       FrameContact contact)
    : world_(options),
      step_(step),
      contact_(contact),
      lowest_(lowest_vertex(scene, scene.body(scene.find_body("liver")))) {
  const std::array tissues{tissues::gallbladder_wall(), tissues::liver()};
  making_.solver = time_of([&] { world_ = World(scene, tissues, {}, options); });
  aim();
  hook_ = world_.add_tool(
      {{{0, 0, 0}, {0, 0, kWire}, kWireRadius}, {{0, 0, kWire}, {0, 0, kShaft}, kShaftRadius}},
      hook_pose_);
  grasper_ = world_.add_tool(
      {{{0, 0, 0}, {0, 0, kJaws}, kJawRadius}, {{0, 0, kJaws}, {0, 0, kShaft}, kShaftRadius}},
      grasper_pose_);
  const std::array bodies{world_.find_body("gallbladder"), world_.find_body("liver")};
  if (contact_ == FrameContact::all) {
    world_.set_contact(bodies[0], bodies[1], kBodies);
  }
  making_.heat = time_of([&] { burner_ = world_.add_cautery(hook_, bodies); });
  making_.surfaces = time_of([&] {
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      surfaces_[b] = &world_.surface(bodies[b]);
    }
  });
}

void FrameWorld::aim() {
  const float phase = static_cast<float>(2 * std::numbers::pi * time_ / kPeriod);
  const Eigen::Vector3f place =
      lowest_ +
      Eigen::Vector3f(kReach * std::sin(phase), 0, contact_ == FrameContact::all ? 0 : -kAway);
  hook_pose_ = at(place + Eigen::Vector3f(0, 0, kDepth), std::numbers::pi_v<float>);
  grasper_pose_ = at(place + kBeside + Eigen::Vector3f(0, 0, kPress - kJawRadius),
                     0.5F * std::numbers::pi_v<float>);
}

Frame FrameWorld::next() {
  time_ += step_;
  aim();
  world_.move(hook_, hook_pose_);
  world_.move(grasper_, grasper_pose_);
  world_.energise(burner_, cut_settings(kPower));
  Frame frame = world_.step(step_);
  if (!frame.ok()) {
    throw Error(std::string("a frame on backend ") + world_.solver().backend_name() + ": " +
                frame.why());
  }
  return frame;
}

}  // namespace pbdsurg::bench
