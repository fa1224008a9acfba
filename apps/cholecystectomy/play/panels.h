// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What lies over the picture: panels, hints, help, warnings.

#include <array>
#include <deque>
#include <string>
#include <vector>

#include "apps/cholecystectomy/play/controls.h"
#include "apps/cholecystectomy/play/guide.h"
#include "apps/cholecystectomy/play/scene_state.h"
#include "apps/cholecystectomy/play/settings.h"
#include "apps/cholecystectomy/play/texts.h"
#include "apps/viewer/window.h"

namespace cholecystectomy {

/// How pictures fare.
struct PictureTimes {
  double per_second = 0;
  double milliseconds = 0;  ///< of one, drawing alone
};

/// Made anew with each window, whose context it uses.
class Panels {
 public:
  /// @param window          kept by reference
  /// @param has_understood  the disclaimer: kept by reference, for it outlives windows
  Panels(Window& window, const Texts& texts, bool& has_understood);
  ~Panels();
  Panels(const Panels&) = delete;
  Panels& operator=(const Panels&) = delete;

  /// What the panels leave to the operation: cursor and keys that are not theirs.
  /// Enter understands the disclaimer.
  [[nodiscard]] std::vector<Input> unclaimed(const std::vector<Input>& inputs);

  /// Adds a line of warning for some seconds. @param now  s of the clock
  void warn(const std::string& text, double now);

  /// Draws all over the framebuffer that is bound.
  void draw(const SceneState& state, Controls& controls, Orders& orders, Guide& guide,
            Settings& settings, const PictureTimes& pictures, double now);

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
  struct Warned {
    std::string text;
    double until;
  };

  void draw_disclaimer();
  void draw_guide(Guide& guide);
  void draw_help(Controls& controls);
  void draw_operation(const SceneState& state, Controls& controls, Orders& orders);
  [[nodiscard]] pbdsurg::Pedals draw_generator(const SceneState& state, Orders& orders);
  void draw_forces(const SceneState& state);
  [[nodiscard]] std::string time_text(const SceneState& state, const Orders& orders) const;
  void draw_time(const SceneState& state, const PictureTimes& pictures);
  void draw_settings(Settings& settings);
  void draw_warnings(double now);
  void end_panel();
  [[nodiscard]] bool is_covered() const;
  void apply_scale(float scale);

  Window& window_;
  const Texts& texts_;
  bool& has_understood_;
  float scale_ = 0;
  Plot grasper_, hook_;
  double plotted_ = 0;  // s of the scene
  std::deque<Warned> warnings_;
  struct Rectangle {
    float left, top, right, bottom;
  };
  std::vector<Rectangle> covered_;  // pixels, by panels of the last picture
  CursorInput cursor_{-1, -1};
};

}  // namespace cholecystectomy
