// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/panels.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include <backends/imgui_impl_glfw.h>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>

namespace cholecystectomy {
namespace {

constexpr double kPlotEvery = 0.05;  // s
constexpr double kWarned = 6;        // s for which a warning stays
constexpr float kTextSize = 17;      // pixels at scale 1: read from a standing place
// pixels that panels of scale 1 leave to the picture; in smaller windows they are smaller, to a
// limit
constexpr float kRoomyWidth = 1100, kRoomyHeight = 650, kSmallest = 0.65F;
constexpr float kLargest = 1.5F;  // of what fits, so that panels do not cover each other
constexpr int kNarrowest = 360;   // pixels of a window with panels

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

// A button that counts for as long as it is held, as a pedal does.
bool held_button(const char* name, const ImVec4& color, bool is_on) {
  ImGui::PushStyleColor(ImGuiCol_Button,
                        is_on ? color : ImVec4(0.3F * color.x, 0.3F * color.y, 0.3F * color.z, 1));
  ImGui::PushStyleColor(ImGuiCol_ButtonHovered,
                        ImVec4(0.5F * color.x, 0.5F * color.y, 0.5F * color.z, 1));
  ImGui::PushStyleColor(ImGuiCol_ButtonActive, color);
  ImGui::Button(name, ImVec2(ImGui::GetFontSize() * 7, ImGui::GetFontSize() * 2));
  const bool is_held = ImGui::IsItemActive();
  ImGui::PopStyleColor(3);
  return is_held;
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

Panels::Panels(Window& window, const Texts& texts, bool& has_understood)
    : window_(window), texts_(texts), has_understood_(has_understood) {
  IMGUI_CHECKVERSION();
  ImGui::CreateContext();
  ImGuiIO& io = ImGui::GetIO();
  io.IniFilename = nullptr;  // settings are the program's
  ImGui_ImplGlfw_InitForOpenGL(window.handle(), true);
  ImGui_ImplOpenGL3_Init("#version 330 core");
}

Panels::~Panels() {
  ImGui_ImplOpenGL3_Shutdown();
  ImGui_ImplGlfw_Shutdown();
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

void Panels::end_panel() {
  const ImVec2 corner = ImGui::GetWindowPos(), size = ImGui::GetWindowSize();
  const ImVec2 pixels = ImGui::GetIO().DisplayFramebufferScale;
  covered_.push_back({pixels.x * corner.x, pixels.y * corner.y, pixels.x * (corner.x + size.x),
                      pixels.y * (corner.y + size.y)});
  ImGui::End();
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

void Panels::apply_scale(float scale) {
  if (scale == scale_) {
    return;
  }
  scale_ = scale;
  ImGui::GetStyle() = ImGuiStyle();
  ImGui::StyleColorsDark();
  ImGui::GetStyle().ScaleAllSizes(scale);
  ImGui::GetStyle().WindowRounding = 6 * scale;
  ImGui::GetStyle().FrameRounding = 4 * scale;
  ImGui::GetStyle().Colors[ImGuiCol_WindowBg].w = 0.75F;
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  ImFontConfig font;
  font.SizePixels = std::round(kTextSize * scale);
  io.Fonts->AddFontDefault(&font);
  ImGui_ImplOpenGL3_DestroyFontsTexture();
  ImGui_ImplOpenGL3_CreateFontsTexture();
}

void Panels::draw(const SceneState& state, Controls& controls, Orders& orders, Guide& guide,
                  Settings& settings, const PictureTimes& pictures, double now) {
  const std::array<int, 2> size = window_.windowed_size();
  const float room = std::min(static_cast<float>(size[0]) / kRoomyWidth,
                              static_cast<float>(size[1]) / kRoomyHeight);
  const float fitting = std::clamp(room, kSmallest, std::max(window_.scale(), 1.0F));
  apply_scale(std::min(fitting * static_cast<float>(settings.text_scale),
                       std::max(kLargest * room, kSmallest)));
  covered_.clear();
  ImGui_ImplOpenGL3_NewFrame();
  ImGui_ImplGlfw_NewFrame();
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
    draw_guide(guide);
  }
  const float edge = ImGui::GetFontSize() / 2;
  pbdsurg::Pedals pressed;
  if (window_.width() >= kNarrowest) {  // else the picture alone
    ImGui::SetNextWindowPos(ImVec2(edge, edge));
    draw_operation(state, controls, orders);
    const float right = ImGui::GetIO().DisplaySize.x - edge;
    ImGui::SetNextWindowPos(ImVec2(right, edge), 0, ImVec2(1, 0));
    pressed = draw_generator(state, orders);
    const float bottom = ImGui::GetIO().DisplaySize.y - edge;
    ImGui::SetNextWindowPos(ImVec2(right, bottom), 0, ImVec2(1, 1));
    draw_forces(state);
    ImGui::SetNextWindowPos(ImVec2(edge, bottom), 0, ImVec2(0, 1));
    ImGui::SetNextWindowCollapsed(true, ImGuiCond_FirstUseEver);
    if (ImGui::Begin((time_text(state, orders) + "###time").c_str(), nullptr, kStill)) {
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
  ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

void Panels::draw_disclaimer() {
  const ImVec2 middle = ImVec2(ImGui::GetIO().DisplaySize.x / 2, ImGui::GetIO().DisplaySize.y / 2);
  ImGui::SetNextWindowPos(middle, 0, ImVec2(0.5F, 0.5F));
  if (ImGui::Begin(texts_.title, nullptr, kStill | ImGuiWindowFlags_NoCollapse)) {
    ImGui::PushTextWrapPos(std::min(ImGui::GetFontSize() * 28, 1.8F * middle.x));
    ImGui::TextUnformatted(texts_.disclaimer);
    ImGui::PopTextWrapPos();
    if (ImGui::Button(texts_.understood,
                      ImVec2(ImGui::GetFontSize() * 10, ImGui::GetFontSize() * 2)) ||
        ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter))) {
      has_understood_ = true;
    }
  }
  end_panel();
}

void Panels::draw_guide(Guide& guide) {
  if (guide.hint() > Guide::kHints) {
    return;
  }
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, 0.86F * size.y), 0, ImVec2(0.5F, 1));
  if (ImGui::Begin("guide", nullptr, kBare)) {
    ImGui::PushTextWrapPos(std::min(ImGui::GetFontSize() * 30, 0.9F * size.x));
    ImGui::TextUnformatted(guide.hint() < Guide::kHints ? texts_.guide[guide.hint()]
                                                        : texts_.guide_done);
    ImGui::PopTextWrapPos();
  }
  ImGui::End();
}

void Panels::draw_help(Controls& controls) {
  const ImVec2 size = ImGui::GetIO().DisplaySize;
  ImGui::SetNextWindowPos(ImVec2(size.x / 2, size.y / 2), 0, ImVec2(0.5F, 0.5F));
  if (ImGui::Begin(texts_.help, nullptr, kStill | ImGuiWindowFlags_NoCollapse)) {
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
    if (ImGui::Button(texts_.close)) {
      controls.shows_help = false;
    }
  }
  end_panel();
}

void Panels::draw_operation(const SceneState& state, Controls& controls, Orders& orders) {
  if (ImGui::Begin(texts_.operation, nullptr, kStill)) {
    if (state.phase == Phase::loading) {
      ImGui::TextUnformatted(texts_.loading);
    } else if (state.phase == Phase::failed) {
      ImGui::TextColored(kRed, texts_.failed, state.message.c_str());
    }
    const bool has_grasper = controls.chosen() == Controls::grasper;
    ImGui::Text("%s: %s", controls.is_left() ? texts_.chosen_left : texts_.chosen_right,
                has_grasper ? texts_.grasper : texts_.hook);
    if (ImGui::Button(texts_.choose_other)) {
      controls.choose(has_grasper ? Controls::hook : Controls::grasper);
    }
    ImGui::SameLine();
    if (ImGui::Button(state.grasper.is_closed ? texts_.open_jaw : texts_.close_jaw)) {
      controls.toggle_jaw();
    }
    ImGui::PushButtonRepeat(true);
    if (ImGui::Button(texts_.deeper)) {
      controls.push(0.5F);
    }
    ImGui::SameLine();
    if (ImGui::Button(texts_.nearer)) {
      controls.push(-0.5F);
    }
    ImGui::PopButtonRepeat();
    ImGui::SameLine();
    if (ImGui::Button(texts_.slow_motion)) {
      controls.toggle_slow_motion();
    }
    if (ImGui::Button(texts_.undo)) {
      ++orders.undos;
    }
    ImGui::SameLine();
    if (ImGui::Button(orders.is_paused ? texts_.go_on : texts_.pause)) {
      orders.is_paused = !orders.is_paused;
    }
    ImGui::SameLine();
    if (ImGui::Button(texts_.single_step)) {
      orders.is_paused = true;
      ++orders.single_steps;
    }
    if (ImGui::Button(texts_.restart)) {
      controls.restart();
    }
    ImGui::SameLine();
    if (ImGui::Button(texts_.swap_hands)) {
      controls.toggle_handedness();
    }
    ImGui::SameLine();
    if (ImGui::Button(texts_.help)) {
      controls.shows_help = !controls.shows_help;
    }
    ImGui::Text(texts_.removed, static_cast<long long>(state.removed_tets),
                static_cast<long long>(state.parted_strands));
  }
  end_panel();
}

pbdsurg::Pedals Panels::draw_generator(const SceneState& state, Orders& orders) {
  pbdsurg::Pedals pressed;
  if (ImGui::Begin(texts_.generator, nullptr, kStill)) {
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
  if (ImGui::Begin(texts_.forces, nullptr, kStill)) {
    const ImVec2 size(ImGui::GetFontSize() * 15, ImGui::GetFontSize() * 3);
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
  ImGui::Text(texts_.pictures, pictures.per_second, pictures.milliseconds);
  ImGui::Text(texts_.step_times, state.times.heat, state.times.edit, state.times.solve,
              state.times.readback);
  ImGui::Text(texts_.publish_time, state.times.publish);
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
    for (const Warned& warning : warnings_) {
      ImGui::TextColored(kYellow, "%s", warning.text.c_str());
    }
  }
  ImGui::End();
}

}  // namespace cholecystectomy
