// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/tones.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

namespace cholecystectomy {
namespace {

constexpr std::size_t kRise = kSampleRate / 100;  // samples, 10 ms

/// Strengths of the fundamental, its octave and the twelfth above. They add up to one at most, so
/// that no phase of theirs goes beyond one.
using Timbre = std::array<double, 3>;
constexpr Timbre kSoft{0.8, 0.15, 0.05};
constexpr Timbre kFull{0.6, 0.25, 0.15};

/// @param turns  periods of the fundamental since zero
/// @return       within -1..1
double wave(const Timbre& timbre, double turns) {
  double sum = 0;
  for (std::size_t i = 0; i < timbre.size(); ++i) {
    sum += timbre[i] * std::sin(2 * std::numbers::pi * static_cast<double>(i + 1) * turns);
  }
  return sum;
}

/// From 0 to 1 with no slope at either end.
double smooth(double x) {
  return 0.5 - 0.5 * std::cos(std::numbers::pi * std::clamp(x, 0.0, 1.0));
}

std::int16_t sample_of(double value) {
  return static_cast<std::int16_t>(std::lround(kPeakSample * value));
}

/// Adds a note to a chime. It swells for 5 ms, then fades until its end.
/// @param pitch  Hz
void add_note(Samples& samples, const Timbre& timbre, int pitch, double duration) {
  const auto count = static_cast<std::size_t>(duration * kSampleRate);
  const std::size_t swell = kSampleRate / 200;
  for (std::size_t i = 0; i < count; ++i) {
    const auto at = static_cast<double>(i);
    const auto last = static_cast<double>(count - 1);
    const double rise = smooth(at / static_cast<double>(swell));
    const double fall = smooth((last - at) / (0.6 * last));
    samples.push_back(sample_of(rise * fall * wave(timbre, at * pitch / kSampleRate)));
  }
}

void add_pause(Samples& samples, double duration) {
  samples.resize(samples.size() + static_cast<std::size_t>(duration * kSampleRate));
}

}  // namespace

int pitch_of(Tone tone) noexcept {
  switch (tone) {
    case Tone::cut:
      return 660;
    case Tone::coagulation:
      return 440;
    case Tone::none:
      break;
  }
  return 0;
}

ToneSamples make_tone(Tone tone) {
  const int pitch = pitch_of(tone);
  if (pitch == 0) {
    return {};
  }
  const Timbre& timbre = tone == Tone::cut ? kSoft : kFull;
  // the fewest whole periods that are a whole number of samples
  const int periods = pitch / std::gcd(pitch, kSampleRate);
  const auto loop = static_cast<std::size_t>(kSampleRate / std::gcd(pitch, kSampleRate));

  ToneSamples sound;
  sound.loop_begin = kRise;
  sound.loop_end = kRise + loop;
  const std::size_t count = sound.loop_end + kRise;
  sound.samples.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double rise = smooth(static_cast<double>(i) / kRise);
    const double fall = smooth(static_cast<double>(count - 1 - i) / (kRise - 1));
    // by the place within the loop, so that each repetition has the same bits
    const double turns = static_cast<double>(i % loop) * periods / static_cast<double>(loop);
    sound.samples.push_back(sample_of(rise * fall * wave(timbre, turns)));
  }
  return sound;
}

Samples make_chime(Chime chime) {
  Samples samples;
  switch (chime) {
    case Chime::refused:  // twice the same, low
      add_note(samples, kFull, 220, 0.12);
      add_pause(samples, 0.04);
      add_note(samples, kFull, 220, 0.2);
      break;
    case Chime::warning:  // upwards, high
      add_note(samples, kSoft, 880, 0.15);
      add_note(samples, kSoft, 1175, 0.3);
      break;
  }
  return samples;
}

}  // namespace cholecystectomy
