// SPDX-License-Identifier: Apache-2.0
#include "bench/haptic_rate/rate_loop.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "pbdsurg/anatomy/table2_family.h"
#include "pbdsurg/tissue/library.h"

#include "bench/support/neo_hookean.h"
#include "bench/support/timing.h"

namespace pbdsurg::bench {
namespace {

constexpr float kRadius = 4e-3F;     // m, of the ball
constexpr double kModulus = 15e3;    // Pa: under that ball 150 N/m, which a servo renders as it is
constexpr float kDrag = 20;          // 1/s, as in the demo: it stands for the organs around
constexpr Index kMostShrinking = 4;  // tets an edit
constexpr double kPower = 30;        // W, as the demo's hook

constexpr float kMiddle = 35e-3F, kFarthest = 12e-3F;  // m, along x: where the top is level
constexpr float kSample = 0.25e-3F;                    // m, of heights

Scene make_scene(int row) {
  const TetMesh mesh = table2_mesh(row, Table2Kind::hollow);
  const Eigen::AlignedBox3d box = bounding_box(mesh);
  const double bed = box.min().z() + box.sizes().z() / 3;
  Scene scene;
  const Index organ = scene.add_body("gallbladder", mesh, neo_hookean(kModulus, 0.45));
  scene.fix_where(organ, [&](const Eigen::Vector3d& x) { return x.z() < bed; });
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

// m, where the ball's lowest point is when it first touches a vertex from above.
float touch_height(const Scene& scene, float x, float y) {
  float height = -1;
  for (const Eigen::Vector3d& position : scene.positions()) {
    const Eigen::Vector3f at = position.cast<float>();
    const float square =
        kRadius * kRadius - (at.x() - x) * (at.x() - x) - (at.y() - y) * (at.y() - y);
    if (square > 0) {
      height = std::max(height, at.z() + std::sqrt(square) - kRadius);
    }
  }
  return height;
}

std::vector<float> find_heights(const Scene& scene) {
  std::vector<float> heights;
  for (float way = -kFarthest; way < kFarthest + 2 * kSample; way += kSample) {
    heights.push_back(touch_height(scene, kMiddle + way, 0));
  }
  return heights;
}

SolverOptions solver_options(const Executor& executor) {
  SolverOptions options{.damping = kDrag};
  options.executor = executor;
  return options;
}

CauteryOptions cautery_options(const Executor& executor) {
  CauteryOptions options;
  options.shrink_limit = kMostShrinking;
  options.heat.executor = options.potential.executor = executor;
  return options;
}

std::array<Capsule, 1> ball() {
  const Eigen::Vector3f center(0, 0, kRadius);  // above the tip
  return {{{center, center, kRadius}}};
}

bool is_empty(const TopologyEdit& edit) {
  return edit.remove_tets.empty() && edit.rest_lengths.empty() && edit.rest_volumes.empty() &&
         edit.rest_areas.empty() && edit.stiffnesses.empty() && edit.triangle_stiffnesses.empty();
}

}  // namespace

RateLoop::RateLoop(int row, const Executor& executor, const Executor& heat)
    : scene_(make_scene(row)),
      solver_(scene_, solver_options(executor)),
      surface_(shared_surface(solver_.tissue(), 0)),
      // of vertices alone, as rest_under_ball() has it
      tool_(solver_.add_tool(ball(), ToolPose::Identity(), {ContactFeatures::vertices})),
      cautery_(solver_.tissue(), std::array{ThermalBody{0, tissues::gallbladder_wall().heat}},
               cautery_options(heat)),
      probe_(solver_, std::array<Index, 1>{0}, std::array{ToolPoint{ball()[0].start, kRadius}}),
      heights_(find_heights(scene_)) {}

ToolPose RateLoop::pose_at(double depth, double way) const {
  const float along = std::clamp(static_cast<float>(way), -kFarthest, kFarthest);
  const float place = (along + kFarthest) / kSample;
  const auto sample = static_cast<std::size_t>(place);
  const float share = place - static_cast<float>(sample);
  const float height = (1 - share) * heights_[sample] + share * heights_[sample + 1];
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(kMiddle + along, 0, height - static_cast<float>(depth));
  return pose;
}

RateStep RateLoop::step(double depth, double way, bool burns) {
  const ToolPose hand = pose_at(depth, way);
  const double time = kStep * static_cast<double>(++steps_);
  RateStep step;
  ContactPacket packet;
  StepReport report;
  // reading for heat and the edit that it asks for are of two steps, as each is a part of one
  if (burns) {
    owed_ += kStep;
    ++since_heat_;
  }
  const bool is_busy = heat_.is_busy();
  Heated* const heated = is_busy ? nullptr : heat_.take_result();
  const bool is_due = burns && since_heat_ >= 2;
  const bool starts = is_due && !is_busy && heated == nullptr;
  step.is_heat_late = is_busy && since_heat_ == 2;
  if (starts) {
    step.reading_ms = time_of([&] { cautery_.read_positions(solver_); });
  }
  if (heated != nullptr) {
    step.heat_ms = heated->time_ms;
    step.heated_ms = 1e3 * heated->dt;
    step.is_heated = heated->report.energy > 0;
    step.removed_tets = static_cast<Index>(heated->edit.remove_tets.size());
  }
  step.solver_ms = time_of([&] {
    solver_.move_tool(tool_, hand);
    solver_.start_step(static_cast<float>(kStep));
    step.edit_ms = time_of([&] {
      if (heated != nullptr && !is_empty(heated->edit)) {  // while a device steps
        solver_.tissue().apply(heated->edit);
        cautery_.commit(heated->report);
      }
    });
    if (starts) {
      heat_.start(hand.translation(), cut_settings(kPower), std::exchange(owed_, 0));
      since_heat_ = 0;
    }
    report = solver_.finish_step();
  });
  step.contact_ms = time_of([&] {
    probe_.collect_patch(solver_, tool_, GraspState::open, steps_, time, patch_);
    packet = make_contact_packet(patch_, hand);
  });
  step.servo_ms =
      time_of([&] { step.felt = servo_tick(servo_, packet, {.time = time, .tip = hand}); });
  step.force = vector_of(packet.force);
  step.is_touching = report.contacts > 0;
  if (report.non_finite_vertices > 0) {
    throw Error(std::to_string(report.non_finite_vertices) + " vertices are not finite");
  }
  return step;
}

HeldRest RateLoop::rest() const {
  const ToolPose pose = solver_.tool_pose(tool_);
  return rest_under_ball(scene_, (pose * ball()[0].start).cast<double>(), double{kRadius},
                         solver_.positions());
}

}  // namespace pbdsurg::bench
