// SPDX-License-Identifier: Apache-2.0
// OpenAL reads ALSOFT_DRIVERS once, so each case is a process of its own: ctest sets the variable.
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>

#include "apps/sound/player.h"
#include "tests/support/catch.h"
#include "tests/support/skip.h"

namespace cholecystectomy {
namespace {

bool has_drivers(const std::string& drivers) {
  const char* const set = std::getenv("ALSOFT_DRIVERS");
  if (set != nullptr && set == drivers) {
    return true;
  }
  pbdsurg::testing::skip("needs ALSOFT_DRIVERS=" + drivers + ", which ctest sets");
  return false;
}

}  // namespace

// Catches a player that does not open a device that is there, or loses it by itself.
TEST_CASE("player: plays on the device that opens, and names it", "[unit][null_driver]") {
  if (!has_drivers("null")) {
    return;
  }
  const std::unique_ptr<SoundPlayer> player = make_player();
  // the null driver's name, to which newer versions of OpenAL Soft add words
  const auto names_device = pbdsurg::testing::ContainsSubstring("No Output");
  CHECK_THAT(player->status(), names_device);
  player->set_volume(0.5f);
  for (const Tone tone : {Tone::cut, Tone::coagulation, Tone::cut, Tone::none}) {
    player->set_tone(tone);
    player->play(Chime::warning);
    player->play(Chime::refused);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
  }
  CHECK_THAT(player->status(), names_device);  // after a look at it
  CHECK(player->status().rfind("sound: ", 0) == 0);
}

// Catches an exception, or a status that does not say what is missing.
TEST_CASE("player: a machine without a device gets silence and the reason", "[unit][no_driver]") {
  if (!has_drivers("nonexistent")) {
    return;
  }
  const std::unique_ptr<SoundPlayer> player = make_player();
  CHECK(player->status() ==
        "no sound: no audio device; OpenAL could open none with ALSOFT_DRIVERS=nonexistent");
  player->set_tone(Tone::cut);
  player->play(Chime::refused);
  player->set_volume(1);
}

}  // namespace cholecystectomy
