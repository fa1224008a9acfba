// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/camera_assistant.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

namespace cholecystectomy {
namespace {

using Points = std::vector<Eigen::Vector3f>;
using Pose = Eigen::Vector4f;  // azimuth, elevation, insertion, focus

constexpr float kStiffness = 2.5F;  // 1/s, of the spring
constexpr float kClosest = 0.09F;   // m, along the view, to tips that are close together
constexpr float kTooSmall = 1.3F;   // times the distance that would do
constexpr float kWorthIt = 0.1F;    // s at full speed: shorter ways are not begun
constexpr float kArrived = 0.03F;   // s at full speed, and of full speed
constexpr float kClearance = CameraAssistant::kNearest + 0.01F;  // m: nearer ones are left first

// The middle of the box around them: of two, halfway.
Eigen::Vector3f middle_of(const Points& tips) {
  Eigen::Vector3f least = tips[0], most = tips[0];
  for (const Eigen::Vector3f& tip : tips) {
    least = least.cwiseMin(tip);
    most = most.cwiseMax(tip);
  }
  return 0.5F * (least + most);
}

float half_height(const Scope& scope) {
  return std::tan(scope.camera().vertical_field_of_view / 2);
}

// m, from lens to middle, that shows tips well along a view.
float distance_for(const Points& tips, const Scope& scope) {
  if (tips.size() == 1) {
    return std::max(scope.options().working_distance, kClosest);
  }
  const Eigen::Vector3f middle = middle_of(tips), view = scope.view();
  float distance = kClosest;
  for (const Eigen::Vector3f& tip : tips) {
    const float ahead = (tip - middle).dot(view);
    const float aside = (tip - middle - ahead * view).norm();
    distance = std::max(
        distance,
        std::max(aside / (CameraAssistant::kMargin * half_height(scope)), kClosest) - ahead);
  }
  return distance;
}

// m, from the lens; infinite where there is none.
float distance_to_nearest(const Points& tips, const Scope& scope) {
  float nearest = std::numeric_limits<float>::infinity();
  for (const Eigen::Vector3f& tip : tips) {
    nearest = std::min(nearest, (tip - scope.tip()).norm());
  }
  return nearest;
}

// Whether the picture can stay as it is.
bool shows_well(const Points& tips, const Scope& scope) {
  const Eigen::Vector3f view = scope.view();
  const float inner = CameraAssistant::kInnerPart * half_height(scope);
  const bool all_inside = std::ranges::all_of(tips, [&](const Eigen::Vector3f& tip) {
    const Eigen::Vector3f way = tip - scope.tip();
    const float ahead = way.dot(view);
    return (way - ahead * view).norm() <= inner * ahead;
  });
  return all_inside && distance_to_nearest(tips, scope) >= CameraAssistant::kNearest &&
         (middle_of(tips) - scope.tip()).dot(view) <= kTooSmall * distance_for(tips, scope);
}

// The scope as it should be. The distance depends on the view, and the view so little on the
// distance that any will do for it.
Scope arranged(const Points& tips, const Scope& scope) {
  Scope goal = scope;
  const Eigen::Vector3f middle = middle_of(tips);
  goal.look_at(middle, scope.options().working_distance);
  goal.look_at(middle, distance_for(tips, goal));
  return goal;
}

// What turns and slides in one go. In s at full speed, so that one limit serves all.
Pose way_between(const Scope& from, const Scope& to) {
  constexpr float kTurn = static_cast<float>(2 * std::numbers::pi);
  return {std::remainder(to.azimuth() - from.azimuth(), kTurn) / CameraAssistant::kTurningSpeed,
          (to.elevation() - from.elevation()) / CameraAssistant::kTurningSpeed,
          (to.insertion() - from.insertion()) / CameraAssistant::kSlidingSpeed,
          (to.focus() - from.focus()) / CameraAssistant::kSlidingSpeed};
}

Scope pulled_out(Scope scope) {
  scope.advance(-scope.insertion());
  return scope;
}

Scope moved(Scope scope, const Pose& way) {
  const float focus = scope.focus() + CameraAssistant::kSlidingSpeed * way[3];
  scope.orbit(CameraAssistant::kTurningSpeed * way[0], CameraAssistant::kTurningSpeed * way[1]);
  scope.advance(CameraAssistant::kSlidingSpeed * way[2]);
  scope.set_focus(focus);
  return scope;
}

// The step of a critically damped spring, exact for any length of it. A longer way pulls as one
// that ends in full speed does: the speed never exceeds 1.
Pose pull(Pose way, Pose& speed, float dt) {
  way *= std::min(1.0F, 2 / (kStiffness * std::max(way.norm(), 1e-6F)));
  const float decay = std::exp(-kStiffness * dt);
  const Pose slack = (speed - kStiffness * way) * dt;
  speed = decay * (speed - kStiffness * slack);
  return way + decay * (slack - way);
}

}  // namespace

CameraAssistant::CameraAssistant(const Eigen::Vector3f& centre, float radius)
    : centre_(centre), radius_(radius) {
  if (!centre.allFinite()) {
    throw pbdsurg::InvalidArgument("the centre of the camera assistant's scene is not finite");
  }
  if (!(radius > 0)) {
    throw pbdsurg::InvalidArgument("the radius of the camera assistant's scene is " +
                                   std::to_string(radius) + " m; it must be positive");
  }
}

void CameraAssistant::switch_on(bool is_on) {
  is_on_ = is_on;
  is_moving_ = false;
  speed_.setZero();
}

void CameraAssistant::follow(Scope& scope, std::span<const Eigen::Vector3f> tips, double dt) {
  if (!(dt >= 0 && std::isfinite(dt))) {
    throw pbdsurg::InvalidArgument("the camera assistant's step is " + std::to_string(dt) +
                                   " s; it must be finite and not negative");
  }
  if (!is_on_) {
    return;
  }
  Points watched;  // of finite places alone, for others compare as false
  std::ranges::copy_if(tips, std::back_inserter(watched), [&](const Eigen::Vector3f& tip) {
    return (tip - centre_).norm() <= radius_;
  });
  const float nearest = distance_to_nearest(watched, scope);
  const Pose back = way_between(scope, pulled_out(scope));
  const Pose way = watched.empty()        ? Pose::Zero()
                   : nearest < kClearance ? back
                                          : way_between(scope, arranged(watched, scope));
  is_moving_ = is_moving_ || (way.norm() > kWorthIt && !shows_well(watched, scope));
  if (!is_moving_) {
    return;
  }
  const auto duration = static_cast<float>(std::min(dt, kLongestStep));
  Pose speed = speed_;
  Scope next = moved(scope, pull(way, speed, duration));
  const float distance = distance_to_nearest(watched, next);
  if (distance < kNearest && distance < nearest) {
    // straight back is safe: the shaft has been there
    speed = {0, 0, std::min(speed_[2], 0.0F), std::max(speed_[3], 0.0F)};
    next = moved(scope, pull(back, speed, duration));
  }
  scope = next;
  speed_ = speed;
  if (way.norm() < kArrived && speed_.norm() < kArrived) {
    is_moving_ = false;
    speed_.setZero();
  }
}

}  // namespace cholecystectomy
