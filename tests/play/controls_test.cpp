// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/controls.h"

#include "tests/play/room.h"
#include "tests/support/catch.h"

namespace cholecystectomy {

using pbdsurg::Pedals;
using pbdsurg::testing::Approx;

// Would catch a tip that runs away from the cursor.
TEST_CASE("controls: a dragged tip stays under the cursor", "[unit]") {
  Room room;
  const Eigen::Vector2f start = room.place_of(room.hands[0].tip());
  room.handle({CursorInput{300, 200}});  // no button: nothing moves
  REQUIRE((room.place_of(room.hands[0].tip()) - start).norm() < 1e-3F);
  room.handle({ButtonInput{MouseButton::left, true}, CursorInput{340, 170}});
  const Eigen::Vector2f way = room.place_of(room.hands[0].tip()) - start;
  CHECK(way.x() == Approx(40).margin(0.05));
  CHECK(way.y() == Approx(-30).margin(0.05));
  room.handle({ButtonInput{MouseButton::left, false}, CursorInput{400, 400}});
  CHECK((room.place_of(room.hands[0].tip()) - start - way).norm() < 1e-3F);
}

TEST_CASE("controls: the wheel moves the tip along the view, Tab chooses the other hand",
          "[unit]") {
  Room room;
  const Eigen::Vector3f left = room.hands[0].tip(), right = room.hands[1].tip();
  room.handle({WheelInput{2}});
  const Camera camera = room.scope.camera();
  const Eigen::Vector3f ahead = (camera.target - camera.eye).normalized();
  CHECK((room.hands[0].tip() - left).normalized().dot(ahead) == Approx(1));
  room.press(Key::tab);
  CHECK(room.controls.chosen() == Controls::hook);
  room.handle({WheelInput{-1}});
  CHECK((room.hands[1].tip() - right).normalized().dot(ahead) == Approx(-1));
}

// Would catch current that goes on when nobody is there.
TEST_CASE("controls: pedals are down while keys are, and up when the window loses them", "[unit]") {
  Room room;
  const auto pedals = [&] { return room.hands[1].state().pedals; };
  room.handle({KeyInput{Key::c, true}});
  CHECK(pedals() == Pedals{true, false});
  room.handle({KeyInput{Key::v, true}});
  CHECK(pedals() == Pedals{true, true});
  room.handle({KeyInput{Key::c, false}});
  CHECK(pedals() == Pedals{false, true});
  const std::uint32_t let_gos = room.orders.let_gos;
  room.handle({FocusInput{false}});
  CHECK(pedals() == Pedals{});
  CHECK(room.orders.let_gos == let_gos + 1);  // pedals that are no keys
  room.controls.press_on_screen({true, false});
  CHECK(pedals() == Pedals{true, false});
  room.handle({FocusInput{false}});
  CHECK(pedals() == Pedals{});
}

// Would catch a drag that goes on after the window lost the mouse.
TEST_CASE("controls: a lost window ends drags", "[unit]") {
  Room room;
  const Eigen::Vector3f tip = room.hands[0].tip();
  room.handle({ButtonInput{MouseButton::left, true}, FocusInput{false}, CursorInput{50, 50}});
  CHECK(room.hands[0].tip() == tip);
}

TEST_CASE("controls: jaws are the grasper's, whichever instrument is chosen", "[unit]") {
  Room room;
  room.press(Key::g);
  CHECK(room.hands[0].state().jaw == 0);
  room.press(Key::tab);
  room.press(Key::space);
  CHECK(room.hands[0].state().jaw == 1);
  CHECK(room.hands[1].state().jaw == 1);
}

// Would catch a left-handed trainee whose pedals or chosen instrument are mixed up.
TEST_CASE("controls: swapped hands exchange ports, and the scene begins anew", "[unit]") {
  Room room;
  const Eigen::Isometry3f grasper = room.hands[0].state().pose, hook = room.hands[1].state().pose;
  room.handle({KeyInput{Key::c, true}});
  CHECK(room.controls.is_left());
  room.press(Key::x);
  CHECK(room.controls.is_left_handed());
  CHECK_FALSE(room.controls.is_left());  // the grasper is still chosen, in the right hand
  CHECK(room.hands[0].state().pose.isApprox(hook));
  CHECK(room.hands[1].state().pose.isApprox(grasper));
  CHECK(room.hands[1].state().pedals == Pedals{});
  CHECK(room.orders.restarts == 1);
  room.handle({KeyInput{Key::v, true}});
  CHECK(room.hands[1].state().pedals == Pedals{false, true});
  room.press(Key::x);
  CHECK_FALSE(room.controls.is_left_handed());
  CHECK(room.hands[0].state().pose.isApprox(grasper));
}

TEST_CASE("controls: what happens once is counted", "[unit]") {
  Room room;
  room.press(Key::z);
  room.press(Key::z);
  room.press(Key::period);
  room.press(Key::r);  // without shift it would be too easy
  CHECK(room.orders.undos == 2);
  CHECK(room.orders.is_paused);
  CHECK(room.orders.single_steps == 1);
  CHECK(room.orders.restarts == 0);
  room.press(Key::r, true);
  CHECK(room.orders.restarts == 1);
  room.press(Key::p);
  CHECK_FALSE(room.orders.is_paused);
  room.press(Key::comma);
  CHECK(room.orders.speed == Approx(0.25));
  room.press(Key::comma);
  CHECK(room.orders.speed == 1);
}

TEST_CASE("controls: Escape leaves the help before it leaves the program", "[unit]") {
  Room room;
  room.press(Key::h);
  CHECK(room.controls.shows_help);
  room.press(Key::escape);
  CHECK_FALSE(room.controls.shows_help);
  CHECK_FALSE(room.controls.wishes.quit);
  room.press(Key::escape);
  CHECK(room.controls.wishes.quit);
}

TEST_CASE("controls: the right button turns the scope, and its wheel slides it", "[unit]") {
  Room room;
  const Eigen::Vector3f shaft = room.scope.shaft(), tip = room.hands[0].tip();
  const float insertion = room.scope.insertion();
  room.handle({ButtonInput{MouseButton::right, true}, CursorInput{60, 0}});
  CHECK((room.scope.shaft() - shaft).norm() > 0.05F);
  room.handle({WheelInput{1}});
  CHECK(room.scope.insertion() > insertion);
  CHECK(room.hands[0].tip() == tip);
}

// Would catch a scope that goes on against the hand that moves it, and one hand's wish for a moment
// that is remembered for ever.
TEST_CASE("controls: F lets the scope follow the tips, until a hand moves it", "[unit]") {
  Room room;
  room.controls.turn_head(1);
  room.press(Key::f);
  CHECK(room.controls.is_following());
  CHECK(room.scope.is_level());
  CHECK(room.controls.wants_following == true);
  const auto moved_by = [&](const std::vector<Input>& inputs) {
    room.controls.let_go();
    if (!room.controls.is_following()) {
      room.press(Key::f);
    }
    room.handle(inputs);
    CHECK(room.controls.wants_following == true);
    return !room.controls.is_following();
  };
  CHECK(moved_by({ButtonInput{MouseButton::right, true}, CursorInput{60, 0}}));
  CHECK(moved_by({ButtonInput{MouseButton::right, true}, WheelInput{1}}));
  CHECK(moved_by({KeyInput{Key::a, true}}));
  CHECK(moved_by({KeyInput{Key::left_bracket, true}}));
  CHECK_FALSE(moved_by({KeyInput{Key::l, true}}));  // it is level
  CHECK_FALSE(moved_by({ButtonInput{MouseButton::left, true}, CursorInput{90, 0}, WheelInput{1}}));
  room.press(Key::f);
  CHECK_FALSE(room.controls.is_following());
  CHECK(room.controls.wants_following == false);
}

// Would catch a picture that goes against the cursor, in either direction.
TEST_CASE("controls: the picture goes with a drag that turns the scope", "[unit]") {
  Room room;
  const Eigen::Vector3f point(0, 0, 0);
  const Eigen::Vector2f start = room.place_of(point);
  room.handle({ButtonInput{MouseButton::right, true}, CursorInput{20, 0}});
  const Eigen::Vector2f right = room.place_of(point);
  CHECK(right.x() > start.x() + 10);
  room.handle({CursorInput{20, 20}});
  CHECK(room.place_of(point).y() > right.y() + 10);
}

}  // namespace cholecystectomy
