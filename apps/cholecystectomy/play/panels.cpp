// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/panels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <imgui.h>

namespace cholecystectomy {
namespace {

constexpr double kPlotEvery = 0.05;  // s
constexpr double kWarned = 6;        // s for which a warning stays
constexpr float kTextSize = 17;      // pixels at scale 1: read from a standing place
// pixels that panels of scale 1 leave to the picture; in smaller windows they are smaller, to a
// limit
constexpr float kRoomyWidth = 1100, kRoomyHeight = 650, kSmallest = 0.65F;
constexpr float kLargest = 1.5F;   // of what fits, so that panels do not cover each other
constexpr float kNarrowest = 360;  // units of a window with panels
constexpr float kSmallWidth = 16, kSmallHeight = 12;  // fingers; smaller windows fold panels
constexpr float kFinger = 36;       // units: 9.5 mm at 96 an inch, what a fingertip hits
constexpr float kTurnStep = 0.04F;  // of the picture's height, of a scope that is turned by buttons

const ImVec2 kMiddle(0.5F, 0.5F);  // of the display
const ImVec4 kYellow(0.95F, 0.80F, 0.20F, 1), kBlue(0.35F, 0.60F, 1.0F, 1), kRed(1, 0.4F, 0.3F, 1);

constexpr ImGuiWindowFlags kStill = ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove |
                                    ImGuiWindowFlags_NoSavedSettings |
                                    ImGuiWindowFlags_AlwaysAutoResize;
constexpr ImGuiWindowFlags kBare = kStill | ImGuiWindowFlags_NoDecoration |
                                   ImGuiWindowFlags_NoFocusOnAppearing | ImGuiWindowFlags_NoNav |
                                   ImGuiWindowFlags_NoInputs;

std::string resistance_text(const Texts& texts, double resistance) {
  if (!std::isfinite(resistance)) {
    return texts.open_circuit;
  }
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), texts.resistance, resistance);
  return text.data();
}

bool slider(const char* name, double& value, float least, float most, const char* format) {
  float number = static_cast<float>(value);
  ImGui::SetNextItemWidth(ImGui::GetFontSize() * 7);
  if (ImGui::SliderFloat(name, &number, least, most, format)) {
    value = std::clamp(number, least, most);
    return true;
  }
  return false;
}

}  // namespace

Panels::Panels(const Texts& texts, bool& has_understood)
    : texts_(texts), has_understood_(has_understood) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGui::GetIO().IniFilename = nullptr;  // settings are the program's
}

Panels::~Panels() {
  ImGui::DestroyContext();
}

std::vector<Input> Panels::unclaimed(const std::vector<Input>& inputs) {
  std::vector<Input> rest;
  for (const Input& input : inputs) {
    if (const auto* moved = std::get_if<CursorInput>(&input)) {
      cursor_ = *moved;
    }
    const auto* button = std::get_if<ButtonInput>(&input);
    const auto* key = std::get_if<KeyInput>(&input);
    has_understood_ = has_understood_ || (key != nullptr && key->key == Key::enter);
    // what was pressed outside is let go outside, wherever the cursor is by then
    const bool is_press = button != nullptr && button->is_down;
    const bool is_claimed =
        ((is_press || std::holds_alternative<WheelInput>(input)) && is_covered()) ||
        (ImGui::GetIO().WantTextInput && key != nullptr && key->is_down);
    if (!is_claimed) {
      rest.push_back(input);
    }
  }
  return rest;
}

// By what was drawn, not by where ImGui saw the cursor a picture ago.
bool Panels::is_covered() const {
  return std::ranges::any_of(covered_, [&](const Rectangle& r) {
    return cursor_.x >= r.left && cursor_.x < r.right && cursor_.y >= r.top && cursor_.y < r.bottom;
  });
}

// In the middle or a corner of the display. One in a corner leaves the other half to its neighbour,
// and room for a title to that above or below; what does not fit is scrolled.
bool Panels::begin_panel(const char* name, const ImVec2& corner, int flags, bool* is_open) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float edge = ImGui::GetFontSize() / 2;
  ImGui::SetNextWindowPos(
      ImVec2(edge + corner.x * (size.x - 2 * edge), edge + corner.y * (size.y - 2 * edge)), 0,
      corner);
  const bool is_middle = corner.x == 0.5F;
  const bool is_time = corner.x == 0 && corner.y == 1;  // whose title says enough
  const ImVec2 most = is_middle ? ImVec2(size.x - 2 * edge, size.y - 2 * edge)
                                : ImVec2(size.x / 2 - 1.5F * edge, size.y - finger_ - 3 * edge);
  ImGui::SetNextWindowSizeConstraints(ImVec2(0, 0), most);
  if (has_new_room_ && !is_middle) {
    ImGui::SetNextWindowCollapsed(is_small_ || is_time);
  }
  return ImGui::Begin(name, is_open, kStill | flags);
}

void Panels::end_panel() {
  const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  const ImVec2 pixels = ImGui::GetIO().DisplayFramebufferScale;
  covered_.push_back({pixels.x * corner.x, pixels.y * corner.y, pixels.x * (corner.x + size.x),
                      pixels.y * (corner.y + size.y)});
  ImGui::End();
}

// Units that a panel in a corner has for what is in it, at most.
float Panels::room() const {
  const ImGuiStyle& style = ImGui::GetStyle();
  return ImGui::GetIO().DisplaySize.x / 2 - 0.75F * ImGui::GetFontSize() -
         2 * style.WindowPadding.x - (is_small_ ? style.ScrollbarSize : 0);
}

// Two beside each other.
ImVec2 Panels::button_size() const {
  const float most = (room() - ImGui::GetStyle().ItemSpacing.x) / 2;
  return ImVec2(std::min(9.8F * ImGui::GetFontSize(), std::max(finger_, most)), finger_);
}

bool Panels::button(const char* text) {
  const bool is_pressed = ImGui::Button(text, button_size());
  note_button(text);
  return is_pressed;
}

// Counts for as long as it is held, as a pedal does.
bool Panels::held_button(const char* text, const ImVec4& color, bool is_on) {
  const auto shade = [&](float share) {
    return ImVec4(share * color.x, share * color.y, share * color.z, 1);
  };
  ImGui::PushStyleColor(ImGuiCol_Button, is_on ? color : shade(0.3F));
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered, shade(0.5F));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, color);
  const ImVec2 size = button_size();
  ImGui::Button(text, ImVec2(std::min(7 * ImGui::GetFontSize(), size.x), 1.2F * size.y));
  note_button(text);
  const bool is_held = ImGui::IsItemActive();
  ImGui::PopStyleColor(3);
  return is_held;
}

void Panels::note_button(const char* text) {
  const ImVec2 first = ImGui::GetItemRectMin(), last = ImGui::GetItemRectMax();
  const ImVec2 pixels = ImGui::GetIO().DisplayFramebufferScale;
  buttons_.push_back(
      {text, {pixels.x * first.x, pixels.y * first.y, pixels.x * last.x, pixels.y * last.y}});
}

void Panels::warn(const std::string& text, double now) {
  if (!warnings_.empty() && warnings_.back().text == text) {
    warnings_.back().until = now + kWarned;
    return;
  }
  warnings_.push_back({text, now + kWarned});
  if (warnings_.size() > 4) {
    warnings_.pop_front();
  }
}

bool Panels::fit(float screen_scale, double text_scale) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  const float room = std::min(size.x / kRoomyWidth, size.y / kRoomyHeight);
  const float screen = std::max(screen_scale, 1.0F);
  const float scale = std::min(std::clamp(room, kSmallest, screen) * static_cast<float>(text_scale),
                               std::max(kLargest * room, kSmallest));
  const float finger = std::max(kFinger * screen, 1.6F * kTextSize * scale);
  const bool is_small = size.x < kSmallWidth * finger || size.y < kSmallHeight * finger;
  has_new_room_ = is_small != is_small_ || scale_ == 0;
  is_small_ = is_small;
  if (scale == scale_ && finger == finger_) {
    return false;
  }
  const bool has_new_fonts = scale != scale_;
  scale_ = scale;
  finger_ = finger;
  apply_style();
  return has_new_fonts;
}

void Panels::apply_style() {
  const float text = std::round(kTextSize * scale_);
  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  ImGui::StyleColorsDark();
  style.ScaleAllSizes(scale_);
  style.WindowRounding = 6 * scale_;
  style.FrameRounding = 4 * scale_;
  style.FramePadding.y = std::ceil((finger_ - text) / 2);  // titles and sliders, too
  style.GrabMinSize = style.ScrollbarSize = finger_ * 2 / 3;
  style.Colors[ImGuiCol_WindowBg].w = 0.75F;
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  ImFontConfig font;
  font.SizePixels = text;
  io.Fonts->AddFontDefault(&font);
}

void Panels::lay_out(const SceneState& state, Controls& controls, Orders& orders, Guide& guide,
                     Settings& settings, const PictureTimes& pictures, double now) {
  covered_.clear();
  buttons_.clear();
  ImGui::NewFrame();
  if (state.phase == Phase::playing && state.time >= plotted_ + kPlotEvery) {
    plotted_ = state.time;
    grasper_.add(state.grasper.force.norm());
    hook_.add(state.hook.force.norm());
  } else if (state.time < plotted_) {
    plotted_ = state.time;  // it began anew
  }
  if (!has_understood_) {
    draw_disclaimer();
  } else if (state.phase == Phase::playing) {
    if (controls.moves_hand()) {  // it teaches the mouse
      draw_guide(guide);
    }
  }
  pbdsurg::Pedals pressed;
  if (ImGui::GetIO().DisplaySize.x >= kNarrowest) {  // else the picture alone
    draw_operation(state, controls, orders);
    pressed = draw_generator(state, orders);
    draw_forces(state);
    if (begin_panel((time_text(state, orders) + "###time").c_str(), ImVec2(0, 1))) {
      draw_time(state, pictures);
      draw_settings(settings);
    }
    end_panel();
  }
  controls.press_on_screen(pressed);  // none where there is no button
  draw_warnings(now);
  if (controls.shows_help) {
    draw_help(controls);
  }
  ImGui::Render();
}

void Panels::draw_disclaimer() {
  if (begin_panel(texts_.title, kMiddle, ImGuiWindowFlags_NoCollapse)) {
    const float width = ImGui::GetIO().DisplaySize.x;
    ImGui::PushTextWrapPos(std::min(ImGui::GetFontSize() * 28, 0.9F * width));
    ImGui::TextUnformatted(texts_.disclaimer);
    ImGui::PopTextWrapPos();
    has_understood_ = button(texts_.understood) || has_understood_;
  }
  end_panel();
}

void Panels::draw_guide(Guide& guide) {
  if (guide.hint() > Guide::kHints) {
    return;
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  // above the line of time
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y - finger_ - ImGui::GetFontSize()), 0,
                          ImVec2(0.5F, 1));
  if (ImGui::Begin("guide", nullptr, kBare)) {
    ImGui::PushTextWrapPos(std::min(ImGui::GetFontSize() * 24, 0.9F * size.x));
    ImGui::TextUnformatted(guide.hint() < Guide::kHints ? texts_.guide[guide.hint()]
                                                        : texts_.guide_done);
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

void Panels::draw_help(Controls& controls) {
  if (begin_panel(texts_.help, kMiddle, ImGuiWindowFlags_NoCollapse, &controls.shows_help)) {
    ImGui::PushTextWrapPos(ImGui::GetIO().DisplaySize.x - finger_);
    if (ImGui::BeginTable("keys", 2, ImGuiTableFlags_SizingFixedFit)) {
      for (const KeyText& key : texts_.keys) {
        ImGui::TableNextColumn();
        ImGui::TextColored(kYellow, "%s", key.keys);
        ImGui::TableNextColumn();
        ImGui::TextUnformatted(key.what);
      }
      ImGui::EndTable();
    }
    ImGui::Separator();
    ImGui::TextUnformatted(texts_.disclaimer);
    ImGui::PopTextWrapPos();
    if (button(texts_.close)) {
      controls.shows_help = false;
    }
  }
  end_panel();
}

void Panels::draw_operation(const SceneState& state, Controls& controls, Orders& orders) {
  if (begin_panel(texts_.operation, ImVec2(0, 0))) {
    ImGui::PushTextWrapPos(std::min(24 * ImGui::GetFontSize(), room()));
    if (state.phase == Phase::loading) {
      ImGui::TextUnformatted(texts_.loading);
    } else if (state.phase == Phase::failed) {
      ImGui::TextColored(kRed, texts_.failed, state.message.c_str());
    }
    if (controls.moves_hand()) {
      ImGui::Text("%s: %s", controls.is_left() ? texts_.chosen_left : texts_.chosen_right,
                  controls.chosen() == Controls::grasper ? texts_.grasper : texts_.hook);
      if (button(texts_.choose_other)) {
        controls.choose(controls.chosen() == Controls::grasper ? Controls::hook
                                                               : Controls::grasper);
      }
      ImGui::SameLine();
      if (button(state.grasper.is_closed ? texts_.open_jaw : texts_.close_jaw)) {
        controls.toggle_jaw();
      }
    } else {
      ImGui::TextUnformatted(texts_.devices_hold);
    }
    if (button(texts_.undo)) {
      ++orders.undos;
    }
    ImGui::SameLine();
    if (button(orders.is_paused ? texts_.go_on : texts_.pause)) {
      orders.is_paused = !orders.is_paused;
    }
    const Group shown = group_;
    if (controls.moves_hand()) {
      group_button(texts_.instrument, Group::instrument);
      ImGui::SameLine();
    }
    group_button(texts_.scope, Group::scope);
    group_button(texts_.scene, Group::scene);
    ImGui::SameLine();
    group_button(texts_.program, Group::program);
    switch (shown) {
      case Group::none:
        break;
      case Group::instrument:
        draw_instrument_buttons(controls);
        break;
      case Group::scope:
        draw_scope_buttons(controls);
        break;
      case Group::scene:
        draw_scene_buttons(controls, orders);
        break;
      case Group::program:
        draw_program_buttons(controls);
        break;
    }
    ImGui::PopTextWrapPos();
  }
  end_panel();
}

// Bright while it is on.
bool Panels::switch_button(const char* text, bool is_on) {
  ImGui::PushStyleColor(ImGuiCol_Button,
                        ImGui::GetStyle().Colors[is_on ? ImGuiCol_ButtonActive : ImGuiCol_FrameBg]);
  const bool is_pressed = button(text);
  ImGui::PopStyleColor();
  return is_pressed;
}

// Shows a group of buttons in place of another, or hides it: the picture needs the room.
void Panels::group_button(const char* text, Group group) {
  if (switch_button(text, group == group_)) {
    group_ = group == group_ ? Group::none : group;
  }
}

void Panels::draw_instrument_buttons(Controls& controls) {
  ImGui::PushButtonRepeat(true);
  if (button(texts_.deeper)) {
    controls.push(0.5F);
  }
  ImGui::SameLine();
  if (button(texts_.nearer)) {
    controls.push(-0.5F);
  }
  if (button(texts_.roll_left)) {
    controls.roll(1);
  }
  ImGui::SameLine();
  if (button(texts_.roll_right)) {
    controls.roll(-1);
  }
  ImGui::PopButtonRepeat();
}

void Panels::draw_scene_buttons(Controls& controls, Orders& orders) {
  if (button(texts_.slow_motion)) {
    controls.toggle_slow_motion();
  }
  ImGui::SameLine();
  if (button(texts_.single_step)) {
    orders.is_paused = true;
    ++orders.single_steps;
  }
  if (button(texts_.restart)) {
    controls.restart();
  }
  ImGui::SameLine();
  if (button(texts_.swap_hands)) {
    controls.toggle_handedness();
  }
}

void Panels::draw_scope_buttons(Controls& controls) {
  ImGui::PushButtonRepeat(true);
  if (button(texts_.scope_in)) {
    controls.slide_scope(0.5F);
  }
  ImGui::SameLine();
  if (button(texts_.scope_out)) {
    controls.slide_scope(-0.5F);
  }
  if (button(texts_.look_left)) {
    controls.turn_scope(kTurnStep, 0);
  }
  ImGui::SameLine();
  if (button(texts_.look_right)) {
    controls.turn_scope(-kTurnStep, 0);
  }
  if (button(texts_.look_up)) {
    controls.turn_scope(0, kTurnStep);
  }
  ImGui::SameLine();
  if (button(texts_.look_down)) {
    controls.turn_scope(0, -kTurnStep);
  }
  if (button(texts_.post_left)) {
    controls.turn_post(1);
  }
  ImGui::SameLine();
  if (button(texts_.post_right)) {
    controls.turn_post(-1);
  }
  if (button(texts_.head_left)) {
    controls.turn_head(1);
  }
  ImGui::SameLine();
  if (button(texts_.head_right)) {
    controls.turn_head(-1);
  }
  ImGui::PopButtonRepeat();
  if (button(texts_.level)) {
    controls.level_scope();
  }
  ImGui::SameLine();
  if (switch_button(texts_.follow_tips, controls.is_following())) {
    controls.toggle_following();
  }
}

void Panels::draw_program_buttons(Controls& controls) {
  if (button(texts_.full_screen)) {
    controls.wishes.fullscreen = true;
  }
  ImGui::SameLine();
  if (button(texts_.screenshot)) {
    controls.wishes.screenshot = true;
  }
  if (button(texts_.help)) {
    controls.shows_help = !controls.shows_help;
  }
}

pbdsurg::Pedals Panels::draw_generator(const SceneState& state, Orders& orders) {
  pbdsurg::Pedals pressed;
  if (begin_panel(texts_.generator, ImVec2(1, 0))) {
    const GeneratorState& generator = state.generator;
    pressed.cut =
        held_button(texts_.cut, kYellow, generator.activation == pbdsurg::Activation::cut);
    ImGui::SameLine();
    pressed.coagulation = held_button(texts_.coagulation, kBlue,
                                      generator.activation == pbdsurg::Activation::coagulation);
    slider(texts_.cut_power, orders.cut_power, 1, 120, "%.0f");
    slider(texts_.coagulation_power, orders.coagulation_power, 1, 120, "%.0f");
    ImGui::Text(texts_.delivered, generator.power, generator.voltage,
                resistance_text(texts_, generator.resistance).c_str());
    ImGui::Text(texts_.hottest, generator.hottest, generator.energy);
    if (generator.is_refused) {
      ImGui::TextColored(kRed, "%s", texts_.both_pedals);
    } else if (generator.is_arcing) {
      ImGui::TextColored(kBlue, "%s", texts_.sparks);
    }
  }
  end_panel();
  return pressed;
}

void Panels::draw_forces(const SceneState& state) {
  if (begin_panel(texts_.forces, ImVec2(1, 1))) {
    const ImVec2 size(std::min(ImGui::GetFontSize() * 15, room()), ImGui::GetFontSize() * 3);
    const auto plot = [&](const char* format, const Plot& values, const InstrumentState& now) {
      std::array<char, 64> text{};
      std::snprintf(text.data(), text.size(), format, static_cast<double>(now.force.norm()),
                    1e3 * static_cast<double>(now.distance));
      const float most = *std::ranges::max_element(values.values);
      ImGui::PushID(format);
      ImGui::PlotLines("", values.values.data(), static_cast<int>(kPlotted),
                       static_cast<int>(values.next), text.data(), 0, std::max(2.0F, 1.2F * most),
                       size);
      ImGui::PopID();
    };
    plot(texts_.force_on_grasper, grasper_, state.grasper);
    plot(texts_.force_on_hook, hook_, state.hook);
    ImGui::PushTextWrapPos(size.x);
    for (const std::string& line : hands_) {
      ImGui::TextUnformatted(line.c_str());
    }
    ImGui::PopTextWrapPos();
  }
  end_panel();
}

std::string Panels::time_text(const SceneState& state, const Orders& orders) const {
  constexpr double kInTime = 0.98;
  std::array<char, 96> text{};
  if (orders.is_paused) {
    std::snprintf(text.data(), text.size(), texts_.paused, state.time);
  } else if (state.factor >= kInTime) {
    std::snprintf(text.data(), text.size(), texts_.in_time, state.time);
  } else {
    std::snprintf(text.data(), text.size(), texts_.stretched, state.time,
                  1 / std::max(state.factor, 0.01));
  }
  return text.data();
}

void Panels::draw_time(const SceneState& state, const PictureTimes& pictures) {
  ImGui::PushTextWrapPos(std::min(24 * ImGui::GetFontSize(), room()));
  ImGui::Text(texts_.pictures, pictures.per_second, pictures.milliseconds);
  ImGui::Text(texts_.step_times, state.times.heat, state.times.edit, state.times.solve,
              state.times.readback);
  ImGui::Text(texts_.publish_time, state.times.publish);
  ImGui::Text(texts_.removed, static_cast<long long>(state.removed_tets),
              static_cast<long long>(state.parted_strands));
  ImGui::PopTextWrapPos();
}

void Panels::draw_settings(Settings& settings) {
  if (ImGui::CollapsingHeader(texts_.settings)) {
    slider(texts_.volume, settings.volume, 0, 1, "%.2f");
    slider(texts_.size, settings.text_scale, 0.7F, 3, "%.1f");
    slider(texts_.motion, settings.motion_scale, 0.2F, 3, "%.1f");
    int quality = static_cast<int>(settings.quality);
    ImGui::SetNextItemWidth(ImGui::GetFontSize() * 7);
    if (ImGui::Combo(texts_.quality, &quality, texts_.qualities.data(),
                     static_cast<int>(texts_.qualities.size()))) {
      settings.quality = static_cast<PictureQuality>(quality);
    }
    bool is_low = settings.detail == Detail::low;
    if (ImGui::Checkbox(texts_.low_detail, &is_low)) {
      settings.detail = is_low ? Detail::low : Detail::full;
    }
  }
}

void Panels::draw_warnings(double now) {
  while (!warnings_.empty() && warnings_.front().until < now) {
    warnings_.pop_front();
  }
  if (warnings_.empty()) {
    return;
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, 0.05F * size.y), 0, ImVec2(0.5F, 0));
  if (ImGui::Begin("warnings", nullptr, kBare)) {
    ImGui::PushTextWrapPos(0.9F * size.x);
    for (const Warned& warning : warnings_) {
      ImGui::TextColored(kYellow, "%s", warning.text.c_str());
    }
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

}  // namespace cholecystectomy
