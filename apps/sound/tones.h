// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The sounds as samples: 16 bit, one channel, kSampleRate of them a second. The same call gives
/// the same samples.
///
/// IEC 60601-2-2 asks of a generator that it can be heard while active, and that cutting and
/// coagulation can be told apart. Pitches are ours; no standard gives any.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "apps/sound/sound_event.h"

namespace cholecystectomy {

inline constexpr int kSampleRate = 44100;  ///< 1/s

/// No sample of any sound is farther from zero, of 32767: two tones, one falling while the next
/// rises, and two chimes add up to less than full scale.
inline constexpr int kPeakSample = 8191;

using Samples = std::vector<std::int16_t>;

/// A tone that lasts for as long as its middle is repeated. It begins and ends with silence.
struct ToneSamples {
  Samples samples;           ///< its rise, whole periods, its fall
  std::size_t loop_begin{};  ///< the first sample of the whole periods
  std::size_t loop_end{};    ///< the one after their last
};

/// Of the fundamental, Hz.
/// @return  0 for Tone::none
[[nodiscard]] int pitch_of(Tone tone) noexcept;

/// @return  empty for Tone::none
[[nodiscard]] ToneSamples make_tone(Tone tone);

/// Half a second or less, from silence to silence.
[[nodiscard]] Samples make_chime(Chime chime);

}  // namespace cholecystectomy
