// SPDX-License-Identifier: Apache-2.0
#include "apps/sound/threaded_player.h"

#include <algorithm>
#include <cstddef>
#include <exception>
#include <utility>

namespace cholecystectomy {
namespace {

constexpr std::size_t kMostChimes = 4;  // that may wait

}  // namespace

ThreadedPlayer::ThreadedPlayer(OpenOutput open, const PlayerTiming& timing)
    : open_(std::move(open)), timing_(timing) {
  wishes_.chimes.reserve(kMostChimes);
  thread_ = std::thread([this] {
    std::unique_ptr<AudioOutput> output = open_first();
    if (output != nullptr) {
      run(std::move(output));
    }
  });
  std::unique_lock lock(mutex_);
  has_opened_.wait(lock, [this] { return is_open_ || refusal_ != nullptr; });
  if (refusal_ != nullptr) {
    lock.unlock();
    thread_.join();
    std::rethrow_exception(refusal_);
  }
}

ThreadedPlayer::~ThreadedPlayer() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
  }
  has_changed_.notify_one();
  thread_.join();
}

/// Opens the device and tells the constructor.
/// @return  null where there is none
std::unique_ptr<AudioOutput> ThreadedPlayer::open_first() noexcept {
  std::unique_ptr<AudioOutput> output;
  std::exception_ptr refusal;
  try {
    output = open_();
    set_status("sound: " + output->device_name());
  } catch (...) {
    output.reset();
    refusal = std::current_exception();
  }
  {
    const std::lock_guard lock(mutex_);
    is_open_ = output != nullptr;
    refusal_ = std::move(refusal);
  }
  has_opened_.notify_one();
  return output;
}

void ThreadedPlayer::set_tone(Tone tone) {
  {
    const std::lock_guard lock(mutex_);
    if (wishes_.tone == tone) {
      return;
    }
    wishes_.tone = tone;
    has_news_ = true;
  }
  has_changed_.notify_one();
}

void ThreadedPlayer::play(Chime chime) {
  {
    const std::lock_guard lock(mutex_);
    if (wishes_.chimes.size() == kMostChimes) {
      return;
    }
    wishes_.chimes.push_back(chime);
    has_news_ = true;
  }
  has_changed_.notify_one();
}

void ThreadedPlayer::change_volume(float volume) {
  {
    const std::lock_guard lock(mutex_);
    if (wishes_.volume == volume) {
      return;
    }
    wishes_.volume = volume;
    has_news_ = true;
  }
  has_changed_.notify_one();
}

const std::string& ThreadedPlayer::status() {
  const std::lock_guard lock(mutex_);
  if (shown_status_ != status_) {
    shown_status_ = status_;
  }
  return shown_status_;
}

void ThreadedPlayer::set_status(std::string status) {
  const std::lock_guard lock(mutex_);
  status_ = std::move(status);
}

/// Waits for news or a time, and takes what is wished for.
/// @return  whether to go on
bool ThreadedPlayer::wait(Clock::time_point until, Wishes& wishes) {
  std::unique_lock lock(mutex_);
  has_changed_.wait_until(lock, until, [&] { return has_news_ || is_ending_; });
  has_news_ = false;
  wishes.tone = wishes_.tone;
  wishes.volume = wishes_.volume;
  wishes.chimes.clear();
  wishes.chimes.swap(wishes_.chimes);  // both keep their capacity
  return !is_ending_;
}

/// @return  null where there is none
std::unique_ptr<AudioOutput> ThreadedPlayer::reopen() const noexcept {
  try {
    return open_();
  } catch (...) {
    return nullptr;
  }
}

void ThreadedPlayer::run(std::unique_ptr<AudioOutput> output) {
  Wishes wishes;
  wishes.chimes.reserve(kMostChimes);
  Clock::time_point next_look = Clock::now() + timing_.check;  // at the device, or for one
  Clock::time_point next = next_look;
  while (wait(next, wishes)) {
    if (Clock::now() >= next_look) {
      if (output == nullptr) {
        output = reopen();
        if (output != nullptr) {
          set_status("sound: " + output->device_name());
        }
      } else if (!output->is_connected()) {
        set_status("no sound: the device '" + output->device_name() +
                   "' was lost; another is looked for");
        output.reset();
      }
      next_look = Clock::now() + (output != nullptr ? timing_.check : timing_.reopen);
    }
    next = next_look;
    if (output == nullptr) {
      continue;
    }
    output->set_volume(wishes.volume);
    for (const Chime chime : wishes.chimes) {
      output->play(chime);
    }
    if (!output->set_tone(wishes.tone)) {
      next = std::min(next, Clock::now() + timing_.retry);
    }
  }
}

}  // namespace cholecystectomy
