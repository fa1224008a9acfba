// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What lies over the picture: panels, hints, help, warnings. Knows no window and no OpenGL.

#include <array>
#include <cstdint>
#include <deque>
#include <string>
#include <utility>
#include <vector>

#include "apps/cholecystectomy/play/controls.h"
#include "apps/cholecystectomy/play/guide.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/play/settings.h"
#include "apps/cholecystectomy/play/texts.h"
#include "apps/viewer/input.h"

struct ImVec2;
struct ImVec4;

namespace cholecystectomy {

/// How pictures fare.
struct PictureTimes {
  double per_second = 0;
  double milliseconds = 0;  ///< of one, drawing alone
};

/// Has the context of Dear ImGui: one at a time. Who shows them tells that context the size of the
/// display and what mouse and keyboard do, and draws what it then holds.
class Panels {
 public:
  struct Rectangle {
    float left, top, right, bottom;  ///< pixels
  };
  struct Button {
    const char* text;
    Rectangle place;
  };

  /// @param has_understood  the disclaimer: kept by reference, for it outlives windows
  Panels(const Texts& texts, bool& has_understood);
  ~Panels();
  Panels(const Panels&) = delete;
  Panels& operator=(const Panels&) = delete;

  /// What the panels leave to the operation: cursor and keys that are not theirs.
  /// Enter understands the disclaimer.
  [[nodiscard]] std::vector<Input> unclaimed(const std::vector<Input>& inputs);

  /// Adds a line of warning for some seconds. @param now  s of the clock
  void warn(const std::string& text, double now);

  /// How devices in hands are, a line each, under the forces.
  void set_hands(std::vector<std::string> lines) { hands_ = std::move(lines); }

  /// Fits sizes to the display; call this before lay_out().
  /// @param screen_scale  how large the screen wants texts
  /// @param text_scale    how large a person wants them beside that
  /// @return whether there are new fonts, which need a texture
  [[nodiscard]] bool fit(float screen_scale, double text_scale);

  /// A picture of all, for the context to hold.
  void lay_out(const SceneState& state, Controls& controls, Orders& orders, Guide& guide,
               Settings& settings, const PictureTimes& pictures, double now);

  /// Of the last picture, those that a mouse can be over.
  [[nodiscard]] const std::vector<Rectangle>& covered() const { return covered_; }
  /// Of the last picture, those that are scrolled out of their panel included.
  [[nodiscard]] const std::vector<Button>& buttons() const { return buttons_; }

 private:
  static constexpr std::size_t kPlotted = 200;  // values of a plot, 10 s
  struct Plot {
    std::array<float, kPlotted> values{};
    std::size_t next = 0;
    void add(float value) {
      values[next] = value;
      next = (next + 1) % kPlotted;
    }
  };
  enum class Group : std::uint8_t { none, instrument, scope, scene, program };
  struct Warned {
    std::string text;
    double until;
  };

  void draw_disclaimer();
  void draw_guide(Guide& guide);
  void draw_help(Controls& controls);
  void draw_operation(const SceneState& state, Controls& controls, Orders& orders);
  void draw_instrument_buttons(Controls& controls);
  void group_button(const char* text, Group group);
  void draw_scene_buttons(Controls& controls, Orders& orders);
  void draw_scope_buttons(Controls& controls);
  void draw_program_buttons(Controls& controls);
  [[nodiscard]] pbdsurg::Pedals draw_generator(const SceneState& state, Orders& orders);
  void draw_forces(const SceneState& state);
  [[nodiscard]] std::string time_text(const SceneState& state, const Orders& orders) const;
  void draw_time(const SceneState& state, const PictureTimes& pictures);
  void draw_settings(Settings& settings);
  void draw_warnings(double now);
  [[nodiscard]] bool button(const char* text);
  [[nodiscard]] bool switch_button(const char* text, bool is_on);
  [[nodiscard]] bool held_button(const char* text, const ImVec4& color, bool is_on);
  void note_button(const char* text);
  bool begin_panel(const char* name, const ImVec2& corner, int flags = 0, bool* is_open = nullptr);
  void end_panel();
  [[nodiscard]] float room() const;
  [[nodiscard]] ImVec2 button_size() const;
  [[nodiscard]] bool is_covered() const;
  void apply_style();

  const Texts& texts_;
  bool& has_understood_;
  float scale_ = 0, finger_ = 0;  // finger_: units of the display
  bool is_small_ = false, has_new_room_ = false;
  Plot grasper_, hook_;
  double plotted_ = 0;  // s of the scene
  std::deque<Warned> warnings_;
  std::vector<std::string> hands_;
  std::vector<Rectangle> covered_;  // by panels of the last picture
  std::vector<Button> buttons_;
  Group group_ = Group::none;  // of buttons that show
  CursorInput cursor_{-1, -1};
};

}  // namespace cholecystectomy
