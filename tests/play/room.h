// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Hands, a scope and their controls, without a simulation or a window.

#include <array>
#include <cmath>
#include <vector>

#include "apps/cholecystectomy/play/controls.h"

namespace cholecystectomy {

inline constexpr int kHeight = 480;

struct Room {
  pbdsurg::VirtualClock clock;
  std::array<MouseHand, 2> hands{
      {{"left", {{-0.05F, 0.05F, -0.16F}, {0, 0, 0}, 0.2F}, {-0.02F, 0, 0}, clock},
       {"right", {{0.12F, -0.08F, -0.16F}, {0, 0, 0}, 0.2F}, {0.02F, 0, 0}, clock}}};
  Scope scope = Scope::looking_at({0, -0.2F, -0.1F}, {0, 0, 0});
  CameraAssistant assistant{{0, 0, 0}, 0.25F};
  Orders orders;
  Controls controls{hands, scope, assistant, orders};

  void handle(const std::vector<Input>& inputs) { controls.handle(inputs, kHeight); }
  void press(Key key, bool has_shift = false) {
    handle({KeyInput{key, true, has_shift}, KeyInput{key, false, has_shift}});
  }

  /// Where a point is in the picture, pixels from its middle: right, down.
  [[nodiscard]] Eigen::Vector2f place_of(const Eigen::Vector3f& point) const {
    const Camera camera = scope.camera();
    const Eigen::Vector3f ahead = (camera.target - camera.eye).normalized();
    const Eigen::Vector3f side = ahead.cross(camera.up).normalized();
    const Eigen::Vector3f way = point - camera.eye;
    const float scale =
        kHeight / (2 * std::tan(camera.vertical_field_of_view / 2) * way.dot(ahead));
    return scale * Eigen::Vector2f(way.dot(side), -way.dot(side.cross(ahead)));
  }
};

}  // namespace cholecystectomy
