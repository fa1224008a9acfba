// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Who plays the sounds of the operating room.

#include <memory>
#include <string>

#include "apps/sound/sound_event.h"

namespace cholecystectomy {

/// Functions are called from one thread, as often as once a frame. None of them waits for a device
/// or throws because one is missing or lost.
class SoundPlayer {
 public:
  SoundPlayer() = default;
  SoundPlayer(const SoundPlayer&) = delete;
  SoundPlayer& operator=(const SoundPlayer&) = delete;
  virtual ~SoundPlayer() = default;

  /// What sounds from now on, until the next call. The same again changes nothing.
  virtual void set_tone(Tone tone) = 0;

  /// Sounds once, beside the tone. Left out while two chimes sound already.
  virtual void play(Chime chime) = 0;

  /// Of all sounds, 0 silent to 1; what is beyond is taken for the nearer end.
  /// @throws pbdsurg::InvalidArgument  if it is not a number
  void set_volume(float volume);

  /// A sentence for a person: which device plays, or why nothing is heard. Valid until the next
  /// call of a function of this player.
  [[nodiscard]] virtual const std::string& status() = 0;

 private:
  /// @param volume  within 0..1
  virtual void change_volume(float volume) = 0;
};

/// Plays nothing.
/// @param reason  of its status: "no sound: " and this
[[nodiscard]] std::unique_ptr<SoundPlayer> make_silent_player(const std::string& reason);

/// Has OpenAL keep its messages to itself, and not ask ALSA where it has no card, which ALSA would
/// tell in many lines on stderr; sound servers are asked all the same. What the environment has of
/// ALSOFT_LOGLEVEL and ALSOFT_DRIVERS stays. Writes these two: call it before there are threads
/// that read the environment.
void quiet_openal();

/// Plays on the default device, through OpenAL Soft and a thread of its own; a silent player where
/// there is no device, or no OpenAL in this build.
///
/// A device that is lost while it plays is noticed within a second, and the default one is looked
/// for every three seconds from then on. The tone comes back with it, chimes of the meantime do
/// not.
///
/// Waits until the device is open, up to seconds where a sound server does not answer. Calls
/// quiet_openal() first.
[[nodiscard]] std::unique_ptr<SoundPlayer> make_player();

}  // namespace cholecystectomy
