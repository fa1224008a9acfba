// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What mouse and keyboard mean.

#include <array>
#include <vector>

#include "apps/cholecystectomy/play/hand.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/scope.h"
#include "apps/viewer/input.h"

namespace cholecystectomy {

/// What a person wants of the program rather than of the operation. Each is done once and cleared.
struct Wishes {
  bool screenshot = false;
  bool fullscreen = false;
  bool new_window = false;  ///< the window and its pictures made anew
  bool quit = false;
};

/// Turns inputs into moves of hands and scope, pedals, orders and wishes. Knows no window.
///
/// A drag with the left button moves the tip of the chosen hand in the plane of the picture, as far
/// as the cursor goes; the wheel moves it along the view. A drag with the right button turns the
/// scope about its port, the wheel with that button held slides it.
class Controls {
 public:
  enum Side : std::uint8_t { left, right };

  /// All are kept by reference.
  Controls(std::array<MouseHand, 2>& hands, Scope& scope, Orders& orders);

  /// @param height  of the picture, pixels
  void handle(const std::vector<Input>& inputs, int height);

  /// Which hand the mouse moves.
  [[nodiscard]] Side chosen() const { return chosen_; }
  void choose(Side side);
  [[nodiscard]] bool has_grasper() const { return (chosen_ == left) != orders_.is_left_handed; }

  void toggle_jaw();
  /// Pedals under a finger on the screen; those of keys count beside them.
  void press_on_screen(const pbdsurg::Pedals& pedals);
  [[nodiscard]] pbdsurg::Pedals pedals() const;
  void toggle_handedness();
  void restart();

  Wishes wishes;
  float motion_scale = 1;  ///< of drags and the wheel
  bool shows_help = false;
  bool is_slow = false;

 private:
  void key(const KeyInput& input);
  void cursor(const CursorInput& input, int height);
  void wheel(float notches);
  void let_go();
  void send_pedals();
  [[nodiscard]] MouseHand& hand() { return hands_[chosen_]; }
  [[nodiscard]] MouseHand& grasper_hand() { return hands_[orders_.is_left_handed ? right : left]; }
  [[nodiscard]] MouseHand& hook_hand() { return hands_[orders_.is_left_handed ? left : right]; }

  std::array<MouseHand, 2>& hands_;
  Scope& scope_;
  Orders& orders_;
  Side chosen_ = left;
  bool moves_tip_ = false, moves_scope_ = false;
  CursorInput at_{0, 0};
  pbdsurg::Pedals keys_, screen_;
};

}  // namespace cholecystectomy
