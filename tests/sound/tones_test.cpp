// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/tones.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <span>

#include "tests/sound/spectrum.h"
#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

static_assert(4 * kPeakSample <= std::numeric_limits<std::int16_t>::max());

std::span<const std::int16_t> loop_of(const ToneSamples& sound) {
  return std::span(sound.samples).subspan(sound.loop_begin, sound.loop_end - sound.loop_begin);
}

/// The loop, `count` times.
Samples repeated(std::span<const std::int16_t> loop, int count) {
  Samples samples;
  for (int i = 0; i < count; ++i) {
    samples.insert(samples.end(), loop.begin(), loop.end());
  }
  return samples;
}

int peak_of(std::span<const std::int16_t> samples) {
  int peak = 0;
  for (const std::int16_t sample : samples) {
    peak = std::max(peak, std::abs(static_cast<int>(sample)));
  }
  return peak;
}

/// Three times the bend of a pure tone of full level at its crest: overtones and the envelope.
double allowed_bend(double pitch) {
  const double step = 2 * std::numbers::pi * pitch / kSampleRate;
  return 3 * kPeakSample * step * step;
}

}  // namespace

// Catches a loop that is no whole number of periods, even by one sample: it would click or buzz at
// each repetition.
TEST_CASE("tones: a loop goes on from its last sample as the wave does", "[unit]") {
  const Tone tone = GENERATE(Tone::cut, Tone::coagulation);
  const ToneSamples sound = make_tone(tone);
  REQUIRE(sound.loop_end + 4 < sound.samples.size());
  REQUIRE(sound.loop_begin + 4 < sound.loop_end);

  const std::span<const std::int16_t> loop = loop_of(sound);
  CHECK(loop.size() * static_cast<std::size_t>(pitch_of(tone)) % kSampleRate == 0);  // periods
  // what follows the last sample, when not repeated, is what the repetition brings
  for (std::size_t i = 0; i < 4; ++i) {
    INFO("sample " << i);
    CHECK(std::abs(sound.samples[sound.loop_end + i] - sound.samples[sound.loop_begin + i]) <= 1);
  }
  const double within = sharpest_bend(loop);
  CHECK(sharpest_bend<std::int16_t>(repeated(loop, 2)) <= within + 4);  // rounding
  CHECK(sharpest_bend<std::int16_t>(repeated(loop.first(loop.size() - 20), 2)) > 2 * within);
}

// Catches an envelope that jumps: all of a tone, rise and fall with it, bends no more than its
// wave.
TEST_CASE("tones: a tone rises from silence and falls to it without a click", "[unit]") {
  const Tone tone = GENERATE(Tone::cut, Tone::coagulation);
  Samples samples = make_tone(tone).samples;
  CHECK(samples.front() == 0);
  CHECK(samples.back() == 0);
  samples.insert(samples.begin(), 2, 0);
  samples.insert(samples.end(), 2, 0);
  CHECK(sharpest_bend<std::int16_t>(samples) < allowed_bend(pitch_of(tone)));
}

// Catches a wrong sample rate or period, an overtone that is stronger than the fundamental, and
// tones that were exchanged or are too close for an ear: a third is a quarter more.
TEST_CASE("tones: cut and coagulation have their pitches, coagulation the lower", "[unit]") {
  const auto heard = [](Tone tone) {
    return dominant_frequency<std::int16_t>(repeated(loop_of(make_tone(tone)), 12));
  };
  CHECK(heard(Tone::cut) == pitch_of(Tone::cut));
  CHECK(heard(Tone::coagulation) == pitch_of(Tone::coagulation));
  CHECK(heard(Tone::cut) > 1.25 * heard(Tone::coagulation));
}

// Catches samples that wrap or clip, and ones that nobody hears.
TEST_CASE("tones: no sound is louder than its share or hardly there", "[unit]") {
  for (const Tone tone : {Tone::cut, Tone::coagulation}) {
    const int peak = peak_of(make_tone(tone).samples);
    CHECK(peak <= kPeakSample);
    CHECK(peak > kPeakSample / 2);
  }
  for (std::size_t i = 0; i < kChimeCount; ++i) {
    const int peak = peak_of(make_chime(static_cast<Chime>(i)));
    CHECK(peak <= kPeakSample);
    CHECK(peak > kPeakSample / 2);
  }
}

// Catches a tone of the inactive generator.
TEST_CASE("tones: no tone has no samples", "[unit]") {
  CHECK(make_tone(Tone::none).samples.empty());
  CHECK(pitch_of(Tone::none) == 0);
}

// Catches a chime that starts or ends within its wave, or a note of it that does.
TEST_CASE("tones: chimes begin and end with silence and do not click", "[unit]") {
  for (std::size_t i = 0; i < kChimeCount; ++i) {
    const Samples samples = make_chime(static_cast<Chime>(i));
    INFO(name_of(static_cast<Chime>(i)));
    REQUIRE(samples.size() > kSampleRate / 10);
    CHECK(samples.size() <= kSampleRate / 2);
    CHECK(samples.front() == 0);
    CHECK(samples.back() == 0);
    const std::span<const std::int16_t> all(samples);
    CHECK(peak_of(all.first(kSampleRate / 1000)) < kPeakSample / 5);
    CHECK(peak_of(all.last(kSampleRate / 1000)) < kPeakSample / 5);
    CHECK(sharpest_bend(all) < allowed_bend(1175));
  }
}

// Catches chimes that sound like each other or like a tone that goes on.
TEST_CASE("tones: chimes differ in pitch from each other and from tones", "[unit]") {
  const double refused = dominant_frequency<std::int16_t>(make_chime(Chime::refused));
  const double warning = dominant_frequency<std::int16_t>(make_chime(Chime::warning));
  CHECK(refused < 0.8 * pitch_of(Tone::coagulation));
  CHECK(warning > 1.25 * pitch_of(Tone::cut));
}

}  // namespace cholecystectomy
