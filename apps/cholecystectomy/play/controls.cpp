// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/controls.h"

#include <algorithm>
#include <cmath>

namespace cholecystectomy {
namespace {

constexpr float kNotch = 2e-3F;          // m along the view
constexpr float kRollStep = 0.2F;        // rad
constexpr float kPostStep = 0.15F;       // rad
constexpr float kOrbitPerHeight = 1.2F;  // rad for a drag over the height of the picture
constexpr float kSlide = 4e-3F;          // m a notch, of the scope
constexpr float kSlowMotion = 0.25F;

}  // namespace

Controls::Controls(std::array<MouseHand, 2>& hands, Scope& scope, CameraAssistant& assistant,
                   Orders& orders, bool is_left_handed)
    : hands_(hands),
      scope_(scope),
      assistant_(assistant),
      orders_(orders),
      is_left_handed_(is_left_handed) {}

void Controls::handle(const std::vector<Input>& inputs, int height) {
  for (const Input& input : inputs) {
    if (const auto* pressed = std::get_if<KeyInput>(&input)) {
      key(*pressed);
    } else if (const auto* button = std::get_if<ButtonInput>(&input)) {
      if (button->button == MouseButton::left) {
        (moves_hand() ? moves_tip_ : moves_scope_) = button->is_down;
      } else if (button->button == MouseButton::right) {
        moves_scope_ = button->is_down;
      } else if (button->is_down) {
        toggle_jaw();
      }
    } else if (const auto* moved = std::get_if<CursorInput>(&input)) {
      cursor(*moved, height);
    } else if (const auto* turned = std::get_if<WheelInput>(&input)) {
      wheel(turned->notches);
    } else if (!std::get<FocusInput>(input).has_focus) {
      let_go();
    }
  }
}

void Controls::set_devices(const std::array<bool, 2>& has_device) {
  has_device_ = has_device;
  choose(has_device[grasper] ? hook : grasper);
}

void Controls::choose(Role role) {
  chosen_ = has_device_[role] && !has_device_[1 - role] ? static_cast<Role>(1 - role) : role;
}

void Controls::toggle_jaw() {
  MouseHand& hand = hands_[grasper];
  hand.set_jaw(hand.jaw() > 0.5F ? 0 : 1);
}

void Controls::press_on_screen(const pbdsurg::Pedals& pedals) {
  if (pedals != screen_) {
    screen_ = pedals;
    send_pedals();
  }
}

pbdsurg::Pedals Controls::pedals() const {
  return {keys_.cut || screen_.cut, keys_.coagulation || screen_.coagulation};
}

void Controls::toggle_handedness() {
  if (has_device_[grasper] || has_device_[hook]) {
    return;
  }
  is_left_handed_ = !is_left_handed_;
  hands_[grasper].exchange_places(hands_[hook]);
  restart();
}

void Controls::toggle_slow_motion() {
  orders_.speed = orders_.speed < 1 ? 1 : kSlowMotion;
}

void Controls::toggle_following() {
  wants_following = !is_following();
  assistant_.switch_on(*wants_following);
  if (*wants_following) {
    level_scope();
  }
}

void Controls::restart() {
  reset();
  ++orders_.restarts;
}

void Controls::reset() {
  let_go();
  for (MouseHand& each : hands_) {
    each.reset();
  }
}

void Controls::key(const KeyInput& input) {
  // held keys
  if (input.key == Key::c) {
    keys_.cut = input.is_down;
    send_pedals();
  } else if (input.key == Key::v) {
    keys_.coagulation = input.is_down;
    send_pedals();
  }
  if (!input.is_down) {
    return;
  }
  switch (input.key) {
    case Key::tab:
      choose(chosen_ == grasper ? hook : grasper);
      break;
    case Key::g:
    case Key::space:
      toggle_jaw();
      break;
    case Key::q:
      roll(1);
      break;
    case Key::e:
      roll(-1);
      break;
    case Key::a:
      turn_post(1);
      break;
    case Key::d:
      turn_post(-1);
      break;
    case Key::left_bracket:
      turn_head(1);
      break;
    case Key::right_bracket:
      turn_head(-1);
      break;
    case Key::l:
      level_scope();
      break;
    case Key::f:
      toggle_following();
      break;
    case Key::w:
      wheel(1);
      break;
    case Key::s:
      wheel(-1);
      break;
    case Key::z:
    case Key::u:
      ++orders_.undos;
      break;
    case Key::p:
      orders_.is_paused = !orders_.is_paused;
      break;
    case Key::period:
      orders_.is_paused = true;
      ++orders_.single_steps;
      break;
    case Key::comma:
      toggle_slow_motion();
      break;
    case Key::r:
      if (input.has_shift) {
        restart();
      }
      break;
    case Key::x:
      toggle_handedness();
      break;
    case Key::h:
    case Key::f1:
      shows_help = !shows_help;
      break;
    case Key::f9:
      wishes.new_window = true;
      break;
    case Key::f11:
      wishes.fullscreen = true;
      break;
    case Key::f12:
      wishes.screenshot = true;
      break;
    case Key::escape:
      (shows_help ? shows_help : wishes.quit) = !shows_help;
      break;
    default:
      break;
  }
}

void Controls::cursor(const CursorInput& input, int height) {
  const float x = input.x - at_.x, y = input.y - at_.y;
  at_ = input;
  if (height <= 0) {
    return;
  }
  if (moves_scope_) {
    turn_scope(x / static_cast<float>(height), y / static_cast<float>(height));
  } else if (moves_tip_) {
    const Camera camera = scope_.camera();
    const Eigen::Vector3f ahead = (camera.target - camera.eye).normalized();
    const Eigen::Vector3f side = ahead.cross(camera.up).normalized();
    const float depth = std::max((hand().tip() - camera.eye).dot(ahead), 1e-3F);
    const float metres =
        2 * depth * std::tan(camera.vertical_field_of_view / 2) / static_cast<float>(height);
    hand().move(motion_scale * metres * (x * side - y * side.cross(ahead)));
  }
}

void Controls::wheel(float notches) {
  moves_scope_ || !moves_hand() ? slide_scope(notches) : push(notches);
}

void Controls::push(float notches) {
  const Camera camera = scope_.camera();
  hand().move(motion_scale * kNotch * notches * (camera.target - camera.eye).normalized());
}

void Controls::roll(float steps) {
  hand().roll(kRollStep * steps);
}

Scope& Controls::scope_by_hand() {
  assistant_.switch_on(false);
  return scope_;
}

void Controls::slide_scope(float notches) {
  scope_by_hand().advance(kSlide * notches);
}

void Controls::turn_scope(float right, float down) {
  scope_by_hand().orbit(kOrbitPerHeight * right, kOrbitPerHeight * down);
}

void Controls::turn_post(float steps) {
  scope_by_hand().turn_post(kPostStep * steps);
}

void Controls::turn_head(float steps) {
  scope_by_hand().turn_head(kPostStep * steps);
}

void Controls::level_scope() {
  scope_.set_level(true);
}

void Controls::let_go() {
  moves_tip_ = moves_scope_ = false;
  keys_ = screen_ = {};
  send_pedals();
  ++orders_.let_gos;
}

void Controls::send_pedals() {
  hands_[hook].set_pedals(pedals());
}

}  // namespace cholecystectomy
