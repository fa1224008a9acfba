// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Sounds as a list, for tests and for who writes down what was heard when.

#include <string>
#include <utility>
#include <vector>

#include "apps/sound/player.h"

namespace cholecystectomy {

/// Plays nothing and keeps what it was asked for, in order. A tone is an event when it changes.
class RecordingPlayer final : public SoundPlayer {
 public:
  void set_tone(Tone tone) override {
    if (tone != tone_) {
      events_.emplace_back(tone);
      tone_ = tone;
    }
  }

  void play(Chime chime) override { events_.emplace_back(chime); }

  [[nodiscard]] const std::string& status() override { return status_; }

  [[nodiscard]] Tone tone() const noexcept { return tone_; }
  [[nodiscard]] float volume() const noexcept { return volume_; }  ///< 0..1

  /// What came since the last call, oldest first. A recorder calls it once a frame and so knows
  /// when each came.
  [[nodiscard]] std::vector<SoundEvent> take_events() { return std::exchange(events_, {}); }

 private:
  void change_volume(float volume) override { volume_ = volume; }

  std::vector<SoundEvent> events_;
  Tone tone_ = Tone::none;
  float volume_ = 1;
  std::string status_ = "no sound: it is recorded";
};

}  // namespace cholecystectomy
