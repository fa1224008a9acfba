// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/guide.h"

namespace cholecystectomy {
namespace {

constexpr float kWay = 0.01F;   // m that count as a move
constexpr float kPull = 0.5F;   // N
constexpr float kTurn = 0.05F;  // of the unit view

}  // namespace

void Guide::update(const SceneState& state, const Controls& controls, const Scope& scope,
                   double now) {
  if (hint_ > kHints || state.phase != Phase::playing) {
    return;
  }
  const bool is_over = hint_ == kHints && now > since_ + kFarewell;
  if (!has_begun_ || is_over || (hint_ < kHints && is_followed(state, controls, scope))) {
    hint_ += has_begun_ ? 1 : 0;
    has_begun_ = true;
    since_ = now;
    grasper_ = controls.tip(Controls::grasper);
    view_ = scope.view();
  }
}

bool Guide::is_followed(const SceneState& state, const Controls& controls,
                        const Scope& scope) const {
  switch (hint_) {
    case 0:
      return (controls.tip(Controls::grasper) - grasper_).norm() > kWay;
    case 1:
      return state.grasper.is_holding;
    case 2:
      return state.grasper.is_holding && state.grasper.force.norm() > kPull;
    case 3:
      return controls.chosen() == Controls::hook;
    case 4:
      return state.generator.activation != pbdsurg::Activation::none && state.generator.is_touching;
    default:
      return (scope.view() - view_).norm() > kTurn;
  }
}

}  // namespace cholecystectomy
