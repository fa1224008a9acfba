// SPDX-License-Identifier: Apache-2.0
// OpenAL mixes into memory here, so these hear what a device would, without one.
#include "apps/sound/openal_output.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <numbers>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include <AL/alext.h>

#include "apps/sound/tones.h"
#include "tests/sound/spectrum.h"
#include "tests/support/catch.h"
#include "tests/support/skip.h"

namespace cholecystectomy {
namespace {

/// An output whose sound is taken in blocks.
class Loopback {
 public:
  Loopback()
      : open_(reinterpret_cast<LPALCLOOPBACKOPENDEVICESOFT>(
            alcGetProcAddress(nullptr, "alcLoopbackOpenDeviceSOFT"))),
        render_(reinterpret_cast<LPALCRENDERSAMPLESSOFT>(
            alcGetProcAddress(nullptr, "alcRenderSamplesSOFT"))) {
    device_ = open_ != nullptr && render_ != nullptr ? open_(nullptr) : nullptr;
    if (device_ != nullptr) {
      const std::array<ALCint, 7> attributes{ALC_FORMAT_CHANNELS_SOFT,
                                             ALC_MONO_SOFT,
                                             ALC_FORMAT_TYPE_SOFT,
                                             ALC_FLOAT_SOFT,
                                             ALC_FREQUENCY,
                                             kSampleRate,
                                             0};
      output_ = std::make_unique<OpenAlOutput>(device_, attributes.data());
    }
  }

  [[nodiscard]] bool is_there() const { return output_ != nullptr; }
  [[nodiscard]] OpenAlOutput& output() { return *output_; }

  /// Of the next samples; all of them stay in heard().
  std::span<const float> render(double seconds) {
    const auto count = static_cast<std::size_t>(seconds * kSampleRate);
    const std::size_t before = heard_.size();
    heard_.resize(before + count);
    render_(device_, heard_.data() + before, static_cast<ALCsizei>(count));
    return std::span<const float>(heard_).subspan(before);
  }
  [[nodiscard]] std::span<const float> heard() const { return heard_; }

 private:
  LPALCLOOPBACKOPENDEVICESOFT open_;
  LPALCRENDERSAMPLESSOFT render_;
  ALCdevice* device_ = nullptr;
  std::unique_ptr<OpenAlOutput> output_;
  std::vector<float> heard_;
};

#define REQUIRE_LOOPBACK(name)                                      \
  Loopback name;                                                    \
  if (!name.is_there()) {                                           \
    pbdsurg::testing::skip("this OpenAL has no ALC_SOFT_loopback"); \
    return;                                                         \
  }

double peak_of(std::span<const float> samples) {
  double peak = 0;
  for (const float sample : samples) {
    peak = std::max(peak, std::abs(static_cast<double>(sample)));
  }
  return peak;
}

}  // namespace

// Catches a tone that ends with its samples, loops over its rise, or is the other one.
TEST_CASE("OpenAL output: a tone goes on at its pitch for as long as it is wanted",
          "[unit][openal]") {
  const Tone tone = GENERATE(Tone::cut, Tone::coagulation);
  REQUIRE_LOOPBACK(loopback);
  CHECK(loopback.output().set_tone(tone));
  loopback.render(0.2);
  const double early = peak_of(loopback.render(0.1));
  CHECK(early > 0.05);
  loopback.render(1);
  CHECK(dominant_frequency(loopback.render(0.1)) == pitch_of(tone));
  for (int i = 0; i < 5; ++i) {  // no fading, no gaps
    CHECK(peak_of(loopback.render(0.01)) == pbdsurg::testing::Approx(early).epsilon(0.05));
  }
}

// Catches a tone that goes on, or that takes longer to end than its loop and fall.
TEST_CASE("OpenAL output: a tone that is not wanted any more ends within 70 ms", "[unit][openal]") {
  const Tone tone = GENERATE(Tone::cut, Tone::coagulation);
  REQUIRE_LOOPBACK(loopback);
  CHECK(peak_of(loopback.render(0.1)) == 0);
  CHECK(loopback.output().set_tone(tone));
  loopback.render(0.333);
  CHECK(loopback.output().set_tone(Tone::none));
  loopback.render(0.07);
  CHECK(peak_of(loopback.render(0.2)) < 1e-6);
}

// Catches clicks: sources that are stopped within their wave, gains that jump, seams of the loop.
// Switching falls on all phases of the waves.
TEST_CASE("OpenAL output: switching tones does not click", "[unit][openal]") {
  REQUIRE_LOOPBACK(loopback);
  CHECK(loopback.output().set_tone(Tone::cut));
  loopback.render(0.5);
  const double steady = sharpest_bend(loopback.heard());
  REQUIRE(steady > 0);

  Tone wanted = Tone::cut;
  for (int i = 0; i < 300; ++i) {
    wanted = static_cast<Tone>((static_cast<int>(wanted) + 1 + i % 2) % 3);
    while (!loopback.output().set_tone(wanted)) {
      loopback.render(0.005);
    }
    loopback.render(0.0131 + 0.0007 * (i % 13));
  }
  CHECK(sharpest_bend(loopback.heard()) < 2.5 * steady);  // two at once, and the envelope
  CHECK(peak_of(loopback.heard()) < 1);
}

// Catches a chime that is cut off by the next, that repeats, or that silences the tone.
TEST_CASE("OpenAL output: chimes sound once, beside each other and the tone", "[unit][openal]") {
  REQUIRE_LOOPBACK(loopback);
  OpenAlOutput& output = loopback.output();
  output.play(Chime::warning);
  loopback.render(0.02);
  output.play(Chime::refused);
  output.play(Chime::refused);  // a third that finds no room
  const double alone = peak_of(loopback.render(0.1));
  CHECK(alone > 0.05);
  loopback.render(0.5);
  CHECK(peak_of(loopback.render(0.3)) < 1e-6);

  CHECK(output.set_tone(Tone::coagulation));
  loopback.render(0.2);
  output.play(Chime::warning);
  loopback.render(0.02);
  const std::span<const float> both = loopback.render(0.1);
  CHECK(amplitude_at(both, 440) > 0.05);
  CHECK(amplitude_at(both, 880) > 0.05);
  loopback.render(0.5);
  CHECK(dominant_frequency(loopback.render(0.1)) == 440);

  const double pure = 0.25 * std::pow(2 * std::numbers::pi * 1175 / kSampleRate, 2);
  CHECK(sharpest_bend(loopback.heard()) < 2 * pure);
}

// Catches a volume that only new sounds have, and one that is no factor.
TEST_CASE("OpenAL output: the volume holds for what sounds already", "[unit][openal]") {
  REQUIRE_LOOPBACK(loopback);
  OpenAlOutput& output = loopback.output();
  CHECK(output.set_tone(Tone::cut));
  loopback.render(0.2);
  const double full = peak_of(loopback.render(0.1));
  output.set_volume(0.5f);
  loopback.render(0.1);
  CHECK(peak_of(loopback.render(0.1)) == pbdsurg::testing::Approx(full / 2).epsilon(0.02));
  output.set_volume(0);
  loopback.render(0.1);
  CHECK(peak_of(loopback.render(0.1)) < 1e-4);
  output.set_volume(1);
  loopback.render(0.1);
  CHECK(peak_of(loopback.render(0.1)) == pbdsurg::testing::Approx(full).epsilon(0.02));
}

// Catches a context that is bound to the process: what another thread makes and ends would take the
// sound of this one away.
TEST_CASE("OpenAL output: one of another thread leaves this one alone", "[unit][openal]") {
  REQUIRE_LOOPBACK(loopback);
  double other_peak = 0;
  std::thread([&] {
    Loopback other;
    static_cast<void>(other.output().set_tone(Tone::cut));
    other_peak = peak_of(other.render(0.1));
  }).join();
  CHECK(loopback.output().set_tone(Tone::coagulation));
  loopback.render(0.1);
  CHECK(dominant_frequency(loopback.render(0.1)) == pitch_of(Tone::coagulation));
  CHECK(other_peak > 0.05);
}

// Catches a device that reads as lost from the start.
TEST_CASE("OpenAL output: a device that is there is connected and has a name", "[unit][openal]") {
  REQUIRE_LOOPBACK(loopback);
  CHECK(loopback.output().is_connected());
  CHECK_FALSE(loopback.output().device_name().empty());
}

}  // namespace cholecystectomy
