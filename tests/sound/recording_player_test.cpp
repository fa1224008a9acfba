// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/recording_player.h"

#include <vector>

#include "tests/support/catch.h"

namespace cholecystectomy {

// Catches tones and chimes kept in lists of their own, and a tone that is noted once a frame.
TEST_CASE("recording player: keeps changes of the tone and chimes in order", "[unit]") {
  RecordingPlayer player;
  player.set_tone(Tone::none);  // as it was
  player.set_tone(Tone::cut);
  player.set_tone(Tone::cut);
  player.play(Chime::warning);
  player.play(Chime::warning);
  player.set_tone(Tone::coagulation);
  player.play(Chime::refused);
  player.set_tone(Tone::none);

  CHECK(player.take_events() == std::vector<SoundEvent>{Tone::cut, Chime::warning, Chime::warning,
                                                        Tone::coagulation, Chime::refused,
                                                        Tone::none});
}

// Catches events that are given twice, and a tone that is forgotten with them.
TEST_CASE("recording player: gives each event once", "[unit]") {
  RecordingPlayer player;
  player.set_tone(Tone::cut);
  CHECK(player.take_events().size() == 1);
  CHECK(player.take_events().empty());
  player.set_tone(Tone::cut);
  CHECK(player.take_events().empty());
  CHECK(player.tone() == Tone::cut);
  CHECK_FALSE(player.status().empty());
}

}  // namespace cholecystectomy
