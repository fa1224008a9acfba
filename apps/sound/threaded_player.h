// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A player whose device may be slow or go away.

#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "apps/sound/audio_output.h"
#include "apps/sound/player.h"

namespace cholecystectomy {

/// Opens a device. Throws, with the reason for a person, where that fails.
using OpenOutput = std::function<std::unique_ptr<AudioOutput>()>;

/// How often a ThreadedPlayer looks after its device.
struct PlayerTiming {
  std::chrono::milliseconds check{1000};   ///< whether the device is still there
  std::chrono::milliseconds reopen{3000};  ///< after a loss, for one that can be opened
  std::chrono::milliseconds retry{5};      ///< for a tone whose last fall is not over
};

/// Only a thread of its own touches the device. Callers leave word for it and go on.
class ThreadedPlayer final : public SoundPlayer {
 public:
  /// Waits until the device is open.
  /// @throws  what `open` throws
  explicit ThreadedPlayer(OpenOutput open, const PlayerTiming& timing = {});

  /// Waits for a device that is being opened.
  ~ThreadedPlayer() override;

  void set_tone(Tone tone) override;
  void play(Chime chime) override;
  [[nodiscard]] const std::string& status() override;

 private:
  using Clock = std::chrono::steady_clock;

  struct Wishes {
    Tone tone = Tone::none;
    float volume = 1;
    std::vector<Chime> chimes{};  ///< not yet played, oldest first
  };

  void change_volume(float volume) override;
  [[nodiscard]] std::unique_ptr<AudioOutput> open_first() noexcept;
  void run(std::unique_ptr<AudioOutput> output);
  [[nodiscard]] std::unique_ptr<AudioOutput> reopen() const noexcept;
  [[nodiscard]] bool wait(Clock::time_point until, Wishes& wishes);
  void set_status(std::string status);

  const OpenOutput open_;
  const PlayerTiming timing_;
  std::string shown_status_;  ///< the caller's

  std::mutex mutex_;  ///< of what follows; nobody holds it for longer than a copy takes
  std::condition_variable has_opened_;
  bool is_open_ = false;
  std::exception_ptr refusal_;  ///< why the device is not open
  std::condition_variable has_changed_;
  Wishes wishes_;
  std::string status_;
  bool has_news_ = false;  ///< wishes that the thread has not seen
  bool is_ending_ = false;

  std::thread thread_;
};

}  // namespace cholecystectomy
