// SPDX-License-Identifier: Apache-2.0
// Panels without a window: Dear ImGui alone, whose pictures nobody draws.
#include "apps/cholecystectomy/play/panels.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include <imgui.h>

#include "tests/play/room.h"
#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

struct Desk {
  Desk(float columns, float rows, float screen_scale = 1, double text_scale = 1)
      : width(columns), height(rows), screen(screen_scale), text(text_scale) {
    state.phase = Phase::playing;
    ImGui::GetIO().MousePos = ImVec2(-1, -1);
    settle();
  }

  void picture() {
    ImGuiIO& io = ImGui::GetIO();
    io.DisplaySize = ImVec2(width, height);
    io.DeltaTime = 1 / 60.0F;
    if (panels.fit(screen, text)) {
      unsigned char* pixels = nullptr;
      int columns = 0, rows = 0;
      io.Fonts->GetTexDataAsRGBA32(&pixels, &columns, &rows);
    }
    panels.lay_out(state, room.controls, room.orders, guide, settings, {}, 0);
  }
  /// Sizes follow contents a picture later.
  void settle() {
    for (int i = 0; i < 4; ++i) {
      picture();
    }
  }

  [[nodiscard]] const Panels::Button* find(const std::string& name) const {
    const auto found =
        std::find_if(panels.buttons().begin(), panels.buttons().end(),
                     [&](const Panels::Button& button) { return button.text == name; });
    return found == panels.buttons().end() ? nullptr : &*found;
  }
  void point_at(const std::string& name) {
    const Panels::Button* const button = find(name);
    REQUIRE(button != nullptr);
    const Panels::Rectangle& place = button->place;
    ImGui::GetIO().MousePos =
        ImVec2((place.left + place.right) / 2, (place.top + place.bottom) / 2);
    picture();
  }
  void hold(bool is_down) {
    ImGui::GetIO().MouseDown[0] = is_down;
    picture();
  }
  void click(const std::string& name) {
    CAPTURE(name);
    point_at(name);
    hold(true);
    hold(false);
    settle();
  }

  float width, height, screen;
  double text;
  Room room;
  SceneState state;
  Guide guide;
  Settings settings;
  bool has_understood = true;
  Panels panels{kEnglish, has_understood};
};

bool is_inside(const Panels::Rectangle& inner, const Panels::Rectangle& outer) {
  return inner.left >= outer.left - 0.5F && inner.top >= outer.top - 0.5F &&
         inner.right <= outer.right + 0.5F && inner.bottom <= outer.bottom + 0.5F;
}

bool meet(const Panels::Rectangle& a, const Panels::Rectangle& b) {
  return a.left < b.right && b.left < a.right && a.top < b.bottom && b.top < a.bottom;
}

const char* const kWarning =
    "A warning whose text is much longer than a screen of such a size is wide, so that it has to "
    "go "
    "on in a second line, or even in a third, unless the screen is one of the largest that there "
    "are.";

void check_inside(const Desk& desk) {
  const Panels::Rectangle display{0, 0, desk.width, desk.height};
  for (const Panels::Rectangle& panel : desk.panels.covered()) {
    CAPTURE(panel.left, panel.top, panel.right, panel.bottom);
    CHECK(is_inside(panel, display));
  }
  // hints and warnings let the mouse through
  const ImDrawData& drawn = *ImGui::GetDrawData();
  for (int i = 0; i < drawn.CmdListsCount; ++i) {
    const ImDrawList& list = *drawn.CmdLists[i];
    const std::string name = list._OwnerName == nullptr ? "" : list._OwnerName;
    if (name != "guide" && name != "warnings") {
      continue;
    }
    Panels::Rectangle box{desk.width, desk.height, 0, 0};
    for (const ImDrawVert& vertex : list.VtxBuffer) {
      box.left = std::min(box.left, vertex.pos.x);
      box.top = std::min(box.top, vertex.pos.y);
      box.right = std::max(box.right, vertex.pos.x);
      box.bottom = std::max(box.bottom, vertex.pos.y);
    }
    CAPTURE(name, box.left, box.top, box.right, box.bottom);
    CHECK(is_inside(box, display));
    // a line that is cut off is larger than its box
    const ImVec2 line = ImGui::CalcTextSize(name == "guide" ? kEnglish.guide[0] : kWarning);
    CHECK(line.x * line.y < (box.right - box.left) * (box.bottom - box.top));
  }
}

constexpr std::array<std::array<float, 2>, 8> kSizes{{{320, 240},
                                                      {360, 270},
                                                      {480, 800},
                                                      {640, 480},
                                                      {1280, 720},
                                                      {1920, 1080},
                                                      {2560, 1080},
                                                      {3840, 2160}}};

}  // namespace

// Would catch a panel or a text that is cut off by the edge of the screen, in any state.
TEST_CASE("panels: nothing lies outside of the screen", "[unit]") {
  for (const auto& [width, height] : kSizes) {
    for (const float screen : {1.0F, 2.0F}) {
      for (const double text : {0.7, 1.0, 3.0}) {
        const float w = width, h = height;
        CAPTURE(w, h, screen, text);
        Desk desk(width, height, screen, text);
        check_inside(desk);
        desk.panels.warn(
            "A warning whose text is much longer than a screen of such a size is wide, "
            "so that it has to go on in a second line, or even in a third.",
            0);
        desk.state.phase = Phase::failed;
        desk.state.message =
            "a reason which takes more than one line, for it is long " + std::string(200, 'x');
        desk.state.factor = 0.3;
        desk.settle();
        check_inside(desk);
        desk.state.phase = Phase::loading;
        desk.room.controls.shows_help = true;
        desk.settle();
        check_inside(desk);
        desk.room.controls.shows_help = false;
        desk.has_understood = false;
        desk.settle();
        check_inside(desk);
      }
    }
  }
}

// Would catch buttons for a mouse's arrow alone, which a finger misses.
TEST_CASE("panels: buttons are as large as a fingertip", "[unit]") {
  constexpr float kLeast = 34;  // pixels: 9 mm at 96 a inch
  for (const auto& [width, height] : kSizes) {
    for (const float screen : {1.0F, 2.0F}) {
      const float w = width, h = height;
      CAPTURE(w, h, screen);
      Desk desk(width, height, screen);
      const auto check_all = [&] {
        for (const Panels::Button& button : desk.panels.buttons()) {
          CAPTURE(button.text);
          CHECK(button.place.right - button.place.left >= kLeast * screen);
          CHECK(button.place.bottom - button.place.top >= kLeast * screen);
        }
      };
      for (const char* const group :
           {kEnglish.instrument, kEnglish.scope, kEnglish.scene, kEnglish.program}) {
        if (desk.find(group) != nullptr) {  // not folded
          desk.click(group);
        }
        check_all();
        check_inside(desk);
      }
      desk.room.controls.shows_help = true;
      desk.settle();
      REQUIRE(!desk.panels.buttons().empty());
      check_all();
    }
  }
}

// Would catch panels that hide each other, or the middle of the picture.
TEST_CASE("panels: they leave each other room, and the middle to the picture", "[unit]") {
  for (const auto& [width, height] : kSizes) {
    for (const float screen : {1.0F, 1.5F, 2.0F}) {
      const float w = width, h = height;
      CAPTURE(w, h, screen);
      const Desk desk(width, height, screen);
      const auto& panels = desk.panels.covered();
      CHECK(panels.size() == (width < 360 ? 0U : 4U));
      const Panels::Rectangle middle{0.5F * width, 0.4F * height, 0.5F * width, 0.6F * height};
      for (std::size_t i = 0; i < panels.size(); ++i) {
        CHECK_FALSE(meet(panels[i], middle));
        for (std::size_t j = 0; j < i; ++j) {
          CAPTURE(i, j);
          CHECK_FALSE(meet(panels[i], panels[j]));
        }
      }
    }
  }
}

// Would catch a button without an action, with another's, or that acts twice.
TEST_CASE("panels: a click on a button does what its text says", "[unit]") {
  const Texts& texts = kEnglish;
  Desk desk(1280, 1080);
  Room& room = desk.room;
  const Orders& orders = room.orders;

  desk.click(texts.pause);
  CHECK(orders.is_paused);
  desk.click(texts.go_on);
  CHECK_FALSE(orders.is_paused);
  desk.click(texts.scene);
  desk.click(texts.single_step);
  CHECK(orders.is_paused);
  CHECK(orders.single_steps == 1);
  desk.click(texts.slow_motion);
  CHECK(orders.speed < 1);
  desk.click(texts.slow_motion);
  CHECK(orders.speed == 1);
  desk.click(texts.undo);
  CHECK(orders.undos == 1);
  desk.click(texts.restart);
  CHECK(orders.restarts == 1);
  desk.click(texts.swap_hands);
  CHECK(room.controls.is_left_handed());
  CHECK(orders.restarts == 2);
  desk.click(texts.program);
  CHECK(desk.find(texts.restart) == nullptr);  // one group makes room for another
  desk.click(texts.full_screen);
  CHECK(room.controls.wishes.fullscreen);
  desk.click(texts.screenshot);
  CHECK(room.controls.wishes.screenshot);
  CHECK_FALSE(room.controls.wishes.quit);
  desk.click(texts.help);
  CHECK(room.controls.shows_help);
  desk.click(texts.close);
  CHECK_FALSE(room.controls.shows_help);
  desk.click(texts.program);
  CHECK(desk.find(texts.help) == nullptr);

  desk.click(texts.close_jaw);
  CHECK(room.hands[0].jaw() == 0);
  desk.state.grasper.is_closed = true;
  desk.settle();
  desk.click(texts.open_jaw);
  CHECK(room.hands[0].jaw() == 1);
  desk.click(texts.choose_other);
  CHECK(room.controls.chosen() == Controls::hook);
  CHECK(orders.undos == 1);
  CHECK(orders.single_steps == 1);
}

// Would catch buttons that move the other instrument or the other way than they say.
TEST_CASE("panels: buttons move the chosen instrument", "[unit]") {
  const Texts& texts = kEnglish;
  Desk desk(1280, 1080);
  Room& room = desk.room;
  const Eigen::Vector3f other = room.hands[1].tip(), start = room.hands[0].tip();
  const Camera camera = room.scope.camera();
  const Eigen::Vector3f ahead = (camera.target - camera.eye).normalized();
  desk.click(texts.instrument);
  desk.click(texts.deeper);
  CHECK((room.hands[0].tip() - start).dot(ahead) > 0.5e-3F);
  desk.click(texts.nearer);
  CHECK((room.hands[0].tip() - start).norm() < 1e-5F);
  desk.point_at(texts.deeper);
  for (int i = 0; i < 60; ++i) {  // a second
    desk.hold(true);
  }
  desk.hold(false);
  CHECK((room.hands[0].tip() - start).dot(ahead) > 5e-3F);
  const Eigen::Isometry3f pose = room.hands[0].state().pose;
  desk.click(texts.roll_left);
  const Eigen::AngleAxisf turn(pose.rotation().transpose() * room.hands[0].state().pose.rotation());
  CHECK(turn.angle() > 0.1F);
  desk.click(texts.roll_right);
  CHECK(room.hands[0].state().pose.isApprox(pose, 1e-4F));
  CHECK(room.hands[1].tip() == other);
}

// Would catch buttons that turn the scope the other way than they say.
TEST_CASE("panels: buttons turn the scope", "[unit]") {
  const Texts& texts = kEnglish;
  Desk desk(1280, 1080);
  Room& room = desk.room;
  desk.click(texts.scope);
  const Scope start = room.scope;
  const Eigen::Vector3f point(0, 0, 0);
  Eigen::Vector2f place = room.place_of(point);
  const auto click = [&](const char* text) {  // and how the point's place goes, pixels
    const Eigen::Vector2f before = room.place_of(point);
    desk.click(text);
    return Eigen::Vector2f(room.place_of(point) - before);
  };
  CHECK(click(texts.look_left).x() > 5);
  CHECK(click(texts.look_right).x() < -5);
  CHECK(click(texts.look_up).y() > 5);
  CHECK(click(texts.look_down).y() < -5);
  CHECK((room.place_of(point) - place).norm() < 0.5F);
  desk.click(texts.scope_in);
  CHECK(room.scope.insertion() > start.insertion() + 1e-3F);
  desk.click(texts.scope_out);
  CHECK(std::abs(room.scope.insertion() - start.insertion()) < 1e-5F);
  desk.click(texts.post_left);
  CHECK(room.scope.post() != start.post());
  desk.click(texts.post_right);
  CHECK(std::abs(room.scope.post() - start.post()) < 1e-5F);
  desk.click(texts.head_left);
  CHECK(room.scope.head() > start.head() + 0.1F);
  CHECK_FALSE(room.scope.is_level());
  desk.click(texts.head_right);
  CHECK(std::abs(room.scope.head() - start.head()) < 1e-4F);
  desk.click(texts.level);
  CHECK(room.scope.is_level());
  desk.click(texts.follow_tips);
  CHECK(room.controls.is_following());
  desk.click(texts.follow_tips);
  CHECK_FALSE(room.controls.is_following());
}

// Would catch pedals on the screen that stay down, or never go down.
TEST_CASE("panels: a pedal on the screen is down for as long as it is held", "[unit]") {
  const Texts& texts = kEnglish;
  Desk desk(1280, 720);
  const auto pedals = [&] { return desk.room.hands[1].state().pedals; };
  desk.point_at(texts.cut);
  CHECK(pedals() == pbdsurg::Pedals{});
  desk.hold(true);
  desk.hold(true);
  CHECK(pedals() == pbdsurg::Pedals{true, false});
  desk.hold(false);
  CHECK(pedals() == pbdsurg::Pedals{});
  desk.point_at(texts.coagulation);
  desk.hold(true);
  CHECK(pedals() == pbdsurg::Pedals{false, true});
  desk.hold(false);
  CHECK(pedals() == pbdsurg::Pedals{});
}

// Would catch a click on a button that moves the instrument below it, too.
TEST_CASE("panels: what is done to them the operation does not hear", "[unit]") {
  Desk desk(1280, 720);
  const Panels::Rectangle& place = desk.find(kEnglish.undo)->place;
  const ButtonInput press{MouseButton::left, true}, release{MouseButton::left, false};
  const auto heard = [&](const std::vector<Input>& inputs) {
    return desk.panels.unclaimed(inputs).size();
  };
  CHECK(heard({CursorInput{place.left + 1, place.top + 1}, press, WheelInput{1}}) == 1);
  CHECK(heard({CursorInput{640, 360}, press, WheelInput{1}, release}) == 4);
  CHECK(heard({CursorInput{640, 360}, press, CursorInput{place.left + 1, place.top + 1},
               release}) == 4);
  CHECK(heard({CursorInput{place.left + 1, place.top + 1}, KeyInput{Key::g, true}}) == 2);
}

TEST_CASE("panels: the disclaimer stays until it is understood", "[unit]") {
  Desk desk(640, 480);
  desk.has_understood = false;
  desk.settle();
  REQUIRE(desk.find(kEnglish.understood) != nullptr);
  SECTION("by a click") {
    desk.click(kEnglish.understood);
  }
  SECTION("by a key") {
    CHECK(desk.panels.unclaimed({KeyInput{Key::enter, true}}).size() == 1);
  }
  desk.settle();
  CHECK(desk.has_understood);
  CHECK(desk.find(kEnglish.understood) == nullptr);
}

}  // namespace cholecystectomy
