// SPDX-License-Identifier: Apache-2.0
// The device is a fake, so these run on machines without one.
#include "apps/sound/threaded_player.h"

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "tests/support/catch.h"

namespace cholecystectomy {
namespace {

using std::chrono::milliseconds;

constexpr PlayerTiming kFast{milliseconds(2), milliseconds(4), milliseconds(1)};

/// Only calls and retries wake the thread.
constexpr PlayerTiming kAsleep{std::chrono::hours(1), std::chrono::hours(1), milliseconds(1)};

/// What fake devices of one test share with it.
struct Studio {
  std::atomic<bool> is_plugged = true;
  std::atomic<int> opened = 0;
  std::atomic<int> busy_tones = 0;  ///< how often the next tone is put off
  std::atomic<float> volume = -1;
  std::atomic<milliseconds::rep> opening_takes = 0;  // ms

  void note(SoundEvent event) {
    const std::lock_guard lock(mutex_);
    events_.push_back(event);
  }
  [[nodiscard]] std::vector<SoundEvent> events() {
    const std::lock_guard lock(mutex_);
    return events_;
  }

 private:
  std::mutex mutex_;
  std::vector<SoundEvent> events_;
};

class FakeOutput final : public AudioOutput {
 public:
  explicit FakeOutput(Studio& studio)
      : studio_(studio),
        name_("fake " + std::to_string(++studio.opened)),
        thread_(std::this_thread::get_id()) {}
  ~FakeOutput() override { check_thread(); }

  [[nodiscard]] const std::string& device_name() const override { return name_; }
  [[nodiscard]] bool is_connected() override {
    check_thread();
    return studio_.is_plugged;
  }
  void set_volume(float volume) override {
    check_thread();
    studio_.volume = volume;
  }
  [[nodiscard]] bool set_tone(Tone tone) override {
    check_thread();
    if (tone != tone_) {
      if (studio_.busy_tones > 0) {
        --studio_.busy_tones;
        return false;
      }
      studio_.note(tone);
      tone_ = tone;
    }
    return true;
  }
  void play(Chime chime) override {
    check_thread();
    studio_.note(chime);
  }

 private:
  // Catch2 counts from one thread only
  void check_thread() const {
    if (std::this_thread::get_id() != thread_) {
      std::terminate();
    }
  }

  Studio& studio_;
  std::string name_;
  Tone tone_ = Tone::none;
  std::thread::id thread_;
};

OpenOutput opener(Studio& studio) {
  return [&studio]() -> std::unique_ptr<AudioOutput> {
    std::this_thread::sleep_for(milliseconds(studio.opening_takes));
    if (!studio.is_plugged) {
      throw pbdsurg::BackendUnavailable("no audio device");
    }
    return std::make_unique<FakeOutput>(studio);
  };
}

/// Waits until something holds, for far longer than it should take.
bool eventually(const std::function<bool()>& holds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > end) {
      return false;
    }
    std::this_thread::sleep_for(milliseconds(1));
  }
  return true;
}

}  // namespace

// Catches lost or exchanged calls on the way to the thread, and a volume that stays there.
TEST_CASE("threaded player: what is asked for reaches the device in order", "[unit]") {
  Studio studio;
  ThreadedPlayer player(opener(studio), kAsleep);
  CHECK(player.status() == "sound: fake 1");

  std::vector<SoundEvent> expected;
  const auto ask = [&](SoundEvent event) {
    std::holds_alternative<Tone>(event) ? player.set_tone(std::get<Tone>(event))
                                        : player.play(std::get<Chime>(event));
    expected.push_back(event);
    return eventually([&] { return studio.events() == expected; });
  };
  CHECK(ask(Tone::cut));
  CHECK(ask(Chime::warning));
  CHECK(ask(Chime::refused));
  CHECK(ask(Tone::coagulation));
  CHECK(ask(Tone::none));
  player.set_volume(0.25f);
  CHECK(eventually([&] { return studio.volume == 0.25f; }));
  CHECK(studio.events() == expected);
}

// Catches a tone that is dropped because its last fall was not over when it was asked for.
TEST_CASE("threaded player: a tone that the device puts off is asked for again", "[unit]") {
  Studio studio;
  studio.busy_tones = 3;
  ThreadedPlayer player(opener(studio), kAsleep);
  player.set_tone(Tone::cut);
  CHECK(eventually([&] { return studio.events() == std::vector<SoundEvent>{Tone::cut}; }));
  CHECK(studio.busy_tones == 0);
}

// Catches a constructor that hides why there is no device, and a thread that is left behind.
TEST_CASE("threaded player: the first opening's failure is the caller's", "[unit]") {
  Studio studio;
  studio.is_plugged = false;
  CHECK_THROWS_WITH(ThreadedPlayer(opener(studio), kFast), "no audio device");
}

// Catches a loss that nobody notices or says, a player that gives up, a tone that does not come
// back while the pedal is down, and old chimes that sound when the device is back.
TEST_CASE("threaded player: a lost device is noticed, said and replaced", "[unit]") {
  Studio studio;
  ThreadedPlayer player(opener(studio), kFast);
  player.set_volume(0.5f);
  player.set_tone(Tone::cut);
  REQUIRE(eventually([&] { return studio.events().size() == 1; }));

  studio.is_plugged = false;
  CHECK(eventually([&] {
    return player.status() == "no sound: the device 'fake 1' was lost; another is looked for";
  }));
  player.play(Chime::warning);
  player.set_tone(Tone::coagulation);
  std::this_thread::sleep_for(milliseconds(20));  // some attempts
  CHECK(studio.events().size() == 1);
  studio.volume = -1;

  studio.is_plugged = true;
  CHECK(eventually([&] { return player.status() == "sound: fake 2"; }));
  CHECK(eventually([&] {
    return studio.events() == std::vector<SoundEvent>{Tone::cut, Tone::coagulation};
  }));
  CHECK(studio.volume == 0.5f);
}

// Catches a call that waits for the device: opening takes 400 ms here, a thousand calls a fraction.
TEST_CASE("threaded player: callers do not wait while a device is opened", "[unit]") {
  Studio studio;
  ThreadedPlayer player(opener(studio), kFast);
  studio.opening_takes = 400;
  studio.is_plugged = false;
  REQUIRE(eventually([&] { return player.status() != "sound: fake 1"; }));
  std::this_thread::sleep_for(milliseconds(20));  // into the opening

  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < 1000; ++i) {
    player.set_tone(i % 2 == 0 ? Tone::cut : Tone::none);
    player.play(Chime::refused);
    player.set_volume(0.001f * static_cast<float>(i));
    CHECK_FALSE(player.status().empty());
  }
  CHECK(std::chrono::steady_clock::now() - start < milliseconds(200));
}

}  // namespace cholecystectomy
