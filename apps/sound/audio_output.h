// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device that sounds come out of, for as long as it is there.

#include <string>

#include "apps/sound/sound_event.h"

namespace cholecystectomy {

/// Made, used and destroyed by one thread. Its functions may take milliseconds.
class AudioOutput {
 public:
  AudioOutput() = default;
  AudioOutput(const AudioOutput&) = delete;
  AudioOutput& operator=(const AudioOutput&) = delete;
  virtual ~AudioOutput() = default;

  /// For a person.
  [[nodiscard]] virtual const std::string& device_name() const = 0;

  /// Whether the device is still there. One that is gone does not come back.
  [[nodiscard]] virtual bool is_connected() = 0;

  /// @param volume  within 0..1
  virtual void set_volume(float volume) = 0;

  /// Lets a tone rise and the other fall.
  /// @return  whether that is under way; else the tone's last fall is not over yet, and the same is
  ///          to be asked for again
  [[nodiscard]] virtual bool set_tone(Tone tone) = 0;

  /// Sounds once, unless too many chimes sound already.
  virtual void play(Chime chime) = 0;
};

}  // namespace cholecystectomy
