// SPDX-License-Identifier: Apache-2.0
#include "lib/haptics/hotplug_device.h"

#include <exception>
#include <utility>

#include "lib/haptics/open_device.h"

namespace pbdsurg {

HotplugDevice::HotplugDevice(std::filesystem::path path, Open open)
    : path_(std::move(path)), open_(open), file_(open(path_)), thread_([this] { seek(); }) {}

HotplugDevice::~HotplugDevice() {
  state_ = State::ended;
  state_.notify_one();
  thread_.join();
}

void HotplugDevice::look(double now) noexcept {
  if (state_ == State::tried) {
    state_ = file_.is_open() ? State::there : State::gone;
  }
  if (state_ == State::gone && now >= next_attempt_) {
    next_attempt_ = now + kRetry;
    state_ = State::sought;
    state_.notify_one();
  }
}

long HotplugDevice::read(void* bytes, std::size_t size) noexcept {
  if (!is_there()) {
    return 0;
  }
  const long count = read_available(file_, bytes, size);
  if (count == 0) {
    state_ = State::gone;
  }
  return count;
}

void HotplugDevice::seek() noexcept {
  for (State state = state_; state != State::ended; state = state_) {
    if (state != State::sought) {
      state_.wait(state);
      continue;
    }
    file_.close();
    try {
      file_ = open_(path_);
    } catch (const std::exception&) {
      // it is not there yet, or not yet allowed: the next attempt will show
    }
    state_.compare_exchange_strong(state, State::tried);  // unless it has ended
  }
}

}  // namespace pbdsurg
