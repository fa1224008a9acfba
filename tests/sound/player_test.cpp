// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/player.h"

#include <limits>

#include "apps/sound/recording_player.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"

namespace cholecystectomy {

// Catches a gain beyond one, which would clip, and a negative one, which OpenAL ignores.
TEST_CASE("player: a volume beyond its range is taken for the nearer end", "[unit]") {
  RecordingPlayer player;
  const auto volume_after = [&](float volume) {
    player.set_volume(volume);
    return player.volume();
  };
  CHECK(volume_after(0.25f) == 0.25f);
  CHECK(volume_after(-1) == 0);
  CHECK(volume_after(7) == 1);
  CHECK(volume_after(-std::numeric_limits<float>::infinity()) == 0);
  CHECK(volume_after(std::numeric_limits<float>::infinity()) == 1);
}

// Catches a comparison that lets NaN through to the device, and one that changes the volume first.
TEST_CASE("player: a volume that is not a number is refused", "[unit]") {
  RecordingPlayer player;
  player.set_volume(0.5f);
  pbdsurg::testing::check_refused(
      [&] { player.set_volume(std::numeric_limits<float>::quiet_NaN()); }, "nan");
  CHECK(player.volume() == 0.5f);
}

// Catches a silent player that does not say why, or fails where a playing one would not.
TEST_CASE("player: a silent one says why and takes all calls", "[unit]") {
  const std::unique_ptr<SoundPlayer> player = make_silent_player("it was switched off");
  player->set_tone(Tone::cut);
  player->play(Chime::warning);
  player->set_volume(0.5f);
  CHECK(player->status() == "no sound: it was switched off");
  CHECK_THROWS(player->set_volume(std::numeric_limits<float>::quiet_NaN()));
}

#if !defined(PBDSURG_HAS_OPENAL)
// Catches a build without OpenAL that blames the machine.
TEST_CASE("player: a build without OpenAL says so", "[unit]") {
  CHECK(make_player()->status() == "no sound: built without OpenAL");
}
#endif

}  // namespace cholecystectomy
