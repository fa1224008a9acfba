// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/play/guide.h"

#include "tests/play/room.h"
#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

/// A trainee, the clock, and a scene that does what hands ask for.
struct Lesson {
  Room room;
  SceneState state;
  Guide guide;
  double now = 0;

  Lesson() { state.phase = Phase::playing; }

  void wait(double seconds) {
    for (double end = now + seconds; now < end;) {
      now += 0.05;
      guide.update(state, room.controls, room.scope, now);
    }
  }

  void move() { room.hands[0].move({-0.015F, 0, 0}); }
  void grasp() {
    room.controls.toggle_jaw();
    state.grasper.is_holding = state.grasper.is_closed = true;
  }
  void pull() { state.grasper.force = {0, 0, 1}; }
  void choose_hook() { room.press(Key::tab); }
  void burn() {
    state.generator.activation = pbdsurg::Activation::cut;
    state.generator.is_touching = true;
  }
  void turn() { room.scope.orbit(0.1F, 0.1F); }

  static constexpr std::array<void (Lesson::*)(), Guide::kHints> kSteps{
      &Lesson::move,        &Lesson::grasp, &Lesson::pull,
      &Lesson::choose_hook, &Lesson::burn,  &Lesson::turn};
};

}  // namespace

// Would catch a hint that stays, one that goes by itself, and last words that never end.
TEST_CASE("guide: each hint goes when it was followed, all within a minute", "[unit]") {
  Lesson lesson;
  for (std::size_t hint = 0; hint < Guide::kHints; ++hint) {
    lesson.wait(7);
    CHECK(lesson.guide.hint() == hint);
    (lesson.*Lesson::kSteps[hint])();
    lesson.wait(0.1);
    CHECK(lesson.guide.hint() == hint + 1);
  }
  lesson.wait(Guide::kFarewell - 0.5);
  CHECK(lesson.guide.hint() == Guide::kHints);
  lesson.wait(1);
  CHECK(lesson.guide.hint() > Guide::kHints);
  CHECK(lesson.now < 60);
}

// Would catch hints that skip what was not done because something later was.
TEST_CASE("guide: what comes later does not count for a hint", "[unit]") {
  for (std::size_t hint = 0; hint < Guide::kHints; ++hint) {
    Lesson lesson;
    lesson.wait(0.1);
    for (std::size_t step = 0; step < Guide::kHints; ++step) {
      // to pull or burn needs what comes before
      if (step != hint && !(hint == 1 && step == 2)) {
        (lesson.*Lesson::kSteps[step])();
      }
      lesson.wait(0.1);
    }
    CAPTURE(hint, lesson.guide.hint());
    CHECK(lesson.guide.hint() <= hint);
  }
}

// Would catch a first hint that is gone before anyone has read it: at the beginning instruments
// come to where hands are.
TEST_CASE("guide: nothing counts but what a trainee does, while the scene plays", "[unit]") {
  Lesson lesson;
  lesson.state.phase = Phase::loading;
  lesson.move();
  lesson.wait(1);
  lesson.state.phase = Phase::playing;
  lesson.wait(0.1);
  lesson.state.grasper.pose.translation() += Eigen::Vector3f(0.05F, 0, 0);
  lesson.wait(1);
  CHECK(lesson.guide.hint() == 0);
  lesson.room.hands[1].move({0.015F, 0, 0});  // the other hand
  lesson.wait(0.1);
  CHECK(lesson.guide.hint() == 0);
}

}  // namespace cholecystectomy
