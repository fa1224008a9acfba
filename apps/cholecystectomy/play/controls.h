// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What mouse and keyboard mean.

#include <array>
#include <optional>
#include <vector>

#include "apps/cholecystectomy/camera_assistant.h"
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
/// scope about its port, the wheel with that button held slides it. Who moves the scope wants it
/// there: that switches its assistant off.
class Controls {
 public:
  enum Role : std::uint8_t { grasper, hook };

  /// @param hands  [Role]; all are kept by reference
  /// @param is_left_handed  whether the hook is in the left hand
  Controls(std::array<MouseHand, 2>& hands, Scope& scope, CameraAssistant& assistant,
           Orders& orders, bool is_left_handed = false);

  /// @param height  of the picture, pixels
  void handle(const std::vector<Input>& inputs, int height);

  /// Hands that hold devices: the mouse moves the others. Where there are none, its left button and
  /// wheel move the scope, too.
  /// @param has_device  [Role]
  void set_devices(const std::array<bool, 2>& has_device);

  /// Which hand the mouse moves.
  [[nodiscard]] Role chosen() const { return chosen_; }
  void choose(Role role);
  [[nodiscard]] bool moves_hand() const { return !has_device_[chosen_]; }
  /// Where a hand has its tip, m.
  [[nodiscard]] const Eigen::Vector3f& tip(Role role) const { return hands_[role].tip(); }
  [[nodiscard]] bool is_left_handed() const { return is_left_handed_; }
  /// Whether the mouse moves the left hand.
  [[nodiscard]] bool is_left() const { return (chosen_ == hook) == is_left_handed_; }

  void toggle_jaw();
  /// Pedals under a finger on the screen; those of keys count beside them.
  void press_on_screen(const pbdsurg::Pedals& pedals);
  [[nodiscard]] pbdsurg::Pedals pedals() const;
  /// Instruments exchange their ports, and the scene begins anew; devices stay where they are.
  void toggle_handedness();
  void toggle_slow_motion();
  /// Whether the scope follows the tips by itself, in a level picture.
  void toggle_following();
  [[nodiscard]] bool is_following() const { return assistant_.is_on(); }
  void restart();
  /// @name What keys and the wheel do, for buttons
  /// Steps may be negative: the other way.
  /// @{
  void push(float notches);         ///< the chosen instrument, into the picture
  void roll(float steps);           ///< the chosen instrument, to the left
  void slide_scope(float notches);  ///< into the picture
  /// Turns it about its port, so that the picture's content moves by so many of its heights.
  void turn_scope(float right, float down);
  void turn_post(float steps);  ///< to the left
  void turn_head(float steps);  ///< to the left
  void level_scope();
  /// @}
  /// Pedals up, drags over: a window without the keyboard hears no key that is let go.
  void let_go();
  /// Both hands to where they began, without what they held.
  void reset();

  Wishes wishes;
  float motion_scale = 1;  ///< of drags and the wheel
  bool shows_help = false;
  /// As a person last asked for it; a move of the scope asks for this play alone.
  std::optional<bool> wants_following;

 private:
  void key(const KeyInput& input);
  void cursor(const CursorInput& input, int height);
  void wheel(float notches);
  void send_pedals();
  [[nodiscard]] Scope& scope_by_hand();
  [[nodiscard]] MouseHand& hand() { return hands_[chosen_]; }

  std::array<MouseHand, 2>& hands_;
  Scope& scope_;
  CameraAssistant& assistant_;
  Orders& orders_;
  bool is_left_handed_;
  std::array<bool, 2> has_device_{};  // [Role]
  Role chosen_ = grasper;
  bool moves_tip_ = false, moves_scope_ = false;
  CursorInput at_{0, 0};
  pbdsurg::Pedals keys_, screen_;
};

}  // namespace cholecystectomy
