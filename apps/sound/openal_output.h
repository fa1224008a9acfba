// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A device of OpenAL Soft. Only builds that have OpenAL see this file.

#include <array>
#include <cstddef>
#include <memory>
#include <string>

#include <AL/al.h>
#include <AL/alc.h>

#include "apps/sound/audio_output.h"

namespace cholecystectomy {

/// Tones rise and fall within their samples, so that neither switching nor the time at which a
/// device is served makes a click. A tone that is switched off plays its loop to the end, then
/// falls: 60 ms at most. OpenAL mixes on a thread of its own, with what it was told last.
class OpenAlOutput final : public AudioOutput {
 public:
  /// Opens the default device.
  /// @throws pbdsurg::BackendUnavailable  where there is none, or OpenAL lacks what this needs
  OpenAlOutput();

  /// @param device      becomes this object's
  /// @param attributes  of its context, ended by a zero; or null
  /// @throws pbdsurg::BackendUnavailable  where OpenAL lacks what this needs
  OpenAlOutput(ALCdevice* device, const ALCint* attributes);

  ~OpenAlOutput() override;

  [[nodiscard]] const std::string& device_name() const override { return device_name_; }
  [[nodiscard]] bool is_connected() override;
  void set_volume(float volume) override;
  [[nodiscard]] bool set_tone(Tone tone) override;
  void play(Chime chime) override;

 private:
  struct CloseDevice {
    void operator()(ALCdevice* device) const;
  };
  struct DestroyContext {
    void operator()(ALCcontext* context) const;
  };
  struct ToneSource {
    Tone tone = Tone::none;
    ALuint buffer = 0;
    ALuint source = 0;
    bool is_held = false;  ///< repeats its loop
  };

  void make_context(const ALCint* attributes);
  void make_sources();

  std::unique_ptr<ALCdevice, CloseDevice> device_;
  std::unique_ptr<ALCcontext, DestroyContext> context_;
  std::string device_name_;
  std::array<ToneSource, kToneCount - 1> tones_{};
  std::array<ALuint, kChimeCount> chimes_{};  ///< buffers
  std::array<ALuint, 2> voices_{};            ///< sources of chimes
};

}  // namespace cholecystectomy
