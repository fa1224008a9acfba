// SPDX-License-Identifier: Apache-2.0
#include "apps/cholecystectomy/camera_assistant.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "pbdsurg/base/random.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using pbdsurg::testing::Approx;
using pbdsurg::testing::ContainsSubstring;

using Tips = std::array<Eigen::Vector3f, 2>;

constexpr double kPicture = 1.0 / 30;                                         // s
const Eigen::Vector3f kPort(0.003F, -0.192F, -0.138F), kCentre(0.03F, 0, 0);  // as in the window
constexpr float kScene = 0.16F;

float random_in(float least, float most, std::uint64_t trial, std::uint64_t use) {
  return least + (most - least) * static_cast<float>(pbdsurg::random_unit(41, trial, use));
}

Eigen::Vector3f random_vector(float most, std::uint64_t trial, std::uint64_t use) {
  return {random_in(-most, most, trial, 3 * use), random_in(-most, most, trial, 3 * use + 1),
          random_in(-most, most, trial, 3 * use + 2)};
}

Scope scope_of_window(const Eigen::Vector3f& port = kPort) {
  ScopeOptions options;
  options.working_distance = 0.13F;
  return Scope::looking_at(port, kCentre, options);
}

CameraAssistant assistant_on() {
  CameraAssistant assistant(kCentre, kScene);
  assistant.switch_on(true);
  return assistant;
}

// Of a point in the picture, from its middle, half heights; infinite behind the lens.
float place_of(const Scope& scope, const Eigen::Vector3f& point) {
  const Eigen::Vector3f way = point - scope.tip();
  const float ahead = way.dot(scope.view());
  return ahead > 0 ? (way - ahead * scope.view()).norm() /
                         (ahead * std::tan(scope.camera().vertical_field_of_view / 2))
                   : std::numeric_limits<float>::infinity();
}

float outermost(const Scope& scope, const Tips& tips) {
  return std::max(place_of(scope, tips[0]), place_of(scope, tips[1]));
}

float nearest(const Scope& scope, const Tips& tips) {
  return std::min((tips[0] - scope.tip()).norm(), (tips[1] - scope.tip()).norm());
}

// A tip on the right of the picture: half heights from its middle, m along the view.
Eigen::Vector3f point_in(const Scope& scope, float right, float ahead) {
  const Camera camera = scope.camera();
  return camera.eye + ahead * scope.view() +
         right * ahead * std::tan(camera.vertical_field_of_view / 2) *
             scope.view().cross(camera.up).normalized();
}

bool same(const Scope& a, const Scope& b) {
  return a.azimuth() == b.azimuth() && a.elevation() == b.elevation() &&
         a.insertion() == b.insertion() && a.focus() == b.focus() && a.post() == b.post() &&
         a.head() == b.head() && a.is_level() == b.is_level();
}

// What turns and slides between two poses, in seconds at full speed.
Eigen::Vector4f way_between(const Scope& from, const Scope& to) {
  constexpr float kTurn = static_cast<float>(2 * std::numbers::pi);
  return {std::remainder(to.azimuth() - from.azimuth(), kTurn) / CameraAssistant::kTurningSpeed,
          (to.elevation() - from.elevation()) / CameraAssistant::kTurningSpeed,
          (to.insertion() - from.insertion()) / CameraAssistant::kSlidingSpeed,
          (to.focus() - from.focus()) / CameraAssistant::kSlidingSpeed};
}

// How far the horizon leans in the picture, rad.
float lean_of(const Scope& scope) {
  const Camera camera = scope.camera();
  const Eigen::Vector3f up = scope.options().up;
  return std::atan2(up.dot(scope.view().cross(camera.up).normalized()), up.dot(camera.up));
}

// Follows tips for a time, and looks at every step.
struct Watch {
  Scope scope;
  CameraAssistant assistant = assistant_on();
  float path = 0;  // s at full speed
  Eigen::Vector4f speed = Eigen::Vector4f::Zero();
  float fastest = 0, hardest = 0, most_lean = 0;
  float least_distance = std::numeric_limits<float>::infinity();
  bool comes_too_near = false;

  void step(const Tips& tips, double dt = kPicture) {
    const Scope before = scope;
    assistant.follow(scope, tips, dt);
    const Eigen::Vector4f way = way_between(before, scope);
    const Eigen::Vector4f now = way / static_cast<float>(dt);
    path += way.norm();
    fastest = std::max(fastest, now.norm());
    hardest = std::max(hardest, (now - speed).norm() / static_cast<float>(dt));
    speed = now;
    most_lean = std::max(most_lean, std::abs(lean_of(scope)));
    const float distance = nearest(scope, tips);
    const bool slides_back = way[2] < 0 && way.head<2>().isZero(0);  // where the shaft has been
    comes_too_near = comes_too_near || (distance < CameraAssistant::kNearest && !slides_back &&
                                        distance < nearest(before, tips) - 1e-6F);
    least_distance = std::min(least_distance, distance);
  }
  void run(const Tips& tips, double seconds, double dt = kPicture) {
    for (int i = 0; i < static_cast<int>(seconds / dt); ++i) {
      step(tips, dt);
    }
  }
};

}  // namespace

// Would catch a camera that loses a tip, hurries, jerks, swings, leans, or hits an instrument.
TEST_CASE("camera assistant: from anywhere both tips come into the inner part, on a short way",
          "[property]") {
  const std::array<double, 3> pictures{1.0 / 60, 1.0 / 30, 0.1};  // s
  // of the second, shafts point to where the azimuth leaps from pi to -pi
  const std::array<Eigen::Vector3f, 2> ports{kPort, kCentre + Eigen::Vector3f(0.22F, 0, -0.09F)};
  int outside = 0, straight = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    Scope start = scope_of_window(ports[trial / 3 % 2]);
    start.turn_post(random_in(-0.5F, 0.5F, trial, 30));
    start.orbit(random_in(-0.7F, 0.7F, trial, 31), random_in(-0.7F, 0.7F, trial, 32));
    start.advance(random_in(-0.1F, 0.12F, trial, 33));
    const Tips tips{kCentre + random_vector(0.023F, trial, 0),
                    kCentre + random_vector(0.023F, trial, 1)};
    const bool is_outside = outermost(start, tips) > CameraAssistant::kInnerPart;
    outside += is_outside ? 1 : 0;
    Watch watch{start};
    watch.run(tips, 40, pictures[trial % 3]);
    CAPTURE(trial, watch.least_distance, watch.path);
    CHECK(outermost(watch.scope, tips) <=
          (is_outside ? CameraAssistant::kMargin + 0.02F : CameraAssistant::kInnerPart));
    CHECK(nearest(watch.scope, tips) >= CameraAssistant::kNearest);
    CHECK(watch.fastest < 1.01F);
    CHECK(watch.most_lean < 1e-3F);
    CHECK_FALSE(watch.comes_too_near);
    const Scope end = watch.scope;
    watch.run(tips, 5);
    CHECK(same(watch.scope, end));
    CHECK(watch.hardest < 6);  // a fifth of a second to full speed
    // around a tip that is near, a little more
    const bool is_straight = watch.least_distance > CameraAssistant::kNearest + 0.011F;
    straight += is_straight ? 1 : 0;
    CHECK(watch.path < (is_straight ? 1.02F : 1.4F) * way_between(start, end).norm() + 1e-3F);
  }
  CHECK(outside > 100);
  CHECK(straight > 100);
  CHECK(straight < 290);
}

// Would catch a picture that trembles with the hands, and an inner part that is smaller than it
// should be.
TEST_CASE("camera assistant: while tips are in the inner part, the scope rests to the bit",
          "[unit]") {
  const Scope start = scope_of_window();
  Scope scope = start;
  CameraAssistant assistant = assistant_on();
  const float rim = 0.98F * CameraAssistant::kInnerPart;
  for (std::uint64_t i = 0; i < 600; ++i) {
    const float tremor = random_in(-0.15F, 0, i, 0);
    assistant.follow(
        scope, Tips{point_in(start, rim + tremor, 0.11F), point_in(start, -rim, 0.12F)}, kPicture);
    REQUIRE(same(scope, start));
  }
  const Tips out{point_in(start, 1.1F * CameraAssistant::kInnerPart, 0.11F),
                 point_in(start, 0, 0.11F)};
  assistant.follow(scope, out, kPicture);
  CHECK_FALSE(same(scope, start));
}

TEST_CASE("camera assistant: a scope that arrived rests while hands tremble", "[unit]") {
  Watch watch{scope_of_window()};
  const Tips tips{Eigen::Vector3f(0.1F, 0.03F, 0.02F), Eigen::Vector3f(0.09F, 0, 0.01F)};
  REQUIRE(outermost(watch.scope, tips) > CameraAssistant::kInnerPart);
  const auto tremble = [&](std::uint64_t i) {
    watch.step({tips[0] + random_vector(1e-3F, i, 0), tips[1] + random_vector(1e-3F, i, 1)});
  };
  for (std::uint64_t i = 0; i < 300; ++i) {
    tremble(i);
  }
  const Scope arrived = watch.scope;
  for (std::uint64_t i = 300; i < 900; ++i) {
    tremble(i);
    REQUIRE(same(watch.scope, arrived));
  }
  CHECK(outermost(arrived, tips) < CameraAssistant::kInnerPart);
}

// Would catch a camera that lags behind hands at work, or shakes with them.
TEST_CASE("camera assistant: tips on their way stay in the picture", "[unit]") {
  Watch watch{scope_of_window()};
  Tips tips;
  for (int i = 0; i < 3000; ++i) {
    const float t = static_cast<float>(i * kPicture);
    const Eigen::Vector3f work(0.03F * std::sin(0.4F * t), 0.03F * std::sin(0.25F * t),
                               0.02F * std::sin(0.3F * t));
    tips = {kCentre + work + random_vector(1e-3F, static_cast<std::uint64_t>(i), 0),
            kCentre + work + Eigen::Vector3f(0.02F + 0.01F * std::sin(0.15F * t), 0, 0)};
    watch.step(tips);
    if (t > 5) {
      REQUIRE(outermost(watch.scope, tips) < 0.95F);
    }
  }
  CHECK(watch.fastest < 1.01F);
  CHECK(watch.hardest < 6);
  CHECK(watch.most_lean < 1e-3F);
  CHECK(watch.path > 1);
}

// Would catch a lens that is carried on into a tip which was not there a moment ago.
TEST_CASE("camera assistant: where tips leap about, the scope goes no nearer to one than it may",
          "[property]") {
  Watch watch{scope_of_window(), CameraAssistant(kCentre, 1)};
  watch.assistant.switch_on(true);
  int near = 0;
  for (std::uint64_t leap = 0; leap < 1000; ++leap) {
    const Tips tips{watch.scope.tip() + random_vector(0.08F, leap, 0),
                    kCentre + random_vector(0.08F, leap, 1)};
    for (int i = 0; i < 10; ++i) {
      watch.step(tips);
    }
    near += nearest(watch.scope, tips) < CameraAssistant::kNearest ? 1 : 0;
  }
  CHECK(near > 100);
  CHECK_FALSE(watch.comes_too_near);
  CHECK(watch.fastest < 1.01F);
}

// Would catch a camera that only turns.
TEST_CASE("camera assistant: it slides back from tips far apart, and closer to those together",
          "[unit]") {
  const Eigen::Vector3f half(0.035F, 0, 0);
  const auto distance_to = [](const Tips& tips, Watch& watch) {
    watch.run(tips, 20);
    return (0.5F * (tips[0] + tips[1]) - watch.scope.tip()).dot(watch.scope.view());
  };
  Watch watch{scope_of_window()};
  const float apart = distance_to({kCentre - half, kCentre + half}, watch);
  const float together = distance_to({kCentre - 0.1F * half, kCentre + 0.1F * half}, watch);
  const float again = distance_to({kCentre - half, kCentre + half}, watch);
  CHECK(apart > 0.125F);
  CHECK(together < 0.1F);
  CHECK(again == Approx(apart).epsilon(0.1));
  CHECK(outermost(watch.scope, {kCentre - half, kCentre + half}) ==
        Approx(CameraAssistant::kMargin).margin(0.03));
}

// Would catch a lens that waits for a tip to hit it.
TEST_CASE("camera assistant: it slides back from a tip that comes near, though in the middle",
          "[unit]") {
  Watch watch{scope_of_window()};
  const Eigen::Vector3f near = point_in(watch.scope, 0, 0.8F * CameraAssistant::kNearest);
  const float insertion = watch.scope.insertion();
  watch.run({near, near}, 10);
  CHECK(watch.scope.insertion() < insertion);
  CHECK(nearest(watch.scope, {near, near}) >= CameraAssistant::kNearest);
}

TEST_CASE("camera assistant: a withdrawn instrument and what is not finite are ignored", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Eigen::Vector3f tip(0.12F, 0.03F, 0.02F);
  const std::array<Eigen::Vector3f, 1> alone{tip};
  Scope scope = scope_of_window();
  REQUIRE(place_of(scope, tip) > CameraAssistant::kInnerPart);
  CameraAssistant assistant = assistant_on();
  Watch withdrawn{scope}, unknown{scope};
  for (int i = 0; i < 600; ++i) {
    assistant.follow(scope, alone, kPicture);
    withdrawn.step({tip, kCentre + Eigen::Vector3f(0, -1.01F * kScene, 0)});
    unknown.step({Eigen::Vector3f(nan, 0, 0), tip});
  }
  CHECK(place_of(scope, tip) < 0.1F);
  CHECK((tip - scope.tip()).norm() == Approx(scope.options().working_distance).epsilon(0.03));
  CHECK(same(withdrawn.scope, scope));
  CHECK(same(unknown.scope, scope));
  const Scope before = scope;
  withdrawn.assistant.follow(scope, {}, kPicture);
  CHECK(same(scope, before));
}

// Would catch a division by nothing, and a scope that turns for ever.
TEST_CASE("camera assistant: demands that cannot be met stay finite and come to rest",
          "[property]") {
  ScopeOptions narrow;
  narrow.widest_tilt = 0.2F;
  narrow.most_insertion = 0.06F;
  for (const ScopeOptions& options : {ScopeOptions{}, narrow}) {
    for (std::uint64_t trial = 0; trial < 60; ++trial) {
      // about the port, on it, behind it, and straight above
      Tips tips{kPort + random_vector(0.15F, trial, 0), kPort + random_vector(0.15F, trial, 1)};
      if (trial % 4 == 1) {
        tips[0] = tips[1] = kPort;
      } else if (trial % 4 == 2) {
        tips[0] = tips[1] = kPort + Eigen::Vector3f(0, 0, 0.1F);
      }
      Watch watch{Scope::looking_at(kPort, kCentre, options), CameraAssistant(kPort, 1)};
      watch.scope.orbit(0, 0);  // into the port's cone
      watch.assistant.switch_on(true);
      watch.run(tips, 60);
      CAPTURE(trial, options.widest_tilt);
      CHECK(watch.scope.camera().target.allFinite());
      CHECK(watch.scope.camera().up.allFinite());
      CHECK(watch.scope.insertion() >= options.least_insertion);
      CHECK(watch.scope.insertion() <= options.most_insertion);
      const Eigen::Vector3f axis = (kCentre - kPort).normalized();
      CHECK(std::acos(std::min(1.0F, watch.scope.shaft().dot(axis))) < options.widest_tilt + 1e-3F);
      const Scope end = watch.scope;
      watch.run(tips, 1);
      CHECK(same(watch.scope, end));
    }
  }
}

// Would catch a motion that goes on by itself after it was switched off, or with old speed.
TEST_CASE("camera assistant: one that is off changes nothing, and begins from rest", "[unit]") {
  Scope scope = scope_of_window();
  const Tips tips{Eigen::Vector3f(0.1F, 0.06F, 0), Eigen::Vector3f(0.09F, 0.05F, 0.01F)};
  CameraAssistant assistant(kCentre, kScene);
  CHECK_FALSE(assistant.is_on());
  const Scope start = scope;
  assistant.follow(scope, tips, kPicture);
  CHECK(same(scope, start));
  assistant.switch_on(true);
  assistant.follow(scope, tips, kPicture);
  const float first = way_between(start, scope).norm();
  REQUIRE(first > 0);
  for (int i = 0; i < 20; ++i) {
    assistant.follow(scope, tips, kPicture);
  }
  assistant.switch_on(false);
  const Scope stopped = scope;
  assistant.follow(scope, tips, kPicture);
  CHECK(same(scope, stopped));
  assistant.switch_on(true);
  assistant.follow(scope, tips, kPicture);
  CHECK(way_between(stopped, scope).norm() < 1.1F * first);
}

// Would catch a leap after a picture that took long.
TEST_CASE("camera assistant: a long step moves no more than the longest", "[unit]") {
  const Tips tips{Eigen::Vector3f(0.1F, 0.06F, 0), Eigen::Vector3f(0.09F, 0.05F, 0.01F)};
  Scope longest = scope_of_window(), longer = longest;
  assistant_on().follow(longest, tips, CameraAssistant::kLongestStep);
  assistant_on().follow(longer, tips, 60);
  CHECK_FALSE(same(longest, scope_of_window()));
  CHECK(same(longest, longer));
}

TEST_CASE("camera assistant: what it cannot work with is refused", "[unit]") {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  CHECK_THROWS_WITH(CameraAssistant({nan, 0, 0}, 1), ContainsSubstring("centre"));
  CHECK_THROWS_WITH(CameraAssistant({0, 0, 0}, 0), ContainsSubstring("radius"));
  Scope scope = scope_of_window();
  CHECK_THROWS_WITH(assistant_on().follow(scope, {}, -0.01), ContainsSubstring("step"));
  CHECK_THROWS_WITH(assistant_on().follow(scope, {}, std::nan("")), ContainsSubstring("step"));
}

}  // namespace cholecystectomy
