// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a person does to a window, as plain data.

#include <cstdint>
#include <variant>

namespace cholecystectomy {

/// Keys by what is printed on them in an American layout; others are told as `other`.
enum class Key : std::uint8_t {
  other,
  space,
  tab,
  escape,
  enter,
  left_bracket,
  right_bracket,
  comma,
  period,
  a,
  b,
  c,
  d,
  e,
  f,
  g,
  h,
  i,
  j,
  k,
  l,
  m,
  n,
  o,
  p,
  q,
  r,
  s,
  t,
  u,
  v,
  w,
  x,
  y,
  z,
  f1,
  f2,
  f3,
  f4,
  f5,
  f6,
  f7,
  f8,
  f9,
  f10,
  f11,
  f12,
  left,
  right,
  up,
  down,
};

enum class MouseButton : std::uint8_t { left, right, middle };

struct KeyInput {
  Key key;
  bool is_down;
  bool has_shift = false;
};
struct ButtonInput {
  MouseButton button;
  bool is_down;
};
struct CursorInput {
  float x, y;  ///< pixels from the top left
};
struct WheelInput {
  float notches;  ///< away from the hand is positive
};
/// The window gained or lost the keyboard: after a loss, nobody hears keys that are let go.
struct FocusInput {
  bool has_focus;
};

using Input = std::variant<KeyInput, ButtonInput, CursorInput, WheelInput, FocusInput>;

}  // namespace cholecystectomy
