// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A session of the demo's scene in low detail, played by hands that tests move.

#include <array>

#include "apps/cholecystectomy/play/hand.h"
#include "apps/cholecystectomy/play/session.h"

namespace cholecystectomy {

struct LoadedScene {
  LoadedAnatomy anatomy = load_anatomy({}, Detail::low);
  SurgicalScene scene = make_scene(anatomy, pbdsurg::ElasticModel::neo_hookean);

  /// Made once: it takes a second.
  static const LoadedScene& get() {
    static const LoadedScene loaded;
    return loaded;
  }
};

struct PlayedSession {
  explicit PlayedSession(std::uint32_t generation = 1)
      : session(LoadedScene::get().scene, LoadedScene::get().anatomy.anatomy.abdominal_wall,
                solver_options(pbdsurg::executor::threads(), false), {&hands[0], &hands[1]},
                generation) {}

  void step(int count) {
    for (int i = 0; i < count; ++i) {
      session.step(orders, clock.now(), events);
    }
  }

  /// A hand goes to a point, in so many steps.
  void go(int hand, const Eigen::Vector3f& point, int steps) {
    const Eigen::Vector3f way = (point - hands[hand].tip()) / static_cast<float>(steps);
    for (int i = 0; i < steps; ++i) {
      hands[hand].move(way);
      step(1);
    }
  }

  /// What a window that has seen nothing gets.
  SceneState whole() {
    SceneState state;
    session.fill(state, {});
    return state;
  }

  /// The vertex of an organ that lies farthest in a direction, m.
  Eigen::Vector3f farthest(Organ organ, const Eigen::Vector3f& direction) {
    const SceneState state = whole();
    const auto& positions = state.whole[static_cast<std::size_t>(organ)].positions;
    return *std::max_element(positions.begin(), positions.end(),
                             [&](const Eigen::Vector3f& a, const Eigen::Vector3f& b) {
                               return a.dot(direction) < b.dot(direction);
                             });
  }

  [[nodiscard]] std::uint32_t count(Event event) const {
    return events[static_cast<std::size_t>(event)];
  }

  pbdsurg::VirtualClock clock;
  std::array<MouseHand, 2> hands{
      {{"left", {{-0.05F, 0.05F, -0.16F}, {0.03F, 0, 0}, 0.14F}, {-0.04F, 0.03F, -0.06F}, clock},
       {"right", {{0.12F, -0.08F, -0.16F}, {0.03F, 0, 0}, 0.14F}, {0.1F, -0.04F, -0.06F}, clock}}};
  Orders orders;
  EventCounts events{};
  Session session;
};

}  // namespace cholecystectomy
