// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/haptics/pedal_keyboard.h"

#include <cerrno>
#include <cstring>
#include <string>

#include <linux/input.h>
#include <sys/ioctl.h>
#include <sys/stat.h>

#include "lib/haptics/hotplug_device.h"
#include "lib/haptics/open_device.h"

namespace pbdsurg {
namespace {

constexpr OpenAdvice kAdvice{
    "install the udev rule of docs/rig/pedals.md and plug the pedals in again",
    "plug the pedals in and look for them with ls /dev/input/by-id"};

constexpr int kMostReads = 16;  // of a poll: more than the kernel keeps of a keyboard

void check(const PedalKeys& keys) {
  if (keys.cut > KEY_MAX || keys.coagulation > KEY_MAX || keys.cut == keys.coagulation) {
    throw InvalidArgument("the pedals' keys are " + std::to_string(keys.cut) + " for cut and " +
                          std::to_string(keys.coagulation) +
                          " for coagulation; they must be two, from 1 to " +
                          std::to_string(KEY_MAX) + ", or one and 0");
  }
}

FileDescriptor open_keyboard(const std::filesystem::path& path) {
  FileDescriptor keyboard = open_device(path, kAdvice);
  struct stat status {};
  if (fstat(keyboard.number(), &status) == 0 && S_ISFIFO(status.st_mode)) {
    return keyboard;
  }
  // ENOTTY: it takes no such order. EBUSY: another program grabbed it, and would hear all.
  if (ioctl(keyboard.number(), EVIOCGRAB, 1) != 0) {
    throw FileError(errno == ENOTTY ? path.string() + ": is neither an input device nor a pipe"
                                    : open_refusal(path, errno, kAdvice));
  }
  return keyboard;
}

}  // namespace

PedalKeyboard::PedalKeyboard(const std::filesystem::path& path, const PedalKeys& keys,
                             const Clock& clock)
    : clock_(clock), polled_(clock.now()) {
  check(keys);
  cut_.key = keys.cut;
  coagulation_.key = keys.coagulation;
  keyboard_ = std::make_unique<HotplugDevice>(path, open_keyboard);
}

PedalKeyboard::~PedalKeyboard() = default;

bool PedalKeyboard::is_connected() const noexcept {
  return keyboard_->is_there();
}

bool PedalKeyboard::poll() noexcept {
  const double now = clock_.now();
  cause_ = PedalCause::foot;
  keyboard_->look(now);
  read(now);
  if (now - polled_ > kStall) {
    lift(PedalCause::stall, now);
  }
  polled_ = now;
  cut_.settle(now);
  coagulation_.settle(now);
  return note(now);
}

bool PedalKeyboard::let_go() noexcept {
  const double now = clock_.now();
  lift(PedalCause::let_go, now);
  return note(now);
}

void PedalKeyboard::Switch::settle(double now) noexcept {
  if (is_pressed != is_down && now - changed >= kDebounce) {
    is_down = is_pressed;
    changed = now;
  }
}

void PedalKeyboard::read(double now) noexcept {
  for (int reads = 0; reads < kMostReads; ++reads) {
    const long count = keyboard_->read(bytes_.data() + byte_count_, bytes_.size() - byte_count_);
    if (count < 0) {
      return;
    }
    if (count == 0) {
      byte_count_ = 0;
      lift(PedalCause::disconnected, now);
      return;
    }
    byte_count_ += static_cast<std::size_t>(count);
    std::size_t at = 0;
    for (; at + sizeof(input_event) <= byte_count_; at += sizeof(input_event)) {
      input_event record;
      std::memcpy(&record, bytes_.data() + at, sizeof(record));
      take({record.type, record.code, record.value}, now);
    }
    byte_count_ -= at;
    std::memmove(bytes_.data(), bytes_.data() + at, byte_count_);
  }
}

void PedalKeyboard::take(const Key& key, double now) noexcept {
  if (key.type == EV_SYN && key.code == SYN_DROPPED) {
    lift(PedalCause::overflow, now);
  }
  if (key.type != EV_KEY) {
    return;
  }
  for (Switch* each : {&cut_, &coagulation_}) {
    if (each->key == key.code && key.value != 2) {  // 2 repeats a key that is held
      each->is_pressed = key.value == 1;
      each->settle(now);
    }
  }
}

void PedalKeyboard::lift(PedalCause cause, double now) noexcept {
  for (Switch* each : {&cut_, &coagulation_}) {
    each->is_pressed = false;
    if (each->is_down) {
      each->is_down = false;
      each->changed = now;
      cause_ = cause;
    }
  }
}

bool PedalKeyboard::note(double now) noexcept {
  const Pedals pedals{.cut = cut_.is_down, .coagulation = coagulation_.is_down};
  if (pedals == event_.pedals) {
    return false;
  }
  event_ = {now, pedals, cause_};
  return true;
}

}  // namespace pbdsurg
